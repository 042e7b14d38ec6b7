//! Which tool is in the spindle, as far as the program says.

use crate::program::{Address, Dialect, Keyword, Word, WordForm};

/// M6, in tenths.
const TOOL_CHANGE: u32 = 60;

/// A tool as the program calls it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum ToolCall {
    /// The one that was there from the start, or one whose T is an expression or a name.
    #[default]
    Unknown,
    /// By its T word.
    Number(u32),
}

/// The spindle along a program: a T word makes a tool ready, M6 puts it in; `TOOL CALL` and `LOADTL/` do both. Another
/// `CUTTER/` is another tool. In a Sinumerik program that has had no M6 yet, T may be the change itself, and another D is
/// another edge.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Spindle {
    ready: ToolCall,
    holds: ToolCall,
    /// What a T word called last that may have been the change itself.
    called: ToolCall,
    /// P of the last `CUTTER/`.
    cutter: Option<u64>,
    /// The tool of the first cut.
    first_cut_with: Option<ToolCall>,
    /// A tool came in since the first cut that is not known to be the same as the one before.
    was_changed: bool,
    has_changer: bool,
    /// The edge by D of a Sinumerik program, and that of the first cut.
    edge: Option<u64>,
    first_edge: Option<u64>,
}

/// D where none is written.
const FIRST_EDGE: f64 = 1.0;

impl Spindle {
    /// Takes a block's words; T counts for an M6 of its own block wherever it stands.
    pub(super) fn see<'w>(&mut self, dialect: Dialect, words: impl Iterator<Item = &'w Word>) {
        let (mut puts_in, mut is_cutter, mut names_tool, mut edge) = (false, false, false, None);
        for word in words {
            match word.address {
                Address::G => match word.keyword() {
                    Some(Keyword::ToolCall) => (puts_in, self.ready) = (true, ToolCall::Unknown),
                    Some(Keyword::Cutter) => is_cutter = true,
                    _ => {}
                },
                Address::P if is_cutter => {
                    let shape = Some(word.value.to_bits());
                    (puts_in, self.ready) = (self.cutter != shape, ToolCall::Unknown);
                    self.cutter = shape;
                }
                Address::T => (names_tool, self.ready) = (true, ToolCall::of(word)),
                Address::D if dialect == Dialect::Siemens => {
                    let value = if word.form == WordForm::Number { word.value } else { f64::NAN };
                    edge = Some(value.to_bits());
                }
                Address::M => puts_in |= word.code_tenths() == Some(TOOL_CHANGE),
                _ => {}
            }
        }
        if names_tool || edge.is_some() {
            self.edge = edge;
        }
        self.has_changer |= puts_in;
        if names_tool && dialect == Dialect::Siemens && !self.has_changer {
            self.was_changed |= self.ready == ToolCall::Unknown || self.ready != self.called;
            self.called = self.ready;
        }
        if puts_in {
            self.called = self.ready;
            let same = self.ready != ToolCall::Unknown && self.ready == self.holds;
            self.was_changed |= !same;
            self.holds = self.ready;
        }
    }

    /// Whether motions are those of the tool with this number; without a number all are.
    pub(super) fn holds(&self, number: Option<u32>) -> bool {
        number.is_none_or(|number| self.holds == ToolCall::Number(number))
    }

    /// A cut: whether an earlier one was made by another tool, as far as can be told.
    pub(super) fn cuts_with_another(&mut self) -> bool {
        let Some(first) = self.first_cut_with else {
            (self.first_cut_with, self.was_changed) = (Some(self.called), false);
            self.first_edge = self.edge;
            return false;
        };
        let bits = |edge: Option<u64>| edge.unwrap_or(FIRST_EDGE.to_bits());
        bits(self.edge) != bits(self.first_edge)
            || (self.was_changed && (first == ToolCall::Unknown || first != self.called))
    }
}

impl ToolCall {
    fn of(word: &Word) -> Self {
        let is_number = word.form == WordForm::Number && word.value.fract() == 0.0;
        if !is_number || !(0.0..=f64::from(u32::MAX)).contains(&word.value) {
            return Self::Unknown;
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number in range"
        )]
        let number = word.value as u32;
        Self::Number(number)
    }
}
