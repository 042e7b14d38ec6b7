//! The contact of a nominal cutter stated as a point, for example by U V W words.

use super::tip_shift::{checked_normal, length_shift_mm};
use super::{CutterWear, FlatContact, ShiftFault, TipShift, end_milling_shift, side_milling_shift};
use crate::contact::{ContactFault, CutterContact, Touch};
use crate::geometry::{Vec3, across};
use crate::kinematics::ToolPose;
use crate::machine::Tool;

/// A shift from a stated contact point, and the distance of that point from the stated cutter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedShift {
    /// The shift.
    pub shift: TipShift,
    /// Distance of the point from the nominal cutter's surface \[mm\]. Above [`Touch::ON_TOOL_MM`] it needs a
    /// warning.
    pub off_tool_mm: f64,
}

/// The part of a cutter to which a stated contact point belongs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StatedSide {
    /// The corner, by its unit normal there, in W.
    Corner {
        /// Out of the part.
        normal: Vec3,
    },
    /// The flat end.
    Flat,
    /// The sharp edge of a flat cutter, which has more than one normal.
    Edge {
        /// Unit, across t, from the contact toward the axis.
        inward: Vec3,
    },
}

/// The part of the nominal cutter at `pose` that is nearest to `contact_mm` in W, and the distance from it \[mm\].
///
/// # Errors
/// A point on the side away from the part (an undercut), or a point without a normal.
pub fn stated_side(
    nominal: &Tool,
    pose: &ToolPose,
    contact_mm: Vec3,
) -> Result<(StatedSide, f64), ShiftFault> {
    let axis = pose.axis;
    let touch = Touch::from_point(nominal, pose, contact_mm).map_err(|fault| match fault {
        ContactFault::Undercut { angle_deg } => ShiftFault::Undercut { angle_deg },
        ContactFault::ZeroNormal { length } => ShiftFault::ZeroNormal { length },
    })?;
    let off_tool_mm = touch.off_tool_mm;
    let (axial_mm, radial_mm, inward) = match touch.contact {
        CutterContact::Normal { direction, .. } => {
            let normal = checked_normal(axis, direction)?;
            return Ok((StatedSide::Corner { normal }, off_tool_mm));
        }
        CutterContact::Offset { axial_mm, radial_mm, inward } => (axial_mm, radial_mm, inward),
        CutterContact::Tip => return Err(ShiftFault::NoNormal { off_tool_mm }),
    };
    let (corner, core) = (nominal.corner_radius().mm(), nominal.core_radius().mm());
    if corner == 0.0 && radial_mm > core - Touch::ON_TOOL_MM {
        return Ok((StatedSide::Edge { inward }, off_tool_mm));
    }
    if core > 0.0 && radial_mm <= core {
        return Ok((StatedSide::Flat, off_tool_mm));
    }
    let scaled_normal = inward * (radial_mm - core) + axis * (corner - axial_mm);
    if scaled_normal.norm() < 0.5 * corner {
        return Err(ShiftFault::NoNormal { off_tool_mm });
    }
    Ok((StatedSide::Corner { normal: checked_normal(axis, scaled_normal)? }, off_tool_mm))
}

/// [`end_milling_shift`] for the nominal cutter at `pose` touching at `contact_mm` in W. A point off the cutter
/// takes the normal of the nearest point of its corner, and is reported with its distance.
///
/// # Errors
/// A point on the side away from the part (an undercut), a point without a normal, or a point on the edge of a flat
/// cutter if the worn one has a corner radius.
pub fn end_milling_shift_at(
    wear: &CutterWear,
    pose: &ToolPose,
    contact_mm: Vec3,
) -> Result<StatedShift, ShiftFault> {
    let (side, off_tool_mm) = stated_side(&wear.nominal, pose, contact_mm)?;
    let shift = match side {
        StatedSide::Corner { normal } => end_milling_shift(wear, pose.axis, normal)?,
        StatedSide::Flat => {
            let note = Some(FlatContact::Whole);
            TipShift { shift_mm: length_shift_mm(wear.shorter_by, pose.axis), note }
        }
        StatedSide::Edge { inward } => edge(wear, pose.axis, inward)?,
    };
    Ok(StatedShift { shift, off_tool_mm })
}

/// On the sharp edge of a flat cutter only the side is known, and only another sharp edge can be put there.
fn edge(wear: &CutterWear, axis: Vec3, inward: Vec3) -> Result<TipShift, ShiftFault> {
    let corner_mm = wear.actual.corner_radius().mm();
    if corner_mm > 0.0 {
        return Err(ShiftFault::EdgeWithoutNormal { corner_mm });
    }
    let shift_mm = inward * wear.core_change_mm() + length_shift_mm(wear.shorter_by, axis);
    Ok(TipShift { shift_mm, note: None })
}

/// [`side_milling_shift`] for the flank of the nominal cutter at `pose` touching at `contact_mm` in W. The normal
/// is the direction from the point to the axis.
///
/// # Errors
/// A point on the tool axis.
pub fn side_milling_shift_at(
    wear: &CutterWear,
    pose: &ToolPose,
    contact_mm: Vec3,
) -> Result<StatedShift, ShiftFault> {
    let to_tip = pose.tip_mm - contact_mm;
    let radial = across(to_tip, pose.axis);
    let radial_mm = radial.norm();
    let off_tool_mm = off_flank_mm(&wear.nominal, -to_tip.dot(&pose.axis), radial_mm);
    if radial_mm < CutterContact::ON_AXIS_MM {
        return Err(ShiftFault::NoNormal { off_tool_mm });
    }
    let shift = side_milling_shift(wear, pose.axis, radial)?;
    Ok(StatedShift { shift, off_tool_mm })
}

/// Distance from the flank, which begins above the corner \[mm\].
fn off_flank_mm(tool: &Tool, axial_mm: f64, radial_mm: f64) -> f64 {
    (radial_mm - tool.radius().mm()).hypot((tool.corner_radius().mm() - axial_mm).max(0.0))
}
