//! The machine set up for each motion of a program: its work offset and its tool.

use std::sync::Arc;

use super::program_setup::ProgramSetup;
use super::tooling::{ToolUsed, Tooling};
use crate::geometry::Vec3;
use crate::kinematics::{BareKinematics, Kinematics};
use crate::machine::{Machine, Side, Tool};
use crate::motion::{AxisWords, CalledTool, Interpolation, Motion, WorkOffset, WorkOffsets};
use crate::process::fault::{LineFaultKind, Unstated};
use crate::units::Length;

/// Largest number of set-ups kept. A program with more computes some of them again.
const MAX_KEPT: usize = 1024;

/// The values that distinguish one set-up from another.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Key {
    work_offset: Option<WorkOffset>,
    is_only_offset: bool,
    tool: CalledTool,
}

impl Key {
    #[inline]
    fn of(motion: &Motion) -> Self {
        let Motion { work_offset, is_only_offset, tool, .. } = *motion;
        Self { work_offset, is_only_offset, tool }
    }
}

/// The machine set up for some motions.
#[derive(Debug, Clone)]
pub(in crate::process) struct SetUp {
    key: Key,
    /// Computed with zero for values that are not stated.
    pub(in crate::process) kinematics: Arc<Kinematics>,
    /// The tool; `None` if other sections have known tools and this one does not.
    pub(in crate::process) tool: Option<ToolUsed>,
    /// A value that is not stated, but on which the poses of turning motions depend.
    unstated: Option<Unstated>,
}

/// The set-ups of a program's motions, made when they are first needed.
#[derive(Debug, Clone)]
pub(in crate::process) struct SetUps {
    bare: BareKinematics,
    work_offsets: Arc<WorkOffsets>,
    tooling: Arc<Tooling>,
    has_table_axis: bool,
    has_head_axis: bool,
    made: Vec<SetUp>,
    /// The set-up of the motion entered last.
    pub(in crate::process) now: SetUp,
}

impl SetUps {
    /// The set-ups of a program with this setup on this machine.
    pub(in crate::process) fn new(machine: &Machine, program: &ProgramSetup) -> Self {
        let bare = BareKinematics::new(machine, program.apply_errors);
        let has = |side: Side| machine.rotary_axes().iter().any(|axis| axis.side == side);
        let (has_table_axis, has_head_axis) = (has(Side::Table), has(Side::Head));
        let key =
            Key { work_offset: Some(WorkOffset::Unnamed), is_only_offset: true, tool: CalledTool::NotCalled };
        let kinematics = Arc::new(bare.set_up(Vec3::zeros(), 0.0));
        let mut set_ups = Self {
            bare,
            work_offsets: Arc::clone(&program.work_offsets),
            tooling: program.tools.tooling(),
            has_table_axis,
            has_head_axis,
            made: Vec::new(),
            now: SetUp { key, kinematics, tool: None, unstated: None },
        };
        set_ups.now = set_ups.make(key);
        set_ups.made.push(set_ups.now.clone());
        set_ups
    }

    /// Changes to the set-up of a motion. Returns whether it differs from the previous one.
    #[inline]
    pub(in crate::process) fn enter(&mut self, motion: &Motion) -> bool {
        let key = Key::of(motion);
        if key == self.now.key {
            return false;
        }
        self.change(key)
    }

    /// Whether this motion has the set-up entered last.
    #[inline]
    pub(in crate::process) fn is_entered(&self, motion: &Motion) -> bool {
        Key::of(motion) == self.now.key
    }

    /// Whether to report motions with unknown tools. Not if the request is for one tool only.
    pub(in crate::process) fn tells_unknown_tools(&self) -> bool {
        !self.tooling.is_by_number
    }

    #[cold]
    fn change(&mut self, key: Key) -> bool {
        let made = self.made.iter().find(|made| made.key == key).cloned();
        let next = made.unwrap_or_else(|| {
            let made = self.make(key);
            if self.made.len() >= MAX_KEPT {
                self.made.clear();
            }
            self.made.push(made.clone());
            made
        });
        let before = std::mem::replace(&mut self.now, next);
        !Arc::ptr_eq(&before.kinematics, &self.now.kinematics) || before.tool != self.now.tool
    }

    fn make(&self, key: Key) -> SetUp {
        let offset_mm = key.work_offset.and_then(|offset| self.work_offsets.of(offset, key.is_only_offset));
        let tool = self.tooling.tool(key.tool);
        let length = tool.and_then(|tool| tool.length);
        let unstated = if self.has_table_axis && offset_mm.is_none() {
            Some(Unstated::WorkOffset { name: key.work_offset })
        } else if self.has_head_axis && length.is_none() {
            Some(Unstated::ToolLength)
        } else {
            None
        };
        // The same tool called in another way needs no new set-up.
        let known = self.made.iter().find(|made| {
            let Key { work_offset, is_only_offset, .. } = made.key;
            (work_offset, is_only_offset) == (key.work_offset, key.is_only_offset)
                && made.tool.and_then(|tool| tool.length) == length
        });
        let kinematics = known.map_or_else(
            || {
                let offset_mm = offset_mm.map_or_else(Vec3::zeros, Vec3::from);
                Arc::new(self.bare.set_up(offset_mm, length.unwrap_or(Length::ZERO).mm()))
            },
            |made| Arc::clone(&made.kinematics),
        );
        SetUp { key, kinematics, tool, unstated }
    }
}

impl SetUp {
    /// The nominal cutter, or the cutter that replaces it.
    #[inline]
    pub(in crate::process) fn cutter(&self) -> Option<Tool> {
        self.tool.and_then(|tool| tool.cutter())
    }

    /// Whether this section has an unknown tool while other tools are known.
    #[inline]
    pub(in crate::process) fn is_foreign(&self) -> bool {
        self.tool.is_none()
    }

    /// Whether only the length of such a tool is missing. Its motions are then left unchanged.
    #[inline]
    pub(in crate::process) fn lacks_foreign_length(&self) -> bool {
        self.is_foreign() && self.unstated == Some(Unstated::ToolLength)
    }

    /// The value that must be stated before the path of a motion that turns in machine interpolation can be
    /// computed.
    #[inline]
    pub(in crate::process) fn missing_for_turning(
        &self,
        mode: Interpolation,
        motion: &Motion,
    ) -> Option<LineFaultKind> {
        let unstated = self.unstated.filter(|_| mode == Interpolation::Machine)?;
        turns(motion).then_some(LineFaultKind::Unstated(unstated))
    }

    /// The value that must be stated before the position of a motion on the machine can be computed.
    #[inline]
    pub(in crate::process) fn missing_for_place(&self) -> Option<LineFaultKind> {
        self.unstated.map(LineFaultKind::Unstated)
    }

    /// Whether the position of a motion on the machine is known.
    pub(in crate::process) fn is_stated(&self) -> bool {
        self.unstated.is_none()
    }
}

/// Whether a rotary axis turns in a motion with known ends.
#[inline]
pub(in crate::process) fn turns(motion: &Motion) -> bool {
    let (Some(start), Some(end)) = (&motion.start, &motion.end) else { return false };
    turn_between(start, end)
}

/// Whether the rotary axes are at other positions at `end` than at `start`.
#[inline]
#[expect(clippy::float_cmp, reason = "words that did not move are equal to the bit")]
pub(in crate::process) fn turn_between(start: &AxisWords, end: &AxisWords) -> bool {
    start.rotary_deg != end.rotary_deg
}
