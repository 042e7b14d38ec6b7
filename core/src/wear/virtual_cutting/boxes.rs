//! Boxes along the axes of W, to exclude pairs that cannot meet.

use crate::geometry::Vec3;

/// A box along the axes; it may be empty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct AxisBox {
    /// Smallest corner \[mm\].
    pub(super) low_mm: Vec3,
    /// Largest corner \[mm\].
    pub(super) high_mm: Vec3,
}

impl AxisBox {
    /// An empty box, which meets nothing.
    pub(super) const NOTHING: Self = Self {
        low_mm: Vec3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high_mm: Vec3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// Extends the box to include a point.
    #[inline]
    pub(super) fn take(&mut self, point_mm: Vec3) {
        self.low_mm = self.low_mm.inf(&point_mm);
        self.high_mm = self.high_mm.sup(&point_mm);
    }

    /// Extends the box to include another box.
    #[inline]
    pub(super) fn join(&mut self, other: &Self) {
        self.low_mm = self.low_mm.inf(&other.low_mm);
        self.high_mm = self.high_mm.sup(&other.high_mm);
    }

    /// Whether the boxes have a point in common.
    #[inline]
    pub(super) fn meets(&self, other: &Self) -> bool {
        self.low_mm.x <= other.high_mm.x
            && self.low_mm.y <= other.high_mm.y
            && self.low_mm.z <= other.high_mm.z
            && other.low_mm.x <= self.high_mm.x
            && other.low_mm.y <= self.high_mm.y
            && other.low_mm.z <= self.high_mm.z
    }

    /// The middle.
    pub(super) fn centre_mm(&self) -> Vec3 {
        (self.low_mm + self.high_mm) * 0.5
    }
}
