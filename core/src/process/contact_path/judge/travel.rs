//! Whether the words of motions keep within the travels of the axes, and whether they say in which direction an axis turns.

use super::Judge;
use crate::machine::Machine;
use crate::motion::{AxisWords, Motion, MotionKind};
use crate::process::fault::WarningKind;
use crate::process::set_up::Travels;
use crate::program::Dialect;

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

/// The turn that is equally long both ways \[deg\].
const HALF_TURN_DEG: f64 = 180.0;

/// Errors in differences of words are smaller than this \[deg\].
const SAME_DEG: f64 = 1e-9;

/// Whether the direction of a rotary axis is unknown. This holds if an axis without travel limits turns by half a
/// turn or more. Some controls of ISO programs let such an axis roll over and take the shorter way.
pub(in crate::process) fn may_roll_over(machine: &Machine, dialect: Dialect, motion: &Motion) -> bool {
    let (Some(start), Some(end)) = (motion.start, motion.end) else { return false };
    dialect.rules().may_roll_over
        && !motion.incremental
        && machine.rotary_axes().iter().zip(start.rotary_deg.iter().zip(&end.rotary_deg)).any(
            |(axis, (from, to))| axis.travel_deg.is_none() && (to - from).abs() >= HALF_TURN_DEG - SAME_DEG,
        )
}
