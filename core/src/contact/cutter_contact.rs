//! The cutter-contact point on a tool (R, r): from a normal, from a point, from the feed direction.

use thiserror::Error;

use crate::geometry::{Vec3, across, angle_between};
use crate::kinematics::ToolPose;
use crate::machine::Tool;

/// A normal this close to the tool axis leaves the direction across it undetermined \[rad\]: there the rounding of
/// six decimals turns that direction by a tenth of a radian.
const OPEN_ANGLE_RAD: f64 = 1e-5;
/// Cosine between normal and tool axis below which the contact is an undercut: three-decimal contact words on a
/// 1 mm radius turn a side-milling normal by this much.
const UNDERCUT_COSINE: f64 = -1e-3;

/// The point at which a tool touches the part at one program point, relative to the tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CutterContact {
    /// On the tool, by its surface normal. `magnitude` (1 except for rounding) keeps the stated point exact.
    Normal {
        /// Unit normal out of the part, in W.
        direction: Vec3,
        /// |n| as the stated point gives it.
        magnitude: f64,
    },
    /// Carried unchanged: `c = w + axial·t − radial·inward`.
    Offset {
        /// Along the tool axis \[mm\].
        axial_mm: f64,
        /// Away from the tool axis \[mm\].
        radial_mm: f64,
        /// Unit, across t, from the contact toward the axis (m of the shared notation).
        inward: Vec3,
    },
    /// The tool tip itself is used as the contact.
    Tip,
}

impl CutterContact {
    /// A contact this close to the tool's axis is on no side of it \[mm\].
    pub const ON_AXIS_MM: f64 = 5e-6;

    /// The contact relative to the tip, `c − w` \[mm\], with the tool axis at that point.
    #[must_use]
    #[inline]
    pub fn offset_mm(&self, tool: &Tool, axis: Vec3) -> Vec3 {
        match self {
            Self::Tip => Vec3::zeros(),
            Self::Offset { axial_mm, radial_mm, inward } => axis * *axial_mm - inward * *radial_mm,
            Self::Normal { direction, magnitude } => {
                let (corner, core) = (tool.corner_radius().mm(), tool.core_radius().mm());
                let mut offset_mm = (axis - direction * *magnitude) * corner;
                if core > 0.0 {
                    offset_mm -= across(*direction, axis).normalize() * core;
                }
                offset_mm
            }
        }
    }
}

/// A contact, with the facts that a report needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// The contact of the tool.
    pub contact: CutterContact,
    /// Distance of the stated point from the tool's surface \[mm\]; 0 if it is on the surface by construction.
    pub off_tool_mm: f64,
    /// The normal lies along the axis of a bull-nose or flat cutter. Its whole flat touches, on no side, and the
    /// tip is used as the contact.
    pub is_open: bool,
}

/// Why a stated contact is not valid.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ContactFault {
    /// The surface faces away from the tool: an undercut.
    #[error(
        "the contact normal is {angle_deg:.3}° from the tool axis, more than 90°: an undercut; check the sign of the normal or the tool axis"
    )]
    Undercut {
        /// Angle between normal and tool axis \[deg\].
        angle_deg: f64,
    },
    /// A normal without a direction.
    #[error("the contact normal has length {length}; give a normal with a direction")]
    ZeroNormal {
        /// Length given.
        length: f64,
    },
}

impl Touch {
    /// A contact point this close to the tool's surface is on it \[mm\]: ten times what four decimals and five axes can
    /// round away.
    pub const ON_TOOL_MM: f64 = 0.005;

    /// The tool tip is used as the contact.
    pub const TIP: Self = Self { contact: CutterContact::Tip, off_tool_mm: 0.0, is_open: false };

    /// The contact of `tool` at a point where the part's normal is `normal` (any length), in W.
    ///
    /// # Errors
    /// A zero normal, or one that points away from the tool (n·t < 0, an undercut).
    #[inline]
    pub fn from_normal(tool: &Tool, pose: &ToolPose, normal: Vec3) -> Result<Self, ContactFault> {
        let length = normal.norm();
        if !(length > f64::MIN_POSITIVE && length.is_finite()) {
            return Err(ContactFault::ZeroNormal { length });
        }
        let direction = normal / length;
        check_undercut(direction, pose.axis)?;
        if !tool.is_ball() && angle_between(direction, pose.axis) < OPEN_ANGLE_RAD {
            return Ok(Self { is_open: true, ..Self::TIP });
        }
        let contact = CutterContact::Normal { direction, magnitude: 1.0 };
        Ok(Self { contact, off_tool_mm: 0.0, is_open: false })
    }

    /// The contact of `tool` stated by the point `contact_mm` in W (§2 "Back from a contact point"): by its normal
    /// if the point is on a corner of the tool, otherwise as a carried offset.
    ///
    /// # Errors
    /// A point on the tool whose normal points away from it (n·t < 0, an undercut).
    pub fn from_point(tool: &Tool, pose: &ToolPose, contact_mm: Vec3) -> Result<Self, ContactFault> {
        let (corner, core) = (tool.corner_radius().mm(), tool.core_radius().mm());
        let to_tip = pose.tip_mm - contact_mm;
        let radial = across(to_tip, pose.axis);
        let (axial_mm, radial_mm) = (-to_tip.dot(&pose.axis), radial.norm());
        let open = radial_mm < CutterContact::ON_AXIS_MM;
        let inward = if open { any_side(pose.axis) } else { radial / radial_mm };
        let carried = |off_tool_mm| Self {
            contact: CutterContact::Offset { axial_mm, radial_mm, inward },
            off_tool_mm,
            is_open: false,
        };
        if core > 0.0 && (radial_mm <= core || corner == 0.0) {
            // On or above the flat end, or off the edge of a flat cutter.
            let beside_mm = (radial_mm - core).max(0.0);
            return Ok(carried((axial_mm * axial_mm + beside_mm * beside_mm).sqrt()));
        }
        let scaled_normal = to_tip + pose.axis * corner - inward * core;
        let length = scaled_normal.norm();
        let off_tool_mm = (length - corner).abs();
        // Nearer to the corner's centre than to its surface, a normal is not meaningful.
        if off_tool_mm > Self::ON_TOOL_MM || length < 0.5 * corner {
            return Ok(carried(off_tool_mm));
        }
        let direction = scaled_normal / length;
        check_undercut(direction, pose.axis)?;
        let contact = CutterContact::Normal { direction, magnitude: length / corner };
        Ok(Self { contact, off_tool_mm, is_open: false })
    }
}

#[inline]
fn check_undercut(direction: Vec3, axis: Vec3) -> Result<(), ContactFault> {
    if direction.dot(&axis) < UNDERCUT_COSINE {
        return Err(ContactFault::Undercut { angle_deg: angle_between(direction, axis).to_degrees() });
    }
    Ok(())
}

/// A side for a contact on the tool's own axis, which has none: the same side for the same axis.
fn any_side(axis: Vec3) -> Vec3 {
    across(Vec3::x(), axis)
        .try_normalize(0.1)
        .or_else(|| across(Vec3::y(), axis).try_normalize(0.1))
        .unwrap_or_else(Vec3::x)
}
