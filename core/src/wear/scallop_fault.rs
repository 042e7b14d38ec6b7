//! Why there is no scallop height, or no inverse of it.

use thiserror::Error;

use crate::units::legible;

/// The quantity of a scallop that has a fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ScallopQuantity {
    /// D, the chord between neighbouring contact points.
    Stepover,
    /// r, the radius of the ball, or the effective radius.
    ToolRadius,
    /// Rs, the radius of the surface.
    SurfaceRadius,
    /// The allowed h.
    AllowedHeight,
}

/// Why there is no scallop height, or no inverse of it. Every bound is in the message.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ScallopFault {
    /// Not a number, or not plausible for a cut.
    #[error("{value_mm:e} mm is not between {min_mm:e} mm and {max_mm:e} mm")]
    OutOfRange {
        /// The quantity.
        quantity: ScallopQuantity,
        /// Its value \[mm\].
        value_mm: f64,
        /// Smallest accepted \[mm\].
        min_mm: f64,
        /// Largest accepted \[mm\].
        max_mm: f64,
    },
    /// A concave surface narrower than the tool.
    #[error(
        "a tool that cuts with a radius of {0} mm gouges a concave surface of radius {1} mm; the tool's radius must be at most {1} mm", legible(.tool_radius_mm), legible(.surface_radius_mm))]
    Gouge {
        /// r \[mm\].
        tool_radius_mm: f64,
        /// Rs \[mm\].
        surface_radius_mm: f64,
    },
    /// Neighbouring passes leave a strip uncut between them (w > r).
    #[error(
        "at a step-over of {} mm neighbouring passes do not meet; the limit is {} mm; reduce the step-over", legible(.stepover_mm), legible(.max_stepover_mm))]
    PassesDoNotMeet {
        /// D \[mm\].
        stepover_mm: f64,
        /// Largest D at which they do \[mm\].
        max_stepover_mm: f64,
    },
    /// A chord longer than the surface's diameter.
    #[error(
        "a step-over of {} mm is longer than any chord of a surface of this radius; the limit is {} mm; reduce the step-over", legible(.stepover_mm), legible(.max_stepover_mm))]
    NoChord {
        /// D \[mm\].
        stepover_mm: f64,
        /// 2 Rs \[mm\].
        max_stepover_mm: f64,
    },
}

impl ScallopFault {
    /// The number to change first.
    #[must_use]
    pub const fn quantity(&self) -> ScallopQuantity {
        match self {
            Self::OutOfRange { quantity, .. } => *quantity,
            Self::Gouge { .. } => ScallopQuantity::ToolRadius,
            Self::PassesDoNotMeet { .. } | Self::NoChord { .. } => ScallopQuantity::Stepover,
        }
    }
}
