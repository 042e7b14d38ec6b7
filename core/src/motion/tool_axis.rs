//! G43.5: I J K are the tool axis.

use super::interpreter::Interpreter;
use super::meaning::Meaning;
use super::modal::{MotionMode, ToolLength};
use crate::program::{Address, Code, Word};

/// G43.5.
const VECTOR_CODE: Code = Code::G(435);

impl Interpreter {
    /// Whether I J K of a block are the tool axis: G43.5 is active, and the motion is not an arc.
    #[inline]
    pub(super) fn takes_vector(&self, words: &[Word]) -> bool {
        let is_vector = |word: &Word| word.code() == Some(VECTOR_CODE);
        if self.modal.tool_length != Some(ToolLength::Vector) && !words.iter().any(is_vector) {
            return false;
        }
        let is_straight = |mode| matches!(mode, MotionMode::Rapid | MotionMode::Linear);
        let mut vector = true;
        let mut straight = self.modal.motion.is_some_and(is_straight);
        for word in words.iter().filter(|word| word.address == Address::G) {
            let Some(meaning) = word.code().map(|code| self.rules.meaning(code)) else { continue };
            if let Some(length) = meaning.tool_length() {
                vector = length == ToolLength::Vector;
            } else if let Meaning::Motion(mode) = meaning {
                straight = is_straight(mode);
            }
        }
        vector && straight
    }
}
