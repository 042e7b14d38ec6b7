//! The deviation in the middle of a block and a bound on the whole block, without trigonometry. This is enough for
//! most blocks of most programs.

use super::curvature::{Swing, curvature_bound_mm};
use super::{ContactLine, CutterContact, Deviation, Station};
use crate::geometry::{Vec3, across};
use crate::kinematics::{Kinematics, ToolPose};
use crate::machine::Tool;
use crate::motion::Interpolation;

/// With the ends on the line and one sample in the middle, the true maximum exceeds that sample by at most this share
/// of `|c″|`: `1/(8·2²)`.
pub(super) const MIDPOINT_SLACK: f64 = 1.0 / 32.0;
/// Chords up to this long bound their arc by `chord·(1 + chord²/20)`.
const SHORT_CHORD: f64 = 1.0;
/// A vector shorter than this has no direction.
const NO_DIRECTION: f64 = 1e-9;

/// The result of one look at a block.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QuickLook {
    /// The deviation in the middle.
    pub middle: Deviation,
    /// Bound on the deviation of every point of the block \[mm\].
    pub at_most_mm: f64,
}

impl QuickLook {
    /// Whether the middle is enough for the whole block: the bound leaves open no more than the deviation seen, or
    /// than `negligible_mm`. An S-shaped deviation is zero in the middle and fails this.
    #[must_use]
    pub fn is_telling(&self, negligible_mm: f64) -> bool {
        let open_mm = self.at_most_mm - self.middle.distance_mm;
        // False without numbers.
        open_mm <= self.middle.distance_mm.max(negligible_mm)
    }
}

/// A look at the block between two stations with the contacts `contacts` at the points `contacts_mm`. `middle` is
/// the tool's pose half way. The middle of the great circle between two normals is their normalised sum.
///
/// `None` if the short cut does not hold (mixed kinds of contact, normals far apart, contact near the tool axis):
/// the block has to be sampled.
#[must_use]
#[inline]
pub fn quick_look(
    kinematics: &Kinematics,
    tool: &Tool,
    mode: Interpolation,
    ends: [&Station; 2],
    contacts: [&CutterContact; 2],
    contacts_mm: [Vec3; 2],
    middle: &ToolPose,
) -> Option<QuickLook> {
    let (corner, core) = (tool.corner_radius().mm(), tool.core_radius().mm());
    let t = middle.axis;
    // Called inside each branch, so that the compiler knows the kind of swing there.
    let bound_mm = |swing: &Swing| curvature_bound_mm(kinematics, tool, mode, ends, swing);
    let (bound_mm, offset_mm, normal) = match contacts {
        [CutterContact::Tip, CutterContact::Tip] => (bound_mm(&Swing::Tip)?, Vec3::zeros(), None),
        [
            CutterContact::Normal { direction: a, magnitude: from },
            CutterContact::Normal { direction: b, magnitude: to },
        ] => {
            let (arc_rad, n) = halfway(a, b)?;
            let mut offset_mm = (t - n * (0.5 * (from + to))) * corner;
            if core > 0.0 {
                offset_mm -= across(n, t).try_normalize(NO_DIRECTION)? * core;
            }
            let swing = Swing::Normal { arc_rad, directions: [*a, *b], magnitude: [*from, *to] };
            (bound_mm(&swing)?, offset_mm, Some(n))
        }
        [
            CutterContact::Offset { axial_mm: a0, radial_mm: r0, inward: m0 },
            CutterContact::Offset { axial_mm: a1, radial_mm: r1, inward: m1 },
        ] => {
            if r0.min(*r1) < CutterContact::ON_AXIS_MM {
                return None;
            }
            let (arc_rad, m) = halfway(m0, m1)?;
            let m = across(m, t).try_normalize(NO_DIRECTION)?;
            let (axial, radial) = (0.5 * (a0 + a1), 0.5 * (r0 + r1));
            let toward_corner = t * (corner - axial) + m * (radial - core).max(0.0);
            let normal = if corner > 0.0 { toward_corner.try_normalize(NO_DIRECTION) } else { None };
            let swing = Swing::Offset {
                arc_rad,
                directions: [*m0, *m1],
                axial_mm: [*a0, *a1],
                radial_mm: [*r0, *r1],
            };
            (bound_mm(&swing)?, t * axial - m * radial, normal)
        }
        _ => return None,
    };
    let contact_mm = middle.tip_mm + offset_mm;
    let line = ContactLine::new(contacts_mm[0], contacts_mm[1]);
    let off_line = contact_mm - line.foot_mm(contact_mm);
    let middle =
        Deviation { distance_mm: off_line.norm(), along_normal_mm: normal.map_or(0.0, |n| n.dot(&off_line)) };
    Some(QuickLook { middle, at_most_mm: middle.distance_mm + MIDPOINT_SLACK * bound_mm })
}

/// An upper bound on the angle between two unit vectors, and the direction half way; `None` if they are far apart.
#[inline]
fn halfway(a: &Vec3, b: &Vec3) -> Option<(f64, Vec3)> {
    let chord = (b - a).norm();
    if chord > SHORT_CHORD {
        return None;
    }
    let sum = a + b;
    Some((chord * (1.0 + 0.05 * chord * chord), sum / sum.norm()))
}
