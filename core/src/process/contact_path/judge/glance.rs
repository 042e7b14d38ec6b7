//! A glance at motions that were looked at in lanes while they were prepared. For most of them, no other check is needed.

use super::Judge;
use crate::contact::Sampled;
use crate::process::text::Passage;

impl Judge<'_> {
    /// The length of the contact line \[mm\] and the deviation of the motion of this index, if the look at it is enough.
    /// Otherwise the motion has to be [judged](Judge::judge). The result is the same.
    #[inline]
    pub(in crate::process) fn glance(
        &mut self,
        passage: &Passage,
        index: usize,
        largest_after_mm: f64,
    ) -> Option<(f64, Sampled)> {
        let look = passage.looks.get(index)?;
        let found = self.by_look(&look.alone(), largest_after_mm)?;
        let motion = &passage.motions[index];
        if !self.set_ups.is_entered(motion) || self.may_roll_over(motion) {
            return None;
        }
        self.effort.spend(1);
        self.has_glanced = true;
        Some((look.path_mm, found))
    }

    /// Goes to the end of the motion of this index, if the judge has only glanced at it. Must be called before a
    /// passage is left.
    #[inline]
    pub(in crate::process) fn catch_up(&mut self, passage: &Passage, index: usize) {
        if !std::mem::take(&mut self.has_glanced) {
            return;
        }
        let (Some(motion), Some(poses)) = (passage.motions.get(index), passage.poses.get(index)) else {
            return;
        };
        self.spare = self.point.take().or_else(|| self.spare.take());
        let mode = self.mode(motion);
        self.point = motion.end.as_ref().map(|words| self.arrived(words, &poses.end, mode, motion));
    }
}
