//! Two codes of one modal group in one block: controls take the first, the last, or refuse the block, so that the mode is
//! not known behind it.

use super::Unfollowable;
use super::codes::Code;
use super::interpreter::{Interpreter, at_bytes};
use super::modal::{Modal, Transformation};
use super::unit::UnitFrom;
use crate::program::{Address, Batch, Block, DiagnosticCode, Diagnostics, Dialect};

/// A modal group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Group {
    Motion,
    Units,
    Distance,
    FeedMode,
    Plane,
    Compensation,
    ToolLength,
    WorkOffset,
    Transformation(Transformation),
}

/// The group of a code, and a number that tells the states of the group apart. Codes that mean the same are one state.
fn state_of(code: Code, tenths: u32) -> Option<(Group, u64)> {
    Some(match code {
        // Which way an arc runs is in the code alone.
        Code::Motion(_) => (Group::Motion, u64::from(tenths)),
        Code::Units(mm_per_unit) => (Group::Units, mm_per_unit.to_bits()),
        Code::Incremental(on) => (Group::Distance, u64::from(on)),
        Code::Feed(mode) => (Group::FeedMode, mode as u64),
        Code::Plane(plane) => (Group::Plane, u64::from(plane)),
        Code::Compensation(on) => (Group::Compensation, u64::from(on)),
        Code::ToolLength(length) => (Group::ToolLength, length as u64),
        Code::WorkOffset => (Group::WorkOffset, u64::from(tenths)),
        // G69 ends both.
        Code::Transform(Transformation::Tilt, on) => {
            (Group::Transformation(Transformation::Rotation), u64::from(on))
        }
        Code::Transform(which, on) => (Group::Transformation(which), u64::from(on)),
        _ => return None,
    })
}

impl Interpreter {
    /// Behind a block with two codes of one group the group's mode is not known; without a unit the program is refused.
    /// `before` is the state before the block.
    pub(super) fn settle_conflicts(
        &mut self,
        batch: &Batch,
        block: &Block,
        before: &Modal,
        reason: &mut Option<Unfollowable>,
        diagnostics: &mut Diagnostics,
    ) {
        if self.block.g_count < 2 || !matches!(self.dialect, Dialect::Iso | Dialect::Siemens) {
            return;
        }
        let mut states = [None; 16];
        for index in 0..self.block.g_count {
            let tenths = self.block.g_codes().get(index).copied().unwrap_or_default();
            let state = state_of(self.code(index), tenths).filter(|_| !self.is_own_mode(tenths));
            let Some((group, value)) = state else { continue };
            let conflicts = states.iter().flatten().any(|&(other, old)| other == group && old != value);
            if conflicts {
                self.lose(group, before, reason);
                if group == Group::Units {
                    self.refuse_units(batch, block, diagnostics);
                }
            }
            if let Some(slot) = states.get_mut(index) {
                *slot = Some((group, value));
            }
        }
    }

    /// G54.2 and G54.4, which stand beside G54.
    fn is_own_mode(&self, tenths: u32) -> bool {
        self.dialect == Dialect::Iso && matches!(tenths, 542 | 544)
    }

    /// The mode of a group is not known any more.
    fn lose(&mut self, group: Group, before: &Modal, reason: &mut Option<Unfollowable>) {
        match group {
            Group::Motion => {
                self.modal.motion = None;
                *reason = Some(Unfollowable::ConflictingCodes);
            }
            Group::Units => {
                self.modal.void_feed();
                self.modal.mm_per_unit = None;
                self.unit_from = UnitFrom::Refused;
            }
            Group::Distance => self.modal.incremental = None,
            Group::FeedMode => {
                self.modal.void_feed();
                self.modal.feed_mode = None;
            }
            Group::Plane => self.modal.plane = None,
            Group::Compensation => self.modal.compensation = None,
            Group::ToolLength => {
                self.position.forget_linear();
                self.position.tool_axis = [None; 3];
                self.modal.tool_length = None;
                self.modal.kinematics_switched = before.kinematics_switched;
            }
            Group::WorkOffset => self.set_work_offset(None),
            Group::Transformation(which) => {
                self.set_transformation(which, None);
                if which == Transformation::Rotation {
                    self.set_transformation(Transformation::Tilt, None);
                }
            }
        }
    }

    fn refuse_units(&mut self, batch: &Batch, block: &Block, diagnostics: &mut Diagnostics) {
        let mut units = (0..self.block.g_count)
            .filter(|&index| matches!(self.code(index), Code::Units(_)))
            .filter_map(|index| self.block.g_codes().get(index).copied());
        let (Some(first), Some(last)) = (units.next(), units.next_back()) else { return };
        let codes = [first, last].map(|tenths| tenths / 10);
        let word = batch.words(block).iter().find(|word| {
            word.address == Address::G && word.code_tenths().is_some_and(|tenths| tenths == last)
        });
        let (start, end) = word.map_or((block.start, block.body_end), |word| (word.start, word.end));
        diagnostics.push(at_bytes(batch, block, start, end, DiagnosticCode::TwoUnits { codes }));
    }
}
