//! Whether the axes keep within their travels at the words of a program, and whether the words tell in which
//! direction an axis turns.

use super::set_ups::SetUp;
use crate::contact::rotary_rad;
use crate::geometry::Vec3;
use crate::kinematics::Kinematics;
use crate::machine::Machine;
use crate::motion::{AxisWords, Interpolation, Motion};
use crate::process::fault::LineFaultKind;
use crate::program::Dialect;

/// A machine and its set-up, for the travels of its axes.
#[derive(Debug, Clone, Copy)]
pub(in crate::process) struct TravelCheck<'a> {
    pub(in crate::process) machine: &'a Machine,
    pub(in crate::process) kinematics: &'a Kinematics,
    /// Whether the positions of the linear axes are known under tool-centre-point control.
    pub(in crate::process) is_stated: bool,
}

/// Whether every limited travel was checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use]
pub(in crate::process) enum Travels {
    Checked,
    /// The linear axes were not checked, because their positions depend on a value that is not stated.
    NotChecked,
}

impl SetUp {
    /// The check of travels with this set-up.
    pub(in crate::process) fn travel_check<'a>(&'a self, machine: &'a Machine) -> TravelCheck<'a> {
        TravelCheck { machine, kinematics: &self.kinematics, is_stated: self.is_stated() }
    }
}

impl TravelCheck<'_> {
    /// Hands each axis that would leave its travel at these words to `outside`: the rotary axes first, then X Y Z.
    /// The words of X Y Z are the positions of their axes, or under tool-centre-point control those of the tip.
    pub(in crate::process) fn see(
        &self,
        mode: Interpolation,
        words: &AxisWords,
        mut outside: impl FnMut(LineFaultKind),
    ) -> Travels {
        let Self { machine, kinematics, is_stated } = *self;
        for (axis, word) in machine.rotary_axes().iter().zip(words.rotary_deg) {
            LineFaultKind::outside(axis.letter.as_char(), word, axis.travel_deg).map(&mut outside);
        }
        let travels = *machine.linear_travel_mm();
        if travels.iter().all(Option::is_none) {
            return Travels::Checked;
        }
        let positions_mm: [f64; 3] = match mode {
            Interpolation::Machine => words.linear_mm,
            Interpolation::Tcp if !is_stated => return Travels::NotChecked,
            Interpolation::Tcp => {
                let tip_mm = Vec3::from(words.linear_mm);
                kinematics.linear_mm(tip_mm, rotary_rad(machine, words.rotary_deg)).into()
            }
        };
        for ((letter, position_mm), travel) in ['X', 'Y', 'Z'].into_iter().zip(positions_mm).zip(travels) {
            LineFaultKind::outside(letter, position_mm, travel).map(&mut outside);
        }
        Travels::Checked
    }
}

/// The turn that is equally long both ways \[deg\].
const HALF_TURN_DEG: f64 = 180.0;

/// Errors in differences of words are smaller than this \[deg\].
const SAME_DEG: f64 = 1e-9;

/// Whether the direction of a rotary axis is unknown. This holds if an axis without travel limits turns by half a
/// turn or more. Some controls of ISO programs let such an axis roll over and take the shorter way.
pub(in crate::process) fn may_roll_over(machine: &Machine, dialect: Dialect, motion: &Motion) -> bool {
    if !dialect.rules().may_roll_over || motion.incremental {
        return false;
    }
    let (Some(start), Some(end)) = (&motion.start, &motion.end) else { return false };
    machine
        .rotary_axes()
        .iter()
        .zip(start.rotary_deg.iter().zip(&end.rotary_deg))
        .any(|(axis, (from, to))| axis.travel_deg.is_none() && (to - from).abs() >= HALF_TURN_DEG - SAME_DEG)
}
