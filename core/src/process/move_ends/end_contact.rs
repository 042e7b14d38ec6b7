//! Where the nominal cutter touches at the end of a motion: as the block states it, on the part, or as assumed from
//! the feed.

use super::contact::{WornContact, by_normal, by_point};
use super::pilot::{Pilot, RESTING_MM};
use super::worn_tool::WornTool;
use crate::contact::{
    SurfaceContact, Touch, contact_on_surface, feed_direction, feed_plane_normal, stated_point_mm,
};
use crate::geometry::{Vec3, angle_between};
use crate::kinematics::ToolPose;
use crate::machine::Tool;
use crate::motion::{AxisWords, ContactWords, Motion, MotionKind};
use crate::process::fault::WarningKind;
use crate::process::set_up::{ContactSource, turns};
use crate::wear::{FlatContact, ShiftFault};

impl Pilot<'_> {
    /// The contact that the block states in the words of the chosen source.
    pub(super) fn stated(
        &self,
        worn: &WornTool,
        motion: &Motion,
        end: &AxisWords,
        pose: &ToolPose,
    ) -> Result<Option<WornContact>, ShiftFault> {
        match (self.contact, motion.contact) {
            (ContactSource::Program, ContactWords::Point(words)) => {
                let (mode, kinematics) = (self.points.mode(motion), &self.points.source.now.kinematics);
                let contact_mm = stated_point_mm(self.machine, kinematics, mode, words, end.rotary_deg);
                by_point(worn, pose, contact_mm).map(Some)
            }
            (ContactSource::Normals, ContactWords::Normal(normal)) => {
                by_normal(worn, pose, Vec3::from(normal)).map(Some)
            }
            _ => Ok(None),
        }
    }

    /// Where the nominal cutter touches the part.
    pub(super) fn on_surface(&mut self, pose: &ToolPose) -> Option<SurfaceContact> {
        let (part, worn) = (self.parameters.part.as_ref()?, self.worn.as_ref()?);
        contact_on_surface(part, &worn.nominal, pose, &mut self.effort)
    }

    /// The contact by the rule of the feed plane, at the end of a motion at feed and where a rapid is followed by
    /// one. Nothing is assumed if no rotary axis turns on either side of the point, or if the feed leaves the contact
    /// open.
    pub(super) fn feed_plane(
        &mut self,
        motions: &[Motion],
        index: usize,
        following: Option<&Motion>,
        pose: &ToolPose,
    ) -> Result<Option<WornContact>, ShiftFault> {
        let Some(worn) = &self.worn else { return Ok(None) };
        let motion = &motions[index];
        let next = self.points.goes_on(motions, index, following);
        let is_cut = motion.kind == MotionKind::Linear;
        let before = motion.start.filter(|_| is_cut).map(|start| self.points.pose_at(motion, start));
        let after = next.and_then(|next| next.end).map(|end| self.points.pose_at(motion, end));
        let turns = [is_cut && turns(motion), next.is_some_and(turns)];
        let feed = if turns.contains(&true) {
            self.feed_at(&worn.nominal, [before, after], pose, turns)
        } else {
            None
        };
        let found = feed.and_then(|feed| feed_plane_normal(pose.axis, feed));
        let path_mm = before.map_or(0.0, |before| (pose.tip_mm - before.tip_mm).norm());
        if is_cut {
            self.assumption.take(path_mm, turns.contains(&true), found.is_some());
        }
        found.map(|normal| by_normal(worn, pose, normal)).transpose()
    }

    /// The feed at a point between the poses before and after it. If one pass continues through the point, it is the
    /// chord between these poses. If not, it is the feed on a side where a rotary axis turns. The motion that ends
    /// here comes first.
    fn feed_at(
        &self,
        tool: &Tool,
        sides: [Option<ToolPose>; 2],
        pose: &ToolPose,
        turns: [bool; 2],
    ) -> Option<Vec3> {
        let before = sides[0].and_then(|before| feed_direction(tool, [&before, pose]));
        let after = sides[1].and_then(|after| feed_direction(tool, [pose, &after]));
        match (before, after) {
            (Some(from), Some(to)) if angle_between(from, to) <= self.parameters.pass_break.rad() => {
                let [Some(before), Some(after)] = sides else { return None };
                (after.tip_mm - before.tip_mm).try_normalize(RESTING_MM)
            }
            (Some(from), _) if turns[0] => Some(from),
            (_, Some(to)) if turns[1] => Some(to),
            _ => None,
        }
    }

    /// Records the curvature of the part across the feed where the nominal cutter touches it. Uses the contact
    /// `touched` if it was searched for already.
    pub(super) fn note_curvature(
        &mut self,
        motion: &Motion,
        pose: &ToolPose,
        touched: Option<SurfaceContact>,
    ) {
        let Some(part) = &self.parameters.part else { return };
        let (MotionKind::Linear, Some(start)) = (motion.kind, motion.start) else { return };
        let feed_mm = pose.tip_mm - self.points.tip_mm(self.points.mode(motion), start);
        if feed_mm.norm() <= RESTING_MM {
            return;
        }
        let across = touched
            .or_else(|| self.on_surface(pose))
            .and_then(|touched| touched.curvature_across_per_mm(&part.mesh, feed_mm, &mut self.effort));
        if let Some(curvature_per_mm) = across {
            self.curvature.note(curvature_per_mm, motion.line);
        }
    }

    pub(super) fn note(&mut self, line: u64, contact: &WornContact) {
        if contact.off_tool_mm > Touch::ON_TOOL_MM {
            self.warnings.add_distance(WarningKind::NearestContact, line, contact.off_tool_mm);
        }
        match contact.note {
            Some(FlatContact::Whole) => {
                self.warnings.add(WarningKind::FlatContact, Some(line));
            }
            Some(FlatContact::Nearly { .. }) => {
                self.warnings.add(WarningKind::NearlyFlatContact, Some(line));
            }
            None => {}
        }
    }
}
