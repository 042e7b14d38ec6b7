//! The tip position that puts the contact point back on its line. The tool axis never changes.

use super::SourceBlock;
use crate::geometry::Vec3;
use crate::kinematics::ToolPose;

/// How the tip moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Correction {
    /// `w′ = w + (c_s + u·l − c)`: no residual, and the contact keeps its speed.
    #[default]
    Even,
    /// `w′ = w + (foot(c) − c)`: no residual, but the contact's speed is uneven.
    Foot,
    /// P0 eq. (13)–(16): `w′ = w + ε·(w − P)/|w − P|`, P the foot of *w*. It leaves a residual and serves for
    /// comparison.
    Seed,
}

/// The corrected tip w′ in W \[mm\] at the fraction `u` of the source block. `pose` is the machine's real pose
/// there: rotary words as written, tip as the source block interpolates it.
#[must_use]
pub fn repaired_tip_mm(block: &SourceBlock<'_>, correction: Correction, u: f64, pose: &ToolPose) -> Vec3 {
    let offset_mm = block.carry.at(&block.tool, u, pose.axis).offset_mm;
    let contact_mm = pose.tip_mm + offset_mm;
    match correction {
        Correction::Even => block.line.at_mm(u) - offset_mm,
        Correction::Foot => block.line.foot_mm(contact_mm) - offset_mm,
        Correction::Seed => {
            let deviation_mm = (contact_mm - block.line.foot_mm(contact_mm)).norm();
            let away = pose.tip_mm - block.line.foot_mm(pose.tip_mm);
            // A tip on the contact line has no direction away from it: the seed rule leaves it unchanged.
            away.try_normalize(f64::EPSILON).map_or(pose.tip_mm, |away| pose.tip_mm + away * deviation_mm)
        }
    }
}
