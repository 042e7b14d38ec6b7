//! Whether the words of motions keep within the travels of the axes, and whether they say in which direction an axis turns.

use super::Judge;
use crate::contact::{Station, rotary_rad};
use crate::geometry::Vec3;
use crate::machine::{Machine, Travel};
use crate::motion::{AxisWords, Interpolation, Motion, MotionKind};
use crate::process::fault::{LineFaultKind, WarningKind};
use crate::program::Dialect;

impl Judge<'_> {
    pub(super) fn check_travel(&mut self, motion: &Motion, station: &Station, text: &[u8]) {
        if motion.kind == MotionKind::Opaque || motion.unfollowable.is_some() || motion.offset_changed {
            return;
        }
        for (axis, word) in self.machine.rotary_axes().iter().zip(station.words.rotary_deg) {
            self.check_word(motion.line, text, axis.letter.as_char(), word, axis.travel_deg);
        }
        let travel = *self.machine.linear_travel_mm();
        if travel.iter().all(Option::is_none) {
            return;
        }
        let mode = self.mode(motion);
        if mode == Interpolation::Tcp && !self.set_ups.now.is_stated() {
            // The axis positions then depend on the set-up.
            self.warnings.add(WarningKind::TravelNotChecked, Some(motion.line));
            return;
        }
        let words = self.axis_words(mode, &station.words, station.pose.tip_mm);
        for ((letter, word), travel) in ['X', 'Y', 'Z'].into_iter().zip(words).zip(travel) {
            self.check_word(motion.line, text, letter, word, travel);
        }
    }

    /// The positions of the linear axes: the words themselves, or with TCP the positions that reach the tip.
    pub(in crate::process) fn axis_words(
        &self,
        mode: Interpolation,
        words: &AxisWords,
        tip_mm: Vec3,
    ) -> [f64; 3] {
        match mode {
            Interpolation::Machine => words.linear_mm,
            Interpolation::Tcp => {
                let rotary_rad = rotary_rad(self.machine, words.rotary_deg);
                self.set_ups.now.kinematics.linear_mm(tip_mm, rotary_rad).into()
            }
        }
    }

    pub(in crate::process) fn check_word(
        &mut self,
        line: u64,
        text: &[u8],
        axis: char,
        word: f64,
        travel: Option<Travel>,
    ) {
        if let Some(kind) = LineFaultKind::outside(axis, word, travel) {
            self.faults.add(line, text, kind);
        }
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
