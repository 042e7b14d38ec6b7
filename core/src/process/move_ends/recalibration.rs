//! Counts what changes if a program that was made for the nominal machine is computed anew for the machine as it is.

use super::pilot::MovedPoint;
use crate::geometry::angle_between;
use crate::machine::Machine;
use crate::motion::{AxisWords, Motion};
use crate::process::fault::{WarningKind, Warnings};
use crate::units::{Angle, Length};

/// The largest value of a quantity, and its line.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(in crate::process) struct Largest<T> {
    pub(in crate::process) value: T,
    pub(in crate::process) line: Option<u64>,
}

impl<T: PartialOrd> Largest<T> {
    /// Takes a value that may be the largest.
    pub(in crate::process) fn take(&mut self, value: T, line: u64) {
        if value > self.value {
            *self = Self { value, line: Some(line) };
        }
    }
}

/// Counts of motions computed anew.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::process) struct Recalibration {
    /// Motions computed anew.
    pub(in crate::process) recalibrated: u64,
    /// Posted motions whose rotary words changed.
    pub(in crate::process) turned: u64,
    /// Distance between the tips of the machine as it is and as meant.
    pub(in crate::process) tip: Largest<Length>,
    /// Angle between their tool axes.
    pub(in crate::process) axis: Largest<Angle>,
    /// Change of a rotary word.
    pub(in crate::process) turn: Largest<Angle>,
    /// Angle between the written tool axis and the one meant.
    pub(in crate::process) left: Largest<Angle>,
    /// Motions that end inside the pole cone, and the first of them.
    pub(in crate::process) held: u64,
    first_held: Option<u64>,
}

impl Recalibration {
    /// Counts a motion that was moved from one end to the other.
    pub(super) fn take(
        &mut self,
        machine: &Machine,
        motion: &Motion,
        point: &MovedPoint,
        [source, written]: [&AxisWords; 2],
        recalibrates: bool,
    ) {
        if !recalibrates {
            return;
        }
        let line = motion.line;
        self.recalibrated += 1;
        self.tip.take(Length::from_mm((point.real.tip_mm - point.pose.tip_mm).norm()), line);
        self.axis.take(Angle::from_rad(angle_between(point.real.axis, point.pose.axis)), line);
        let turns = (0..machine.rotary_axes().len())
            .map(|k| (written.rotary_deg[k] - source.rotary_deg[k]).abs())
            .fold(0.0, f64::max);
        self.turned += u64::from(turns > 0.0);
        self.turn.take(Angle::from_deg(turns), line);
        self.held += u64::from(point.held);
        self.first_held = self.first_held.or(Some(line).filter(|_| point.held));
    }

    /// Whether any tip or tool axis of the machine as it is differs from the one meant.
    pub(super) fn did_something(&self) -> bool {
        self.tip.line.is_some() || self.axis.line.is_some()
    }

    pub(super) fn warn(&self, warnings: &mut Warnings) {
        if self.held > 0 {
            warnings.add(WarningKind::HeldAtPole, self.first_held).count = self.held;
        }
    }
}
