//! Which tool is in the spindle, as far as the program says.

use crate::program::{Address, Keyword, Word, WordForm};

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
/// `CUTTER/` is another tool.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Spindle {
    ready: ToolCall,
    holds: ToolCall,
    /// P of the last `CUTTER/`.
    cutter: Option<u64>,
    /// The tool of the first cut.
    first_cut_with: Option<ToolCall>,
    /// A tool came in since the first cut that is not known to be the same as the one before.
    was_changed: bool,
}

impl Spindle {
    /// Takes a block's words; T counts for an M6 of its own block wherever it stands.
    pub(super) fn see<'w>(&mut self, words: impl Iterator<Item = &'w Word>) {
        let (mut puts_in, mut is_cutter) = (false, false);
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
                Address::T => self.ready = ToolCall::of(word),
                Address::M => puts_in |= word.code_tenths() == Some(TOOL_CHANGE),
                _ => {}
            }
        }
        if puts_in {
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
            (self.first_cut_with, self.was_changed) = (Some(self.holds), false);
            return false;
        };
        self.was_changed && (first == ToolCall::Unknown || first != self.holds)
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
