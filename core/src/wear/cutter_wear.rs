//! The cutter for which a program was made, and the cutter in the spindle.

use crate::machine::Tool;
use crate::units::Length;

/// A worn or reground cutter compared with the nominal one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutterWear {
    /// The cutter (R, r) for which the program was made.
    pub nominal: Tool,
    /// The cutter (R′, r′) that cuts.
    pub actual: Tool,
    /// ΔL = L − L′ if the control keeps the nominal length; 0 if it has the measured one.
    pub shorter_by: Length,
}

impl CutterWear {
    /// A worn cutter whose own length is in the control.
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

    /// Whether both are balls. A contact on a flat is then impossible.
    pub(super) fn has_no_flat(&self) -> bool {
        self.nominal.is_ball() && self.actual.is_ball()
    }
}
