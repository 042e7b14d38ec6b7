//! Finds where the nominal cutter touches at a point, and how far the tip moves so that the worn cutter touches
//! there. Also finds where a cutter at a given pose really touches.

use super::parameters::{Milling, WornCutter};
use super::worn_tool::WornTool;
use crate::contact::CutterContact;
use crate::geometry::{Vec3, across, angle_between};
use crate::kinematics::ToolPose;
use crate::machine::Tool;
use crate::units::{Angle, Length};
use crate::wear::{
    FlatContact, ShiftFault, StatedSide, end_milling_shift, end_milling_shift_at, side_milling_shift,
    side_milling_shift_at, stated_side,
};

/// The part of the cutter that touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Hold {
    /// The corner, by the unit normal of the surface.
    Corner { normal: Vec3 },
    /// The flank, or the sharp edge of a flat cutter.
    Side { inward: Vec3 },
    /// The flat end. Also used without a contact: the tip itself is then kept.
    Flat,
    /// No contact of its own. The tip keeps this shift of the last contact, which excludes ΔL.
    Carried { shift_mm: Vec3 },
    /// The corner of a cutter that is known by its wear table. The tip moves by this shift, which excludes ΔL.
    Table { normal: Vec3, shift_mm: Vec3 },
}

/// A contact, and the shift that keeps it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WornContact {
    pub(super) hold: Hold,
    /// Δ in W \[mm\]. It includes ΔL as far as the control does not know of it.
    pub(super) shift_mm: Vec3,
    pub(super) note: Option<FlatContact>,
    /// Distance of a stated point from the nominal cutter \[mm\].
    pub(super) off_tool_mm: f64,
}

impl Hold {
    /// The vector from the tip to the point where a cutter of this shape touches \[mm\].
    pub(super) fn offset_mm(&self, tool: &Tool, axis: Vec3) -> Vec3 {
        match self {
            Self::Corner { normal } | Self::Table { normal, .. } => {
                CutterContact::Normal { direction: *normal, magnitude: 1.0 }.offset_mm(tool, axis)
            }
            Self::Side { inward } => inward * -tool.radius().mm(),
            Self::Flat | Self::Carried { .. } => Vec3::zeros(),
        }
    }

    /// The offset of the worn cutter's contact from the nominal one's \[mm\], computed from both tips: `c′ − c`. If
    /// the tool axes differ (computed anew, rounded), the contact is the one along the normal.
    pub(super) fn residual_mm(
        &self,
        [nominal, actual]: [&Tool; 2],
        source: &ToolPose,
        written: &ToolPose,
    ) -> Vec3 {
        let turned_mm = self.turn_mm([nominal, actual], source.axis, written.axis);
        if let Self::Table { shift_mm, .. } | Self::Carried { shift_mm } = self {
            return written.tip_mm - source.tip_mm - shift_mm - turned_mm;
        }
        written.tip_mm + self.offset_mm(actual, source.axis)
            - source.tip_mm
            - self.offset_mm(nominal, source.axis)
            - turned_mm
    }

    /// How far the tip must move along the normal so that a turned tool keeps its height at the contact \[mm\]. The
    /// tool turns from the axis `from` to the axis `to`. The turn also slides the contact over the surface, by the
    /// turn times the cutter's radius. That sliding is left uncorrected; next to a flat contact a correction has no
    /// use.
    pub(super) fn turn_mm(&self, [nominal, actual]: [&Tool; 2], from: Vec3, to: Vec3) -> Vec3 {
        match self {
            Self::Corner { normal } => {
                normal * (depth_mm(actual, to, *normal) - depth_mm(actual, from, *normal))
            }
            Self::Table { normal, .. } => {
                normal * (depth_mm(nominal, to, *normal) - depth_mm(nominal, from, *normal))
            }
            Self::Side { .. } | Self::Flat | Self::Carried { .. } => Vec3::zeros(),
        }
    }

    /// The offset of the nominal cutter's contact from its planned place \[mm\], for a tool at another pose than
    /// planned.
    pub(super) fn miss_mm(&self, nominal: &Tool, meant: &ToolPose, real: &ToolPose) -> Vec3 {
        real.tip_mm - meant.tip_mm - self.turn_mm([nominal; 2], meant.axis, real.axis)
    }

    /// The direction out of the part.
    pub(super) fn normal(&self, axis: Vec3) -> Vec3 {
        match self {
            Self::Corner { normal } | Self::Table { normal, .. } => *normal,
            Self::Side { inward } => *inward,
            Self::Flat | Self::Carried { .. } => axis,
        }
    }
}

/// How far the cutter reaches from its tip along −n: `r(1 − n·t) + (R − r)|n × t|` \[mm\].
fn depth_mm(tool: &Tool, axis: Vec3, normal: Vec3) -> f64 {
    let (corner, core) = (tool.corner_radius().mm(), tool.core_radius().mm());
    corner * (1.0 - normal.dot(&axis)) + core * normal.cross(&axis).norm()
}

/// The contact that follows from a stated point in W.
pub(super) fn by_point(
    tool: &WornTool,
    pose: &ToolPose,
    contact_mm: Vec3,
) -> Result<WornContact, ShiftFault> {
    let wear = tool.cutter_wear();
    if tool.milling == Milling::Side {
        let stated = side_milling_shift_at(&wear, pose, contact_mm)?;
        let inward = across(pose.tip_mm - contact_mm, pose.axis).normalize();
        let (hold, shift_mm) = (Hold::Side { inward }, stated.shift.shift_mm);
        return Ok(WornContact { hold, shift_mm, note: None, off_tool_mm: stated.off_tool_mm });
    }
    let (side, off_tool_mm) = stated_side(&tool.nominal, pose, contact_mm)?;
    match (side, &tool.worn) {
        (StatedSide::Corner { normal }, _) => {
            Ok(WornContact { off_tool_mm, ..by_normal(tool, pose, normal)? })
        }
        (StatedSide::Flat, _) => Ok(flat(tool, pose, off_tool_mm)),
        (StatedSide::Edge { inward }, WornCutter::Tool(_)) => {
            let stated = end_milling_shift_at(&wear, pose, contact_mm)?;
            let (hold, shift_mm) = (Hold::Side { inward }, stated.shift.shift_mm);
            Ok(WornContact { hold, shift_mm, note: stated.shift.note, off_tool_mm })
        }
        (StatedSide::Edge { .. }, WornCutter::Table(_)) => Err(ShiftFault::NoNormal { off_tool_mm }),
    }
}

/// The contact that follows from a surface normal in W.
pub(in crate::process) fn by_normal(
    tool: &WornTool,
    pose: &ToolPose,
    normal: Vec3,
) -> Result<WornContact, ShiftFault> {
    let (axis, wear) = (pose.axis, tool.cutter_wear());
    if tool.milling == Milling::Side {
        let shift = side_milling_shift(&wear, axis, normal)?;
        let inward = across(normal, axis).normalize();
        let (hold, shift_mm) = (Hold::Side { inward }, shift.shift_mm);
        return Ok(WornContact { hold, shift_mm, note: None, off_tool_mm: 0.0 });
    }
    let (shift, hold) = match &tool.worn {
        WornCutter::Tool(_) => {
            let shift = end_milling_shift(&wear, axis, normal)?;
            let normal = normal.normalize();
            let whole = shift.note == Some(FlatContact::Whole);
            (shift, if whole { Hold::Flat } else { Hold::Corner { normal } })
        }
        WornCutter::Table(table) => {
            let shift = table.shift(axis, normal, wear.shorter_by)?;
            let normal = normal.normalize();
            let shift_mm = table.shift(axis, normal, Length::ZERO)?.shift_mm;
            (shift, Hold::Table { normal, shift_mm })
        }
    };
    Ok(WornContact { hold, shift_mm: shift.shift_mm, note: shift.note, off_tool_mm: 0.0 })
}

/// The flat end, or no contact at all: only the length counts.
pub(super) fn flat(tool: &WornTool, pose: &ToolPose, off_tool_mm: f64) -> WornContact {
    WornContact {
        hold: Hold::Flat,
        shift_mm: pose.axis * -tool.unknown_to_control.mm(),
        note: Some(FlatContact::Whole),
        off_tool_mm,
    }
}

/// The contact for another tool, or without any wear: the tip itself.
pub(super) const TIP: WornContact =
    WornContact { hold: Hold::Flat, shift_mm: Vec3::new(0.0, 0.0, 0.0), note: None, off_tool_mm: 0.0 };

/// No contact of its own: the length counts, and the last contact's shift is kept.
pub(super) fn carried(tool: &WornTool, pose: &ToolPose, carried_mm: Vec3) -> WornContact {
    let plain = flat(tool, pose, 0.0);
    let (hold, shift_mm) = (Hold::Carried { shift_mm: carried_mm }, plain.shift_mm + carried_mm);
    WornContact { hold, shift_mm, note: None, ..plain }
}

/// The least and the largest angle ψ between normal and tool axis so far.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ContactAngles {
    /// The angles with their cosines.
    extremes: Option<[(Angle, f64); 2]>,
}

/// A cosine that is this much inside two others has its angle inside theirs. It is far above the rounding of both.
const SURELY_INSIDE: f64 = 1e-12;

impl ContactAngles {
    pub(super) fn take(&mut self, contact: &WornContact, axis: Vec3) {
        let normal = contact.hold.normal(axis);
        let cos = normal.dot(&axis);
        // Few points are an extreme. The others need no arc tangent.
        if let Some([least, most]) = &self.extremes
            && cos < least.1 - SURELY_INSIDE
            && cos > most.1 + SURELY_INSIDE
        {
            return;
        }
        let here = (Angle::from_rad(angle_between(normal, axis)), cos);
        let [least, most] = self.extremes.unwrap_or([here, here]);
        self.extremes =
            Some([if here.0 < least.0 { here } else { least }, if here.0 > most.0 { here } else { most }]);
    }

    /// The least and the largest angle; `None` without any contact.
    pub(super) fn range(&self) -> Option<[Angle; 2]> {
        self.extremes.map(|extremes| extremes.map(|(angle, _)| angle))
    }
}
