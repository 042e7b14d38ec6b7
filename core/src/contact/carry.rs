//! How the contact moves over the tool between the two ends of a block.

use super::CutterContact;
use crate::geometry::{GreatCircle, Vec3, across};
use crate::machine::Tool;

/// The path of the contact over the tool along one block, by the block's fraction u.
///
/// The normal moves on the great circle **in W**: the surface does not turn with the table. The direction across
/// the tool axis is the normal's projection across the *actual* axis.
#[derive(Debug, Clone, Copy)]
pub enum Carry {
    /// The tip is used as the contact.
    Tip,
    /// By the normal.
    Normal {
        /// n from start to end.
        normal: GreatCircle,
        /// |n| at start and end.
        magnitude: [f64; 2],
    },
    /// As a carried offset: the axial and radial lengths change linearly, the inward direction follows its great
    /// circle.
    Offset {
        /// Along t at start and end \[mm\].
        axial_mm: [f64; 2],
        /// Away from t at start and end \[mm\].
        radial_mm: [f64; 2],
        /// m from start to end.
        inward: GreatCircle,
    },
}

/// The contact relative to the tip at one instant.
#[derive(Debug, Clone, Copy)]
pub struct CarriedContact {
    /// `c − w` \[mm\].
    pub offset_mm: Vec3,
    /// The surface normal, if the carry has one.
    pub normal: Option<Vec3>,
}

/// A projection across the axis shorter than this has no direction.
const NO_DIRECTION: f64 = 1e-12;

impl Carry {
    /// The carry between two contacts; `axes` are the tool axes at start and end.
    #[must_use]
    pub fn between(tool: &Tool, contacts: [&CutterContact; 2], axes: [Vec3; 2]) -> Self {
        match contacts {
            [CutterContact::Tip, _] | [_, CutterContact::Tip] => Self::Tip,
            [
                CutterContact::Normal { direction: a, magnitude: from },
                CutterContact::Normal { direction: b, magnitude: to },
            ] => Self::Normal { normal: GreatCircle::between(*a, *b, axes[0]), magnitude: [*from, *to] },
            _ => {
                let [(a0, r0, mut m0), (a1, r1, mut m1)] =
                    [as_offset(tool, contacts[0], axes[0]), as_offset(tool, contacts[1], axes[1])];
                // A contact on the tool's own axis is on no side: it takes the side of the other end.
                if r0 < CutterContact::ON_AXIS_MM {
                    m0 = m1;
                } else if r1 < CutterContact::ON_AXIS_MM {
                    m1 = m0;
                }
                Self::Offset {
                    axial_mm: [a0, a1],
                    radial_mm: [r0, r1],
                    inward: GreatCircle::between(m0, m1, axes[0]),
                }
            }
        }
    }

    /// The contact at fraction `u` of the block with the actual tool axis there.
    #[must_use]
    pub fn at(&self, tool: &Tool, u: f64, axis: Vec3) -> CarriedContact {
        let (corner, core) = (tool.corner_radius().mm(), tool.core_radius().mm());
        match self {
            Self::Tip => CarriedContact { offset_mm: Vec3::zeros(), normal: None },
            Self::Normal { normal, magnitude } => {
                let n = normal.at(u);
                let scaled = n * lerp(magnitude, u);
                let mut offset_mm = (axis - scaled) * corner;
                if core > 0.0 {
                    offset_mm -= project(n, axis) * core;
                }
                CarriedContact { offset_mm, normal: Some(n) }
            }
            Self::Offset { axial_mm, radial_mm, inward } => {
                let m = project(inward.at(u), axis);
                let (axial, radial) = (lerp(axial_mm, u), lerp(radial_mm, u));
                // On the flat end the normal is the axis.
                let toward_corner = axis * (corner - axial) + m * (radial - core).max(0.0);
                let normal = if corner > 0.0 { toward_corner.try_normalize(NO_DIRECTION) } else { None };
                CarriedContact { offset_mm: axis * axial - m * radial, normal }
            }
        }
    }
}

/// `a + u (b − a)`, exact at both ends.
fn lerp(ends: &[f64; 2], u: f64) -> f64 {
    ends[0] * (1.0 - u) + ends[1] * u
}

fn project(v: Vec3, axis: Vec3) -> Vec3 {
    across(v, axis).try_normalize(NO_DIRECTION).unwrap_or_else(Vec3::zeros)
}

fn as_offset(tool: &Tool, contact: &CutterContact, axis: Vec3) -> (f64, f64, Vec3) {
    match contact {
        CutterContact::Offset { axial_mm, radial_mm, inward } => (*axial_mm, *radial_mm, *inward),
        CutterContact::Tip => (0.0, 0.0, project(perpendicular(axis), axis)),
        CutterContact::Normal { direction, magnitude } => {
            let (corner, core) = (tool.corner_radius().mm(), tool.core_radius().mm());
            let scaled = direction * (corner * magnitude);
            let inward = across(*direction, axis)
                .try_normalize(NO_DIRECTION)
                .unwrap_or_else(|| project(perpendicular(axis), axis));
            let axial = corner - scaled.dot(&axis);
            (axial, across(scaled, axis).norm() + core, inward)
        }
    }
}

fn perpendicular(axis: Vec3) -> Vec3 {
    if axis.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() }
}
