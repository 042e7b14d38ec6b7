//! Contacts that are assumed from the feed of a pass.

use super::{Judge, JudgedPoint};
use crate::contact::{Station, Touch, feed_direction};
use crate::geometry::{Vec3, angle_between};
use crate::kinematics::ToolPose;
use crate::motion::Motion;
use crate::process::contact_path::contact_finder;
use crate::process::fault::WarningKind;
use crate::process::set_up::turns;
use crate::process::text::Passage;

/// The number of motions that are searched ahead for the direction in which a pass continues.
const MAX_LOOKAHEAD: usize = 64;

impl Judge<'_> {
    /// The feed direction of a motion: the direction of its tip, or of its pass if the tip does not show it.
    pub(super) fn feed(
        &mut self,
        start: &JudgedPoint,
        end: &JudgedPoint,
        passage: &Passage,
        index: usize,
        following: Option<&Motion>,
    ) -> Option<Vec3> {
        let tool = &self.tool;
        if let Some(own) = feed_direction(tool, [&start.station.pose, &end.station.pose]) {
            self.feed_before = Some(own);
            return Some(own);
        }
        match (self.feed_before, self.feed_after(&end.station.pose, passage, index, following)) {
            (Some(before), Some(after)) => {
                let goes_on = angle_between(before, after) <= self.parameters.pass_break.rad();
                if goes_on { (before + after).try_normalize(f64::EPSILON) } else { None }
            }
            (before, after) => before.or(after),
        }
    }

    /// The feed of the next motion of the pass whose tip shows it.
    fn feed_after(
        &self,
        from: &ToolPose,
        Passage { motions, poses, .. }: &Passage,
        index: usize,
        following: Option<&Motion>,
    ) -> Option<Vec3> {
        let mut at = *from;
        let mut last = motions.get(index)?;
        for (step, next) in motions.iter().skip(index + 1).chain(following).enumerate() {
            let goes_on = step < MAX_LOOKAHEAD
                && self.looks_at(next)
                && next.start == last.end
                && self.mode(next) == self.mode(last)
                && self.set_ups.is_entered(next);
            let end = next.end.filter(|_| goes_on)?;
            let pose = match poses.get(index + 1 + step) {
                Some(poses) => poses.end,
                None => Station::new(self.machine, &self.set_ups.now.kinematics, self.mode(next), end).pose,
            };
            if let Some(feed) = feed_direction(&self.tool, [&at, &pose]) {
                return Some(feed);
            }
            (at, last) = (pose, next);
        }
        None
    }

    /// Assumes the contacts of a motion from its feed. If no rotary axis turns, nothing is assumed. If the feed
    /// leaves the contact open, the tip is taken as the contact.
    pub(super) fn assume(
        &mut self,
        start: &mut JudgedPoint,
        end: &mut JudgedPoint,
        feed: Option<Vec3>,
        motion: &Motion,
    ) {
        let assumed = if turns(motion) {
            let found = contact_finder::assumed([&start.station, &end.station], feed);
            if found.is_none() {
                self.warnings.add(WarningKind::ContactOpen, Some(motion.line));
            }
            found
        } else {
            None
        };
        self.assumed += u64::from(assumed.is_some());
        let [from, to] = assumed.unwrap_or([Touch::TIP; 2]);
        self.put(start, Some(from));
        self.put(end, Some(to));
    }
}
