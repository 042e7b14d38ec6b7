//! Where the program's zero is, and how its axes are turned, scaled and mirrored.

use super::WorkOffset;
use super::block_words::AXES;
use super::interpreter::Interpreter;
use super::meaning::Meaning;
use super::modal::Transformation;
use super::work_offset::OffsetCode;
use crate::program::Address;

/// Axes whose zero G52 shifts.
const MOVED: [Address; 9] = [
    Address::X,
    Address::Y,
    Address::Z,
    Address::A,
    Address::B,
    Address::C,
    Address::U,
    Address::V,
    Address::W,
];
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

    /// Whether the block ends the shift of a program that shifted nothing so far: G92.1, G92.2, G52 with zeros.
    pub(super) fn ends_no_shift(&self) -> bool {
        let has_zeros = || {
            let named = |address: &Address| self.block.has(*address);
            let is_zero = |address| self.block.value(address) == Some(0.0);
            MOVED.iter().any(named) && MOVED.into_iter().filter(named).all(is_zero)
        };
        let ends = |index| match self.meaning(index) {
            Meaning::LocalShift => has_zeros(),
            Meaning::Shift | Meaning::OtherShift => false,
            _ => true,
        };
        self.modal.shifts == 0 && (0..self.block.g_count).all(ends)
    }

    /// A mode beside the work offset: on by its P word, ended by P0.
    pub(super) fn set_mode_by_p(&mut self, mode: Transformation) {
        let on = self.block.value(Address::P).map(|p| p.abs() > 0.0);
        self.set_transformation(mode, on);
    }

    /// The work offset of a code, or the one of this number among those of the code.
    pub(super) fn select_offset(&mut self, code: OffsetCode, by: Option<Address>) {
        let offset = match by.filter(|address| self.block.has(*address)) {
            Some(address) => self.number_of(address).map(|number| WorkOffset::numbered(code, number)),
            None => Some(WorkOffset::Code(code)),
        };
        self.set_work_offset(offset);
    }

    /// The whole number of a word, if it is one.
    pub(super) fn number_of(&self, address: Address) -> Option<u16> {
        let number = self.block.value(address)?;
        let is_whole = number.fract() == 0.0 && (0.0..=f64::from(u16::MAX)).contains(&number);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked range")]
        is_whole.then_some(number as u16)
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

    pub(super) fn set_work_offset(&mut self, offset: Option<WorkOffset>) {
        let before = self.modal.work_offset;
        self.modal.work_offset = offset;
        if offset.is_some() && offset == before {
            return;
        }
        // Offsets that are stated differ in X Y Z alone: rotary axes stay where they are.
        let is_stated = |offset: Option<WorkOffset>| {
            offset.is_some_and(|offset| {
                self.options.work_offsets.of(offset, self.is_only_offset(offset)).is_some()
            })
        };
        if is_stated(before) && is_stated(offset) {
            self.position.forget_linear();
        } else {
            self.position.forget_axes();
        }
        if !self.has_motions() {
            self.stand_at_start();
        }
    }

    /// Whether this is the offset of the program's first point. What is in force before an ISO program names any is G54; in
    /// other dialects nobody knows.
    pub(super) fn is_only_offset(&self, offset: WorkOffset) -> bool {
        let named = |offset| match offset {
            WorkOffset::Unnamed => self.rules.first_offset.unwrap_or(WorkOffset::Unnamed),
            offset => offset,
        };
        self.only_offset.is_none_or(|only| named(only) == named(offset))
    }

    /// The axes stand where the caller says that they do at the start.
    pub(super) fn stand_at_start(&mut self) {
        for (axis, start) in self.position.axes.iter_mut().zip(self.options.start) {
            *axis = start.or(*axis);
        }
    }

    pub(super) fn transform(&mut self, which: Transformation, on: bool) {
        self.set_transformation(which, Some(on));
    }

    pub(super) fn set_transformation(&mut self, which: Transformation, on: Option<bool>) {
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
