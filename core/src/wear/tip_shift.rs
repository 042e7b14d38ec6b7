//! How far the tip moves so that a worn cutter touches where the nominal one would.

use thiserror::Error;

use crate::geometry::{Vec3, angle_between};
use crate::units::Length;

/// Where the programmed tip goes for the worn cutter, in W; the tool axis stays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TipShift {
    /// Δ, from the nominal tip to that of the worn cutter \[mm\].
    pub shift_mm: Vec3,
    /// What is to be said of the contact.
    pub note: Option<FlatContact>,
}

/// A contact on the flat end of a cutter, or next to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FlatContact {
    /// n ∥ t: the whole flat touches, no side is told from another, and Δ is 0 but for the length.
    Whole,
    /// So near to it that the side follows from the last digits of the normal.
    Nearly {
        /// Angle between normal and tool axis \[rad\].
        angle_rad: f64,
    },
}

/// Why a contact cannot be kept.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ShiftFault {
    /// A normal without a direction.
    #[error("the contact normal has length {length}")]
    ZeroNormal {
        /// Length given.
        length: f64,
    },
    /// The surface looks away from the tool.
    #[error("the contact normal points {angle_deg:.3}° away from the tool axis: an undercut")]
    Undercut {
        /// Angle between normal and tool axis \[deg\].
        angle_deg: f64,
    },
    /// Side milling with a normal that is not across the tool axis.
    #[error(
        "side milling needs a normal across the tool axis: n·t is {cosine:.6}, at most {max} in magnitude"
    )]
    NotFlank {
        /// n·t.
        cosine: f64,
        /// Largest magnitude accepted.
        max: f64,
    },
    /// A stated contact point so deep inside the cutter, or on its axis, that it has no normal.
    #[error("the contact point lies {off_tool_mm:.3} mm off the cutter and has no normal there")]
    NoNormal {
        /// Distance from the cutter's surface \[mm\].
        off_tool_mm: f64,
    },
    /// A contact point on the sharp edge of a flat cutter, whose normal only the part knows.
    #[error(
        "a contact point on the edge of a flat cutter has no one normal, and a corner of {corner_mm} mm needs it"
    )]
    EdgeWithoutNormal {
        /// r′ \[mm\].
        corner_mm: f64,
    },
    /// A contact outside the angles of the wear table.
    #[error("a contact angle of {angle_deg:.3}° lies beyond the wear table, which ends at {max_deg:.3}°")]
    BeyondTable {
        /// Angle between normal and tool axis \[deg\].
        angle_deg: f64,
        /// Last angle of the table \[deg\].
        max_deg: f64,
    },
}

/// Cosine between normal and tool axis below which the contact is an undercut: three-decimal contact words on a 1 mm
/// radius turn a normal across the axis by this much.
const UNDERCUT_COSINE: f64 = -1e-3;

/// The unit normal of a contact that a cutter can make.
pub(super) fn checked_normal(axis: Vec3, normal: Vec3) -> Result<Vec3, ShiftFault> {
    let direction = unit(normal)?;
    if direction.dot(&axis) < UNDERCUT_COSINE {
        return Err(ShiftFault::Undercut { angle_deg: angle_between(direction, axis).to_degrees() });
    }
    Ok(direction)
}

/// The direction of a normal of any length.
pub(super) fn unit(normal: Vec3) -> Result<Vec3, ShiftFault> {
    let length = normal.norm();
    if !(length > f64::MIN_POSITIVE && length.is_finite()) {
        return Err(ShiftFault::ZeroNormal { length });
    }
    Ok(normal / length)
}

/// What a control that keeps the nominal length misses: −ΔL·t \[mm\].
pub(super) fn length_shift_mm(shorter_by: Length, axis: Vec3) -> Vec3 {
    axis * -shorter_by.mm()
}
