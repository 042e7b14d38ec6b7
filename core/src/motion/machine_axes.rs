//! The letters of a machine's axes in programs.

use crate::machine::{Machine, Side};
use crate::program::Address;

/// The letters of the five axes, and of the rotary axis that the machine does not have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct MachineAxes {
    /// Of the rotary axes in the profile's order.
    rotary: [Address; 2],
    foreign: Address,
    has_head_axis: bool,
}

/// The addresses of A B C.
const LETTERS: [Address; 3] = [Address::A, Address::B, Address::C];

/// The addresses of the rotary axes in programs, in the profile's order.
#[must_use]
pub fn rotary_addresses(machine: &Machine) -> [Address; 2] {
    machine.rotary_axes().each_ref().map(|axis| LETTERS[axis.letter as usize])
}

impl MachineAxes {
    pub(super) fn of(machine: &Machine) -> Self {
        let rotary = rotary_addresses(machine);
        Self {
            rotary,
            foreign: LETTERS.into_iter().find(|letter| !rotary.contains(letter)).unwrap_or(Address::C),
            has_head_axis: machine.rotary_axes().iter().any(|axis| axis.side == Side::Head),
        }
    }

    /// X Y Z and the rotary axes.
    #[inline]
    pub(super) const fn all(self) -> [Address; 5] {
        let [first, second] = self.rotary;
        [Address::X, Address::Y, Address::Z, first, second]
    }

    /// The rotary axes.
    #[inline]
    pub(super) const fn rotary(self) -> [Address; 2] {
        self.rotary
    }

    /// The letter among A B C that the machine lacks.
    #[inline]
    pub(super) const fn foreign(self) -> Address {
        self.foreign
    }

    /// Whether a rotary axis carries the tool.
    pub(super) const fn has_head_axis(self) -> bool {
        self.has_head_axis
    }
}
