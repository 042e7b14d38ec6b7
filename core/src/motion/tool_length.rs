//! The length that an H word puts in force, in ISO programs.

use super::interpreter::Interpreter;
use super::modal::ToolLength;
use crate::program::Address;

/// Z, across G17.
const Z: usize = 2;

impl Interpreter {
    /// H: behind G43 a bare one puts another length in force, so that the tip stands elsewhere. Where no length is in
    /// force it changes nothing, but some controls remember it: no more than Z is lost then.
    #[inline]
    pub(super) fn take_length_word(&mut self, may_be_skipped: bool) {
        if !self.block.has(Address::H) {
            return;
        }
        let number = self.block.value(Address::H);
        if number.is_none() || number != self.modal.length_number {
            self.other_length();
        }
        self.modal.length_number = number.filter(|_| !may_be_skipped);
    }

    /// Another length is in force, or may be: the tip stands elsewhere along the tool, which is Z only without
    /// tool-centre-point control, and in G17 where the control takes the length across the plane.
    fn other_length(&mut self) {
        let along_z = self.modal.tool_length == Some(ToolLength::Plain) && self.modal.plane == Some(2);
        if along_z {
            self.position.axes[Z] = None;
        } else {
            self.position.forget_linear();
        }
    }
}
