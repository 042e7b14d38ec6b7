//! G43.5: I J K are the tool axis.

use super::codes::{Code, iso_meaning};
use super::interpreter::Interpreter;
use super::modal::{MotionMode, ToolLength};
use crate::program::{Address, Word};

/// G43.5, in tenths.
const VECTOR_CODE: u32 = 435;

impl Interpreter {
    /// Whether I J K of a block are the tool axis: G43.5 holds, and the motion is no arc.
    #[inline]
    pub(super) fn takes_vector(&self, words: &[Word]) -> bool {
        let is_vector = |word: &Word| word.address == Address::G && word.code_tenths() == Some(VECTOR_CODE);
        if self.modal.tool_length != Some(ToolLength::Vector) && !words.iter().any(is_vector) {
            return false;
        }
        let is_straight = |mode| matches!(mode, MotionMode::Rapid | MotionMode::Linear);
        let mut vector = true;
        let mut straight = self.modal.motion.is_some_and(is_straight);
        for word in words.iter().filter(|word| word.address == Address::G) {
            match word.code_tenths().map(iso_meaning) {
                Some(Code::ToolLength(length)) => vector = length == ToolLength::Vector,
                Some(Code::Motion(mode)) => straight = is_straight(mode),
                _ => {}
            }
        }
        vector && straight
    }
}
