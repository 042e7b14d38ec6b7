//! Labelled sections of a program that are called from elsewhere.
//!
//! A label alone is harmless. If a section was passed before it is called, it has already been followed. The effect of
//! its call is known if nothing in it depends on the place of the call. To find out, a second control that knows
//! nothing at the label runs along. A section with motions that were followed cannot also be called: such a program is
//! refused.

use super::execute::Action;
use super::interpreter::Interpreter;
use super::modal::{Modal, ModalFeed};
use super::position::Position;
use super::{CalledTool, Motion, Spindle, Unfollowable};
use crate::program::{Address, Batch, Block, Diagnostics};

/// The most labels that are distinguished.
const MAX_SECTIONS: usize = 1024;
/// The most blocks of a section whose effect is computed.
const MAX_BLOCKS: u32 = 1000;

/// Everything that a control knows.
type State = (Modal, Position);

/// A section of the program that the control has passed.
#[derive(Debug, Clone)]
struct Section {
    label: u64,
    /// Motions followed before the section, and before its end if the end was passed.
    followed: u64,
    followed_at_end: Option<u64>,
    effect: Option<Effect>,
}

/// The effect of a section: the states at its start and end, of the control that runs the program and of a control
/// that knows nothing.
#[derive(Debug, Clone)]
struct Effect {
    program: [State; 2],
    stranger: [State; 2],
}

/// A section that is being passed.
#[derive(Debug, Clone)]
struct Passing {
    section: usize,
    blocks: u32,
    program: State,
    stranger_start: State,
    stranger: Box<Interpreter>,
}

/// The sections of a program so far.
#[derive(Debug, Clone, Default)]
pub(super) struct Sections {
    passed: Vec<Section>,
    /// Labels that were called before they were passed.
    called: Vec<u64>,
    /// A parameter called a label, or there are more labels than are distinguished. So any label may be meant.
    any_called: bool,
    passing: Option<Passing>,
    /// The text belongs to a section that was called before.
    pub(super) is_called_text: bool,
    /// Motions that were followed so far.
    followed: u64,
}

impl Sections {
    /// Whether a section that may be called is being passed.
    pub(super) fn is_passing(&self) -> bool {
        self.passing.is_some()
    }

    /// Counts the motions of a block.
    pub(super) fn count(&mut self, motions: &[Motion]) {
        let followed = |motion: &&Motion| {
            matches!(motion.unfollowable, None | Some(Unfollowable::ToolVector))
                && motion.linear_end_mm.is_some()
        };
        self.followed += motions.iter().filter(followed).count() as u64;
    }
}

impl Interpreter {
    /// The control that knows nothing runs along.
    pub(super) fn run_along(&mut self, batch: &Batch, index: usize, block: &Block) {
        let Some(passing) = &mut self.sections.passing else { return };
        passing.blocks += 1;
        let mut unheard = Diagnostics::new();
        passing.stranger.interpret_block(batch, index, block, &mut Vec::new(), &mut unheard);
        if passing.blocks > MAX_BLOCKS {
            self.sections.passing = None;
        }
    }

    fn state(&self) -> State {
        (self.modal, self.position)
    }

    pub(super) fn pass_label(&mut self) {
        if self.is_stranger {
            // A section within a section: a call may also enter it here.
            return self.forget_all();
        }
        let label = self.block.value(Address::P).map(f64::to_bits);
        let is_called =
            label.is_none_or(|label| self.sections.called.contains(&label)) || self.sections.any_called;
        self.sections.is_called_text |= is_called;
        if is_called {
            self.forget_all();
        }
        let Some(label) = label.filter(|_| self.sections.passed.len() < MAX_SECTIONS) else {
            self.sections.any_called = true;
            return;
        };
        let section = self.sections.passed.len();
        let followed = self.sections.followed;
        self.sections.passed.push(Section { label, followed, followed_at_end: None, effect: None });
        let mut stranger = Box::new(self.stranger());
        stranger.forget_all();
        stranger.modal.spindle = Spindle::UNKNOWN;
        self.sections.passing = Some(Passing {
            section,
            blocks: 0,
            program: self.state(),
            stranger_start: stranger.state(),
            stranger,
        });
    }

    /// `LBL 0`
    pub(super) fn end_section(&mut self) {
        if self.is_stranger {
            return;
        }
        let state = self.state();
        if let Some(passing) = self.sections.passing.take()
            && let Some(section) = self.sections.passed.get_mut(passing.section)
        {
            section.effect = Some(Effect {
                program: [passing.program, state],
                stranger: [passing.stranger_start, passing.stranger.state()],
            });
        }
        let followed = self.sections.followed;
        for section in
            self.sections.passed.iter_mut().rev().take_while(|section| section.followed_at_end.is_none())
        {
            section.followed_at_end = Some(followed);
        }
        if self.sections.is_called_text {
            self.sections.is_called_text = false;
            self.forget_all();
        }
    }

    /// `CALL LBL`, with REP where it `repeats` the text from the label to here.
    pub(super) fn call_label(&mut self, repeats: bool) -> Option<Action> {
        let Some(label) = self.block.value(Address::P).map(f64::to_bits) else {
            self.sections.any_called = true;
            let any_followed = self.sections.followed > 0 && !self.sections.passed.is_empty();
            self.this_block.flow = any_followed || repeats;
            return Some(Action::Call);
        };
        let found = self.sections.passed.iter().rposition(|section| section.label == label);
        let Some(index) = found else {
            if !self.sections.called.contains(&label) && !self.is_stranger {
                if self.sections.called.len() < MAX_SECTIONS {
                    self.sections.called.push(label);
                } else {
                    self.sections.any_called = true;
                }
            }
            self.this_block.flow = repeats;
            return Some(Action::Call);
        };
        let section = self.sections.passed.get(index)?;
        let end = if repeats { None } else { section.followed_at_end };
        let followed = end.unwrap_or(self.sections.followed) - section.followed;
        self.this_block.flow = followed > 0;
        if repeats || section.effect.is_none() {
            return Some(Action::Call);
        }
        self.this_block.section = Some(index);
        Some(Action::Odd(Unfollowable::Call))
    }

    /// Applies the effect of calling a section that was passed.
    pub(super) fn apply_section(&mut self, index: usize) {
        let effect = self.sections.passed.get(index).and_then(|section| section.effect.clone());
        match effect {
            Some(Effect { program: [from, to], stranger: [blank, set] }) => {
                self.modal = self.modal.behind([&from.0, &to.0], [&blank.0, &set.0]);
                self.position = self.position.behind([&from.1, &to.1], [&blank.1, &set.1]);
                self.find_obstacle();
            }
            None => self.forget_all(),
        }
    }
}

/// A value that may become unknown.
pub(super) trait Knowable: PartialEq + Copy {
    /// Whether it is known.
    fn is_known(&self) -> bool;
}

impl<T: PartialEq + Copy> Knowable for Option<T> {
    fn is_known(&self) -> bool {
        self.is_some()
    }
}

impl Knowable for [Option<f64>; 3] {
    fn is_known(&self) -> bool {
        self.iter().all(Option::is_some)
    }
}

impl Knowable for ModalFeed {
    fn is_known(&self) -> bool {
        *self != Self::Unknown
    }
}

impl Knowable for Spindle {
    fn is_known(&self) -> bool {
        !matches!(self.tool(), CalledTool::Unknown(_))
    }
}

impl Knowable for bool {
    fn is_known(&self) -> bool {
        true
    }
}

impl Knowable for u32 {
    fn is_known(&self) -> bool {
        true
    }
}

/// The value after a section. If the section leaves the value unchanged, it is the caller's value; otherwise it is the
/// value that the section sets whatever was before. If the program did not know the value before the section, the
/// section may have lost it.
pub(super) fn behind<T: Knowable>(caller: T, program: [T; 2], stranger: [T; 2]) -> T {
    let left_alone = program[0].is_known() && program[0] == program[1] && stranger[0] == stranger[1];
    if left_alone { caller } else { stranger[1] }
}
