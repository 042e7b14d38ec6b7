//! The cutter a program was made for, and the one in the spindle.

use crate::machine::Tool;
use crate::units::Length;

/// A worn or reground cutter against the nominal one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutterWear {
    /// The cutter (R, r) the program was made for.
    pub nominal: Tool,
    /// The cutter (R′, r′) that cuts.
    pub actual: Tool,
    /// ΔL = L − L′ where the control keeps the nominal length; 0 where it has the measured one.
    pub shorter_by: Length,
}

impl CutterWear {
    /// A worn cutter whose own length stands in the control.
    #[must_use]
    pub const fn new(nominal: Tool, actual: Tool) -> Self {
        Self { nominal, actual, shorter_by: Length::ZERO }
    }

    /// r′ − r \[mm\], negative for a worn corner.
    pub(super) fn corner_change_mm(&self) -> f64 {
        (self.actual.corner_radius() - self.nominal.corner_radius()).mm()
    }

    /// (R′ − r′) − (R − r) \[mm\].
    pub(super) fn core_change_mm(&self) -> f64 {
        (self.actual.core_radius() - self.nominal.core_radius()).mm()
    }

    /// R′ − R \[mm\], negative for a worn flank.
    pub(super) fn radius_change_mm(&self) -> f64 {
        (self.actual.radius() - self.nominal.radius()).mm()
    }

    /// Whether both are balls: then no contact is that of a flat.
    pub(super) fn has_no_flat(&self) -> bool {
        self.nominal.is_ball() && self.actual.is_ball()
    }
}
