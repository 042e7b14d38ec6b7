//! The contact assumed from the feed if it is not stated (§2, P0's rule without its misprint).

use super::{CutterContact, Touch};
use crate::geometry::{Vec3, across};
use crate::kinematics::ToolPose;
use crate::machine::Tool;

/// The sine of 0.1°. A feed this close to the tool axis, or this close to across it, leaves the contact
/// undetermined: the rule's result then depends on the last digits of the words. Wear compensation warns from the
/// same angle on.
const OPEN_SINE: f64 = 1.745_328_366e-3;

/// The normal of the surface that a tool along `axis` cuts on its way along `feed`, both unit vectors in W:
/// `n = (t − (t·Ê)Ê)/|…|`, the direction across the feed that is nearest to the tool axis.
///
/// `None` if the feed leaves the contact undetermined. The tool may move along its own axis: it plunges. Or it
/// moves across its axis: the rule then gives `n ∥ t`, which fits a floor, but also a wall with a level feed.
#[must_use]
#[inline]
pub fn feed_plane_normal(axis: Vec3, feed: Vec3) -> Option<Vec3> {
    if axis.dot(&feed).abs() < OPEN_SINE {
        return None;
    }
    across(axis, feed).try_normalize(OPEN_SINE)
}

impl Touch {
    /// The contact of `tool` by the rule of the [feed plane](feed_plane_normal); `None` if the feed leaves it
    /// undetermined.
    #[must_use]
    #[inline]
    pub fn from_feed(pose: &ToolPose, feed: Vec3) -> Option<Self> {
        let direction = feed_plane_normal(pose.axis, feed)?;
        let contact = CutterContact::Normal { direction, magnitude: 1.0 };
        Some(Self { contact, off_tool_mm: 0.0, is_open: false })
    }
}

/// A tool pivots if its tip travels less than this share of the contact's travel round the cutter's edge. Its feed
/// direction is then unknown.
const PIVOTS_BELOW: f64 = 0.1;
/// The direction of a shorter chord is only rounding \[mm\].
const RESTING_MM: f64 = 1e-6;

/// The feed of a motion between two poses: the direction of its tip's chord in W. `None` if the tip rests or
/// pivots: the chord of such a motion comes from rounding or from a correction, not from the feed.
#[must_use]
#[inline]
pub fn feed_direction(tool: &Tool, ends: [&ToolPose; 2]) -> Option<Vec3> {
    let [from, to] = ends;
    let swing_mm = tool.radius().mm() * (to.axis - from.axis).norm();
    (to.tip_mm - from.tip_mm).try_normalize(RESTING_MM.max(PIVOTS_BELOW * swing_mm))
}
