//! The distance of the contact point from its line (P0 eq. (12)).

use super::{Segment, SourceBlock};
use crate::geometry::Vec3;

/// The line the contact point should follow during a block, in W.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLine {
    /// Contact at the start `c_s` \[mm\].
    pub start_mm: Vec3,
    /// `l = c_e − c_s` \[mm\].
    pub along_mm: Vec3,
    /// |l| \[mm\].
    pub length_mm: f64,
}

/// A line shorter than this is a point. The deviation is then the distance from that point \[mm\].
const POINT_LENGTH_MM: f64 = 1e-9;

impl ContactLine {
    /// The line between two contact points.
    #[must_use]
    pub fn new(start_mm: Vec3, end_mm: Vec3) -> Self {
        let along_mm = end_mm - start_mm;
        Self { start_mm, along_mm, length_mm: along_mm.norm() }
    }

    /// The point of the line nearest to `point_mm` (the whole line, not only the stretch between its ends).
    #[must_use]
    pub fn foot_mm(&self, point_mm: Vec3) -> Vec3 {
        if self.length_mm < POINT_LENGTH_MM {
            return self.start_mm;
        }
        let direction = self.along_mm / self.length_mm;
        self.start_mm + direction * direction.dot(&(point_mm - self.start_mm))
    }

    /// The point at the fraction `u` of the line.
    #[must_use]
    pub fn at_mm(&self, u: f64) -> Vec3 {
        self.start_mm + self.along_mm * u
    }
}

/// The contact point's distance from its line at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// ε \[mm\], never negative.
    pub distance_mm: f64,
    /// The part of it along the surface normal \[mm\]: + excess, − gouge. 0 if no normal is known.
    pub along_normal_mm: f64,
}

impl SourceBlock<'_> {
    /// The deviation at `s` in [0, 1] of a segment of this block.
    #[must_use]
    pub fn deviation_at(&self, segment: &Segment, s: f64) -> Deviation {
        let [from, to] = segment.fraction;
        let pose = self.pose_at(segment, s);
        let carried = self.carry.at(&self.tool, from + (to - from) * s, pose.axis);
        let contact_mm = pose.tip_mm + carried.offset_mm;
        let off_line = contact_mm - self.line.foot_mm(contact_mm);
        Deviation {
            distance_mm: off_line.norm(),
            along_normal_mm: carried.normal.map_or(0.0, |n| n.dot(&off_line)),
        }
    }
}
