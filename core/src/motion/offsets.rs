//! The position of the program's zero, and how its axes are turned, scaled and mirrored.

use super::WorkOffset;
use super::block_words::AXES;
use super::interpreter::Interpreter;
use super::meaning::Meaning;
use super::modal::Transformation;
use super::work_offset::OffsetCode;
use crate::geometry::Turn;
use crate::program::Address;

/// Axes whose zero is shifted by G52.
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
    /// G10: L2 and L20 are work offsets. Without an L, or with an L of unknown value, it may also be a work offset.
    /// Other tables are tool offsets: the length may be the active one, and the radius that of any register.
    pub(super) fn write_offsets(&mut self) {
        let table = self.block.value(Address::L);
        if self.write_zero() {
            return;
        }
        let is_work_offset = table.map(|l| [2.0, 20.0].iter().any(|offsets| (l - offsets).abs() < 0.5));
        self.modal.writes_radii |= is_work_offset != Some(true);
        if is_work_offset == Some(false) {
            self.position.forget_linear();
            self.modal.writes_lengths = true;
        } else {
            self.shift_offsets();
        }
    }

    /// Values of the control are assigned: offsets of any kind.
    pub(super) fn assign_system(&mut self) {
        self.modal.writes_radii = true;
        self.shift_offsets();
    }

    /// Whether the block ends a shift (G92.1, G92.2, G52 with zeros) in a program that has shifted nothing so far.
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
        self.modal.shifts == 0 && !self.zeros.has_written() && (0..self.block.g_count).all(ends)
    }

    /// A mode beside the work offset. Its P word switches it on, and P0 ends it.
    pub(super) fn set_mode_by_p(&mut self, mode: Transformation) {
        let on = self.block.value(Address::P).map(|p| p.abs() > 0.0);
        self.set_transformation(mode, on);
    }

    /// The work offset of a code, or the offset with this number among those of the code.
    pub(super) fn select_offset(&mut self, code: OffsetCode, by: Option<Address>) {
        let offset = match by.filter(|address| self.block.has(*address)) {
            Some(address) => self.number_of(address).map(|number| WorkOffset::numbered(code, number)),
            None => Some(WorkOffset::Code(code)),
        };
        self.set_work_offset(offset);
    }

    /// The whole number of a word, if it has one.
    pub(super) fn number_of(&self, address: Address) -> Option<u16> {
        let number = self.block.value(address)?;
        let is_whole = number.fract() == 0.0 && (0.0..=f64::from(u16::MAX)).contains(&number);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked range")]
        is_whole.then_some(number as u16)
    }

    /// G51.1 mirrors the axes that it names. G50.1 takes this back for the axes that it names. Without axes both act
    /// on all axes.
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
        if self.zeros.has_written() {
            return self.change_zero(before);
        }
        // Stated offsets differ only in X Y Z, so the rotary axes stay at their positions.
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

    /// Whether this is the offset of the program's first point. Before an ISO program names an offset, G54 is in
    /// force. In other dialects the offset is not known.
    pub(super) fn is_only_offset(&self, offset: WorkOffset) -> bool {
        let named = |offset| match offset {
            WorkOffset::Unnamed => self.rules.first_offset.unwrap_or(WorkOffset::Unnamed),
            offset => offset,
        };
        self.only_offset.is_none_or(|only| named(only) == named(offset))
    }

    /// Puts the axes at the start positions that the caller states.
    pub(super) fn stand_at_start(&mut self) {
        // A list of points states the tool's axis and no rotary axis, from its first point on.
        let stated = if self.rules.is_of_points { 3 } else { 5 };
        for (axis, start) in self.position.axes.iter_mut().zip(self.options.start).take(stated) {
            *axis = start.or(*axis);
        }
    }

    pub(super) fn transform(&mut self, which: Transformation, on: bool) {
        self.set_transformation(which, Some(on));
    }

    pub(super) fn set_transformation(&mut self, which: Transformation, on: Option<bool>) {
        // Whatever a plane was, the code has ended or changed it.
        let is_plane = matches!(which, Transformation::Tilt | Transformation::Swivel);
        let plane = self.modal.tilt.take_if(|_| is_plane);
        if which == Transformation::Rotation && self.zeros.has_written() {
            self.lose_zeros();
        }
        if which == Transformation::Rotation
            && let Some(turn) = self.modal.turn.take()
            && on == Some(false)
        {
            // The rotary axes keep their positions under a turn that is followed.
            if turn != Turn::NONE {
                self.position.forget_linear();
            }
            self.modal.transformations[Transformation::Rotation as usize] = on;
            return;
        }
        if let Some(state) = self.modal.transformations.get_mut(which as usize)
            && *state != on
        {
            *state = on;
            let [.., first, second] = self.position.axes;
            self.position.forget_axes();
            // G69 moves no axis.
            if plane.is_some() && on == Some(false) && which == Transformation::Tilt {
                self.position.axes[3..].copy_from_slice(&[first, second]);
            }
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
