//! Where the program's zero is, and how its axes are turned, scaled and mirrored.

use super::interpreter::{AXES, Interpreter};
use super::modal::Transformation;
use crate::program::{Address, Dialect};

/// G54.2 and G54.4: modes of their own, not work offsets.
const FIXTURE_OFFSET: u32 = 542;
const SETUP_ERROR: u32 = 544;

impl Interpreter {
    /// G10: L2 and L20 are work offsets, and so may be what has no L or an unseen one; other tables are tool offsets: the
    /// length may be the active one.
    pub(super) fn write_offsets(&mut self) {
        let table = self.block.value(Address::L);
        if table.is_none_or(|l| [2.0, 20.0].iter().any(|offsets| (l - offsets).abs() < 0.5)) {
            self.shift_offsets();
        } else {
            self.position.forget_linear();
        }
    }

    pub(super) fn change_work_offset(&mut self, code: u32) {
        let mode = match code {
            FIXTURE_OFFSET => Some(Transformation::FixtureOffset),
            SETUP_ERROR => Some(Transformation::SetupError),
            _ => None,
        };
        if let Some(mode) = mode.filter(|_| self.dialect != Dialect::Siemens) {
            // P0 ends it.
            let on = self.block.value(Address::P).map(|p| p.abs() > 0.0);
            return self.set_transformation(mode, on);
        }
        let has_p = matches!(code, 540 | 541 | 1540) && self.block.has(Address::P);
        let offset = if has_p { self.numbered(code, Address::P) } else { Some(code << 16) };
        self.set_work_offset(offset);
    }

    /// A work offset that this word tells apart from others of its code; none where it cannot be read.
    pub(super) fn numbered(&self, code: u32, address: Address) -> Option<u32> {
        let number = self.block.value(address).filter(|number| (0.0..60_000.0).contains(number))?;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked range")]
        Some((code << 16) + 1 + number as u32)
    }

    /// G51.1 mirrors the axes it names, G50.1 takes it back for those it names; without any, for all.
    pub(super) fn mirror(&mut self, on: bool) {
        let named = match self.block.present & AXES {
            0 => u32::MAX,
            named => named,
        };
        let mirrored = self.modal.mirrored_axes;
        self.modal.mirrored_axes = if on { mirrored | named } else { mirrored & !named };
        self.transform(Transformation::Mirror, self.modal.mirrored_axes != 0);
    }

    pub(super) fn set_work_offset(&mut self, offset: Option<u32>) {
        if offset.is_none() || offset != self.modal.work_offset {
            self.position.forget_axes();
        }
        self.modal.work_offset = offset;
    }

    pub(super) fn transform(&mut self, which: Transformation, on: bool) {
        if which == Transformation::Rotation && !on && self.dialect == Dialect::Iso {
            self.transform(Transformation::Tilt, false);
        }
        self.set_transformation(which, Some(on));
    }

    fn set_transformation(&mut self, which: Transformation, on: Option<bool>) {
        if let Some(state) = self.modal.transformations.get_mut(which as usize)
            && *state != on
        {
            *state = on;
            self.position.forget_axes();
        }
    }

    /// Whether G07 names its axis with another number than 0.
    pub(super) fn is_hypothetical_end(&self) -> bool {
        let letters = [Address::X, Address::Y, Address::Z, Address::A, Address::B, Address::C];
        letters
            .into_iter()
            .filter(|axis| self.block.has(*axis))
            .all(|axis| self.block.value(axis).is_some_and(|value| value != 0.0))
    }

    pub(super) fn is_cylinder_end(&self) -> bool {
        [Address::A, Address::B, Address::C].into_iter().any(|axis| self.block.value(axis) == Some(0.0))
    }
}
