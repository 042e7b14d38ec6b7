//! The shift of the tip with which a worn cutter touches where the nominal cutter would.

use thiserror::Error;

use crate::geometry::{Vec3, angle_between};
use crate::units::Length;

/// The new position of the programmed tip for the worn cutter, in W. The tool axis does not change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TipShift {
    /// Δ, from the nominal tip to the worn cutter's tip \[mm\].
    pub shift_mm: Vec3,
    /// A note on the contact.
    pub note: Option<FlatContact>,
}

/// A contact on the flat end of a cutter, or next to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FlatContact {
    /// n ∥ t: the whole flat touches, no side can be distinguished, and Δ is only the length difference.
    Whole,
    /// So near to it that the side depends on the last digits of the normal.
    Nearly {
        /// Angle between normal and tool axis \[rad\].
        angle_rad: f64,
    },
}

/// Why a contact cannot be kept.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ShiftFault {
    /// A normal without a direction.
    #[error("the contact normal has length {length}; give a normal with a direction")]
    ZeroNormal {
        /// The length given.
        length: f64,
    },
    /// The surface faces away from the tool.
    #[error(
        "the contact normal is {angle_deg:.3}° from the tool axis, more than 90°: an undercut; check the sign of the normal or the tool axis"
    )]
    Undercut {
        /// Angle between normal and tool axis \[deg\].
        angle_deg: f64,
    },
    /// Side milling with a normal that is not across the tool axis.
    #[error(
        "side milling needs a normal across the tool axis: n·t is {cosine:.6}, but its magnitude must be at most {max}"
    )]
    NotFlank {
        /// n·t.
        cosine: f64,
        /// Largest magnitude accepted.
        max: f64,
    },
    /// A stated contact point without a normal, because it is deep inside the cutter or on its axis.
    #[error(
        "the contact point is {off_tool_mm:.3} mm off the cutter's surface and has no normal there; state a point on the cutter, or the normal"
    )]
    NoNormal {
        /// Distance from the cutter's surface \[mm\].
        off_tool_mm: f64,
    },
    /// A contact point on the sharp edge of a flat cutter. Only the part gives its normal.
    #[error(
        "a contact point on the edge of a flat cutter has more than one normal, but a corner of {corner_mm} mm needs one; state the normal"
    )]
    EdgeWithoutNormal {
        /// r′ \[mm\].
        corner_mm: f64,
    },
    /// A contact angle beyond the wear table.
    #[error(
        "a contact angle of {angle_deg:.3}° is beyond the end of the wear table at {max_deg:.3}°; extend the table"
    )]
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

/// The unit normal of a possible contact.
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

/// The shift missing in a control that keeps the nominal length: −ΔL·t \[mm\].
pub(super) fn length_shift_mm(shorter_by: Length, axis: Vec3) -> Vec3 {
    axis * -shorter_by.mm()
}
