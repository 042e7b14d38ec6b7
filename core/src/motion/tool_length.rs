//! The tool length group: the length in force, its axis, and whether the control follows the tip.

use super::Unfollowable;
use super::interpreter::Interpreter;
use super::meaning::Meaning;
use super::modal::{ToolLength, Transformation};
use crate::program::Address;

/// Z, perpendicular to G17.
const Z: usize = 2;

impl Interpreter {
    /// H. After G43 an H alone puts another length in force, so the tip is elsewhere. If no length is in force, H
    /// changes nothing, but some controls remember it. Then at most Z becomes unknown.
    #[inline]
    pub(super) fn take_length_word(&mut self, may_be_skipped: bool) {
        if !self.block.has(Address::H) || self.names_offset_by_h() || self.names_radius_by_h() {
            return;
        }
        self.note_radius_change();
        let number = self.block.value(Address::H);
        if number.is_none() || number != self.modal.length_number {
            self.other_length();
        }
        self.modal.length_number = number.filter(|_| !may_be_skipped);
        self.modal.had_length |= number.is_some_and(|number| number > 0.0);
    }

    /// Whether H is the number of a work offset.
    fn names_offset_by_h(&self) -> bool {
        let names = |index| matches!(self.meaning(index), Meaning::OffsetByH | Meaning::OffsetByHHere);
        (0..self.block.g_count).any(names)
    }

    /// A tool length of the group of G43 and G49.
    pub(super) fn set_tool_length(&mut self, length: ToolLength) {
        if self.modal.tool_length == Some(ToolLength::Vector) && length != ToolLength::Vector {
            self.position.forget_tool_axis();
        }
        if self.modal.tool_length == Some(length) {
            // The length may be another one, so Z is not known until the program states it again.
            self.position.axes[Z] = None;
        } else {
            self.position.forget_linear();
        }
        self.modal.tool_length = Some(length);
    }

    /// TRAORI and TRAFOOF. They also end every other transformation of the kinematics.
    pub(super) fn switch_tip(&mut self, length: ToolLength) {
        self.transform(Transformation::Cylinder, false);
        if self.modal.tool_length != Some(length) {
            self.position.forget_linear();
            self.position.forget_tool_axis();
            self.modal.tool_length = Some(length);
        }
    }

    /// M128, M129, TCPM. Positions stay known if the state does not change.
    pub(super) fn set_tcp(&mut self, on: bool) {
        let wanted = if on { ToolLength::Tcp } else { ToolLength::Plain };
        if self.modal.tool_length != Some(wanted) {
            self.position.forget_linear();
            self.modal.tool_length = Some(wanted);
        }
    }

    /// The length in force becomes unknown, and also whether the control follows the tip.
    pub(super) fn lose_tool_length(&mut self) {
        self.modal.tool_length = None;
        self.position.forget_linear();
    }

    /// G53 to G56 of OSP: the tool's length along this axis, or no length. H has already been read. With a length
    /// along X or Y the tool points along that axis.
    pub(super) fn take_length_along(&mut self, axis: Option<u8>) {
        self.transform(Transformation::ToolAxis, axis.is_some_and(|axis| usize::from(axis) != Z));
        self.modal.has_no_length = axis.is_none();
        if axis.is_none() {
            self.modal.length_number = None;
        }
        // Without a number the length is not known.
        if self.modal.length_number.is_none() {
            self.other_length();
        }
    }

    /// The reason why a block with G16 of OSP counts from another place. H0 is the machine's zero.
    pub(super) fn offset_here(&self) -> Unfollowable {
        match self.number_of(Address::H) {
            Some(0) => Unfollowable::MachineCoordinates,
            _ => Unfollowable::OffsetHere,
        }
    }

    /// Another length is in force, or may be, so the tip is elsewhere along the tool. This direction is Z only
    /// without tool-centre-point control. On controls that take the length perpendicular to the plane, it is Z only in
    /// G17.
    fn other_length(&mut self) {
        let along_z = self.modal.tool_length == Some(ToolLength::Plain) && self.modal.plane == Some(2);
        if along_z {
            self.position.axes[Z] = None;
        } else {
            self.position.forget_linear();
        }
    }
}
