//! Two codes of one modal group in one block. Controls take the first code, take the last code, or refuse the block.
//! So the mode is not known after it.

use super::Unfollowable;
use super::interpreter::{Interpreter, at_bytes};
use super::meaning::Meaning;
use super::modal::{Modal, Transformation};
use crate::program::{Batch, Block, Code, DiagnosticCode, Diagnostics};

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
    /// G53 to G56 of OSP.
    LengthAxis,
    WorkOffset,
    Transformation(Transformation),
}

/// The state of a group. Codes that mean the same are one state.
#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    Code(Code),
    Value(f64),
    Number(u8),
}

/// No tool length, among the axes of a tool length.
const NO_AXIS: u8 = u8::MAX;

/// The group of a code, and the state that the code puts in force.
fn state_of(meaning: Meaning, code: Code) -> Option<(Group, State)> {
    let number = |on: bool| State::Number(u8::from(on));
    if let Meaning::LengthAlong(axis) = meaning {
        return Some((Group::LengthAxis, State::Number(axis.unwrap_or(NO_AXIS))));
    }
    if let Some(length) = meaning.tool_length() {
        return Some((Group::ToolLength, State::Number(length as u8)));
    }
    if let Some((which, on)) = meaning.transformation() {
        // G69 ends both.
        let is_tilt = which == Transformation::Tilt;
        let group = if is_tilt { Transformation::Rotation } else { which };
        return Some((Group::Transformation(group), number(on)));
    }
    Some(match meaning {
        // Only the code says in which direction an arc runs.
        Meaning::Motion(_) => (Group::Motion, State::Code(code)),
        Meaning::Units(mm_per_unit) => (Group::Units, State::Value(mm_per_unit)),
        Meaning::Incremental(on) => (Group::Distance, number(on)),
        Meaning::Feed(mode) => (Group::FeedMode, State::Number(mode as u8)),
        Meaning::Plane(plane) => (Group::Plane, State::Number(plane)),
        Meaning::Compensation(on) => (Group::Compensation, number(on)),
        Meaning::CompensationByDiameter { .. } | Meaning::CompensationByRegister { .. } => {
            (Group::Compensation, State::Code(code))
        }
        Meaning::WorkOffset(_) | Meaning::WorkOffsetByP(_) => (Group::WorkOffset, State::Code(code)),
        _ => return None,
    })
}

impl Interpreter {
    /// After a block with two codes of one group the group's mode is not known. If the unit is lost, the program is
    /// refused. `before` is the state before the block.
    pub(super) fn settle_conflicts(
        &mut self,
        batch: &Batch,
        block: &Block,
        before: &Modal,
        reason: &mut Option<Unfollowable>,
        diagnostics: &mut Diagnostics,
    ) {
        if self.block.g_count < 2 || !self.rules.two_codes_conflict {
            return;
        }
        let mut states = [None; 16];
        for index in 0..self.block.g_count {
            let Some(&code) = self.block.g_codes().get(index) else { break };
            let Some((group, value)) = state_of(self.meaning(index), code) else { continue };
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

    /// The mode of a group is no longer known.
    fn lose(&mut self, group: Group, before: &Modal, reason: &mut Option<Unfollowable>) {
        match group {
            Group::Motion => {
                self.modal.motion = None;
                *reason = Some(Unfollowable::ConflictingCodes);
            }
            Group::Units => self.lose_unit(),
            Group::Distance => self.modal.incremental = None,
            Group::FeedMode => self.modal.count_feed(None),
            Group::Plane => self.modal.plane = None,
            Group::Compensation => self.modal.compensation = None,
            Group::ToolLength => {
                self.lose_tool_length();
                self.position.forget_tool_axis();
                self.modal.kinematics_switched = before.kinematics_switched;
            }
            Group::LengthAxis => {
                self.modal.length_number = None;
                self.position.forget_linear();
                self.set_transformation(Transformation::ToolAxis, None);
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
            .filter(|&index| matches!(self.meaning(index), Meaning::Units(_)))
            .filter_map(|index| self.block.g_codes().get(index).copied());
        let (Some(first), Some(last)) = (units.next(), units.next_back()) else { return };
        let codes = [first, last].map(|code| if let Code::G(tenths) = code { tenths / 10 } else { 0 });
        let word = batch.words(block).iter().find(|word| word.code() == Some(last));
        let (start, end) = word.map_or((block.start, block.body_end), |word| (word.start, word.end));
        diagnostics.push(at_bytes(batch, block, start, end, DiagnosticCode::TwoUnits { codes }));
    }
}
