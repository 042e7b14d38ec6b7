//! Whether the words of motions keep within the travels of the axes.

use super::Judge;
use crate::motion::{AxisWords, Motion, MotionKind};
use crate::process::fault::WarningKind;
use crate::process::set_up::Travels;

impl Judge<'_> {
    /// Checks the travels of the axes at the end of a motion.
    pub(super) fn check_travel(&mut self, motion: &Motion, end: &AxisWords, text: &[u8]) {
        if motion.kind == MotionKind::Opaque || motion.unfollowable.is_some() || motion.offset_changed {
            return;
        }
        if self.check_words(motion, end, text) == Travels::NotChecked {
            self.warnings.add(WarningKind::TravelNotChecked, Some(motion.line));
        }
    }

    /// Checks the travels of the axes at words of this motion's block.
    pub(in crate::process) fn check_words(
        &mut self,
        motion: &Motion,
        words: &AxisWords,
        text: &[u8],
    ) -> Travels {
        let (mode, faults) = (self.mode(motion), &mut self.faults);
        let check = self.set_ups.now.travel_check(self.machine);
        check.see(mode, words, |kind| faults.add(motion.line, text, kind))
    }
}
