//! The machine as it is set up for each motion of a program: its work offset, its tool.

use std::sync::Arc;

use super::ProgramSetup;
use super::fault::{LineFaultKind, Unstated};
use crate::geometry::Vec3;
use crate::kinematics::{BareKinematics, Kinematics};
use crate::machine::{Machine, Side};
use crate::motion::{AxisWords, Interpolation, Motion, WorkOffset};
use crate::units::Length;

/// So many set-ups are kept; a program with more makes them again.
const MAX_KEPT: usize = 1024;

/// What tells one set-up from another.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Key {
    work_offset: Option<WorkOffset>,
    is_only_offset: bool,
}

impl Key {
    #[inline]
    fn of(motion: &Motion) -> Self {
        Self { work_offset: motion.work_offset, is_only_offset: motion.is_only_offset }
    }
}

/// The machine as it is set up for some motions.
#[derive(Debug, Clone)]
pub(super) struct SetUp {
    key: Key,
    /// With zero for what is not stated.
    pub(super) kinematics: Arc<Kinematics>,
    /// Something on which the poses of turning motions depend is not stated.
    unstated: Option<Unstated>,
}

/// The set-ups of a program's motions, made as they are met.
#[derive(Debug, Clone)]
pub(super) struct SetUps {
    bare: BareKinematics,
    program: ProgramSetup,
    /// ΔL of a tool that the control knows to be shorter.
    shorter_by: Length,
    has_table_axis: bool,
    has_head_axis: bool,
    made: Vec<SetUp>,
    /// That of the motion entered last.
    pub(super) now: SetUp,
}

impl SetUps {
    /// Of programs with this set-up on this machine.
    pub(super) fn new(machine: &Machine, program: &ProgramSetup) -> Self {
        Self::with_shorter_tool(machine, program, Length::ZERO)
    }

    /// The same with a tool that is shorter than stated by so much, as the control knows.
    pub(super) fn with_shorter_tool(machine: &Machine, program: &ProgramSetup, shorter_by: Length) -> Self {
        let bare = BareKinematics::new(machine, program.apply_errors);
        let has = |side: Side| machine.rotary_axes().iter().any(|axis| axis.side == side);
        let (has_table_axis, has_head_axis) = (has(Side::Table), has(Side::Head));
        let key = Key { work_offset: Some(WorkOffset::Unnamed), is_only_offset: true };
        let kinematics = Arc::new(bare.set_up(Vec3::zeros(), 0.0));
        let mut set_ups = Self {
            bare,
            program: program.clone(),
            shorter_by,
            has_table_axis,
            has_head_axis,
            made: Vec::new(),
            now: SetUp { key, kinematics, unstated: None },
        };
        set_ups.now = set_ups.make(key);
        set_ups.made.push(set_ups.now.clone());
        set_ups
    }

    /// Goes over to the set-up of a motion. Whether that is another one than before.
    #[inline]
    pub(super) fn enter(&mut self, motion: &Motion) -> bool {
        let key = Key::of(motion);
        if key == self.now.key {
            return false;
        }
        self.change(key);
        true
    }

    /// Whether this motion has the set-up entered last.
    #[inline]
    pub(super) fn is_entered(&self, motion: &Motion) -> bool {
        Key::of(motion) == self.now.key
    }

    #[cold]
    fn change(&mut self, key: Key) {
        if let Some(made) = self.made.iter().find(|made| made.key == key) {
            self.now = made.clone();
            return;
        }
        self.now = self.make(key);
        if self.made.len() >= MAX_KEPT {
            self.made.clear();
        }
        self.made.push(self.now.clone());
    }

    fn make(&self, key: Key) -> SetUp {
        let offset_mm =
            key.work_offset.and_then(|offset| self.program.work_offsets.of(offset, key.is_only_offset));
        let length = self.program.tool_length;
        let unstated = if self.has_table_axis && offset_mm.is_none() {
            Some(Unstated::WorkOffset { name: key.work_offset })
        } else if self.has_head_axis && length.is_none() {
            Some(Unstated::ToolLength)
        } else {
            None
        };
        let length_mm = (length.unwrap_or(Length::ZERO) - self.shorter_by).mm();
        let offset_mm = offset_mm.map_or_else(Vec3::zeros, Vec3::from);
        SetUp { key, kinematics: Arc::new(self.bare.set_up(offset_mm, length_mm)), unstated }
    }
}

impl SetUp {
    /// What has to be stated before anything can be said of the path of a motion that turns in machine interpolation.
    #[inline]
    pub(super) fn missing_for_turning(&self, mode: Interpolation, motion: &Motion) -> Option<LineFaultKind> {
        let unstated = self.unstated.filter(|_| mode == Interpolation::Machine)?;
        turns(motion).then_some(LineFaultKind::Unstated(unstated))
    }

    /// What has to be stated before anything can be said of where a motion is on the machine.
    #[inline]
    pub(super) fn missing_for_place(&self) -> Option<LineFaultKind> {
        self.unstated.map(LineFaultKind::Unstated)
    }

    /// Whether the place of a motion on the machine is known.
    pub(super) fn is_stated(&self) -> bool {
        self.unstated.is_none()
    }
}

/// Whether a rotary axis turns in a motion whose ends are known.
#[inline]
pub(super) fn turns(motion: &Motion) -> bool {
    let (Some(start), Some(end)) = (&motion.start, &motion.end) else { return false };
    turn_between(start, end)
}

/// Whether rotary axes stand elsewhere at these words than at those.
#[inline]
#[expect(clippy::float_cmp, reason = "words that stand are the same to the bit")]
pub(super) fn turn_between(start: &AxisWords, end: &AxisWords) -> bool {
    start.rotary_deg != end.rotary_deg
}
