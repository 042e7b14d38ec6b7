//! Zeros that programs of RS274/NGC controls write. G10 L2 and L20 state a work offset, which may be turned about Z. G92
//! shifts the words along its axes. G28.1 stores a reference position.
//!
//! On other controls G10 L2 is followed in G90, if the profile states what the control adds to the values of the
//! program.
//!
//! All of them are in the text, so the words after them keep their places. With the rotary axes at zero, the words `w`
//! are the place `origin + Rz(turn) · (shift + w)` in M. The source is `LinuxCNC`, `interp_convert.cc`.

use super::block_words::AXES;
use super::interpreter::Interpreter;
use super::meaning::Meaning;
use super::modal::{ToolLength, Transformation};
use super::work_offset::OffsetCode;
use super::written_zeros::Zero;
use super::{Interpolation, WorkOffset};
use crate::program::{Address, Code};

/// The work offsets by their P numbers, from 1 on.
const BY_NUMBER: [(u16, u8); 9] =
    [(54, 0), (55, 0), (56, 0), (57, 0), (58, 0), (59, 0), (59, 1), (59, 2), (59, 3)];
/// Tables of G10: work offsets by their origins and by the words of the present place, and tools.
const ORIGINS: u16 = 2;
const WORDS_HERE: u16 = 20;
const TOOLS: [u16; 3] = [1, 10, 11];
const LINEAR: [Address; 3] = [Address::X, Address::Y, Address::Z];
const ROTARY: [Address; 3] = [Address::A, Address::B, Address::C];
/// Words that a block of G10 or G92 may have.
const WORDS: u32 =
    AXES | Address::P.bit() | Address::L.bit() | Address::R.bit() | Address::N.bit() | Address::E.bit();
/// G92.
const SHIFT: Code = Code::G(920);

impl Interpreter {
    /// Whether the zeros that the program writes are followed. Words are places along the axes of the zero in force.
    fn follows_zeros(&self) -> bool {
        let rotation = self.modal.transformations.get(Transformation::Rotation as usize);
        self.external_mm().is_some()
            && self.options.as_it_runs
            && !self.zeros.is_lost
            && !self.modal.is_shifted()
            && rotation == Some(&Some(self.modal.turn.is_some()))
            && self.modal.obstacle_beside_turn().is_none()
    }

    /// What the control adds to the origins that the program writes \[mm\]; `None` if origins are not followed.
    fn external_mm(&self) -> Option<[f64; 3]> {
        let coordinates = self.machine_coordinates.as_ref()?;
        if self.is_rs274 {
            return Some([0.0; 3]);
        }
        coordinates.external_mm.filter(|_| self.rules.has_rs274_codes)
    }

    /// Whether words have other places by zeros that are followed.
    pub(super) fn has_own_zeros(&self) -> bool {
        self.follows_zeros() && self.zeros.has_written()
    }

    /// The zeros that the program has written are not known any more, and neither is the place for G28.
    pub(super) fn lose_zeros(&mut self) {
        if self.zeros.home.is_some() {
            self.zeros.home = Some(None);
        }
        if self.zeros.has_written() {
            self.shift_offsets();
        }
    }

    /// Words count from a zero that is not known, and are reported as they are written.
    pub(super) fn drop_zeros(&mut self) {
        if self.zeros.has_written() {
            self.zeros.is_lost = true;
            self.modal.program_offset_mm = Some([0.0; 3]);
            self.modal.turn = None;
            self.modal.transformations[Transformation::Rotation as usize] = Some(false);
        }
    }

    /// The name of a work offset among those that G10 writes.
    fn written_name(&self, offset: WorkOffset) -> WorkOffset {
        match offset {
            WorkOffset::Unnamed => self.rules.first_offset.unwrap_or(offset),
            named => named,
        }
    }

    /// The place of a work offset in M as it was stated \[mm\].
    fn stated_mm(&self, offset: WorkOffset) -> Option<[f64; 3]> {
        // Before the first point, the only offset of a request is the one in force.
        let may_be_only = self.only_offset.is_some()
            || [self.modal.work_offset, Some(WorkOffset::Unnamed)].contains(&Some(offset));
        self.options.work_offsets.of(offset, may_be_only && self.is_only_offset(offset))
    }

    fn zero_of(&self, offset: WorkOffset) -> Option<Zero> {
        let written = self.zeros.systems.get(&self.written_name(offset)).copied();
        let stated = || self.stated_mm(offset).map(|origin_mm| Zero { origin_mm, turn_deg: 0.0 });
        written.unwrap_or_else(stated)
    }

    fn linear_words(&self) -> [Option<f64>; 3] {
        let [x, y, z, ..] = self.position.axes;
        [x, y, z]
    }

    fn stand_at_words(&mut self, words_mm: [Option<f64>; 3]) {
        self.position.axes[..3].copy_from_slice(&words_mm);
        self.position.contact_mm = [None; 3];
    }

    /// Puts the zero of the offset in force into effect. Returns false if its place is not known.
    fn take_zero(&mut self) -> bool {
        let offset = self.modal.work_offset;
        let known = offset.and_then(|offset| Some((self.zero_of(offset)?, self.stated_mm(offset)?)));
        let Some((zero, stated_mm)) = known else { return false };
        let turn = zero.turn();
        let shift_mm = turn.map_or(self.zeros.shift_mm, |turn| turn.of(self.zeros.shift_mm));
        let offset_mm = std::array::from_fn(|k| zero.origin_mm[k] - stated_mm[k] + shift_mm[k]);
        self.modal.program_offset_mm = Some(offset_mm);
        self.modal.turn = turn;
        self.modal.transformations[Transformation::Rotation as usize] = Some(turn.is_some());
        true
    }

    /// Another work offset is in force: the axes stay, and their words change.
    pub(super) fn change_zero(&mut self, before: Option<WorkOffset>) {
        if self.modal.work_offset.is_none() || !self.follows_zeros() {
            return self.lose_zeros();
        }
        let found = before.zip(self.modal.work_offset).and_then(|(from, to)| {
            let is_where_it_was = self.has_motions() || self.stated_mm(from) == self.stated_mm(to);
            Some((self.zero_of(from)?, self.zero_of(to)?, is_where_it_was))
        });
        let Some((from, to, is_where_it_was)) = found else { return self.lose_zeros() };
        let words_mm = if is_where_it_was {
            let place_mm = from.place(self.zeros.shift_mm, self.linear_words());
            to.words(self.zeros.shift_mm, place_mm)
        } else {
            // In which of the two the axes stood at the start is not known.
            [None; 3]
        };
        self.stand_at_words(words_mm);
        if !self.take_zero() {
            self.lose_zeros();
        }
    }

    /// G10. Returns false if it is not followed.
    pub(super) fn write_zero(&mut self) -> bool {
        if !self.options.as_it_runs {
            return false;
        }
        match self.number_of(Address::L) {
            Some(ORIGINS) if self.is_rs274 || self.writes_origin_as_others() => self.write_origin().is_some(),
            _ if !self.is_rs274 => false,
            Some(WORDS_HERE) => self.write_words_here().is_some(),
            // It takes effect with the next G43.
            Some(table) if TOOLS.contains(&table) => {
                self.modal.writes_lengths = true;
                self.modal.writes_radii |= self.block.has(Address::R);
                true
            }
            _ => false,
        }
    }

    /// G10 L2 P1 to P6 in G90: origins of G54 to G59 on every control. In G91 some add the values. Under tool-centre-point
    /// control some turn the origin with the table.
    fn writes_origin_as_others(&self) -> bool {
        let is_incremental = |index| self.meaning(index) == Meaning::Incremental(true);
        self.modal.incremental == Some(false)
            && !(0..self.block.g_count).any(is_incremental)
            && self.modal.tool_length == Some(ToolLength::Plain)
            && self.options.interpolation != Some(Interpolation::Tcp)
            && !self.block.has(Address::R)
            && self.number_of(Address::P).is_some_and(|number| (1..=6).contains(&number))
    }

    /// The values of X Y Z in the block \[mm\]. `None` if a word is not known, or a rotary axis gets a zero of its own.
    fn zero_words(&self) -> Option<[Option<f64>; 3]> {
        let words = &self.block;
        let scale = self.modal.mm_per_unit?;
        let is_plain = words.present & !WORDS == 0
            && words.unknown & WORDS == 0
            && words.comma == 0
            && (words.absolute | words.incremental) & WORDS == 0;
        let turns = |address: Address| words.value(address).is_some_and(|value| value.abs() > 0.0);
        (is_plain && !ROTARY.into_iter().any(turns))
            .then(|| LINEAR.map(|address| words.value(address).map(|value| value * scale)))
    }

    /// The work offset that P names.
    fn numbered_offset(&self) -> Option<WorkOffset> {
        let number = usize::from(self.number_of(Address::P)?);
        let Some(index) = number.checked_sub(1) else { return self.modal.work_offset };
        let (whole, tenth) = BY_NUMBER.get(index)?;
        let named = WorkOffset::Code(OffsetCode::new(*whole, *tenth));
        let in_force = self.modal.work_offset?;
        Some(if self.written_name(in_force) == named { in_force } else { named })
    }

    /// G10 L2: the axes stay, and their words change.
    fn write_origin(&mut self) -> Option<()> {
        let values_mm = self.zero_words().filter(|_| self.follows_zeros())?;
        let offset = self.numbered_offset()?;
        let (zero_mm, external_mm) = (self.machine_coordinates.as_ref()?.zero_mm, self.external_mm()?);
        let before = self.zero_of(offset);
        let turn_deg = match before {
            _ if self.block.has(Address::R) => Some(self.block.value(Address::R)?),
            before => before.map(|before| before.turn_deg),
        };
        let [x, y, z] = std::array::from_fn(|k| match values_mm[k] {
            Some(value_mm) => Some(zero_mm[k] + external_mm[k] + value_mm),
            None => before.map(|before| before.origin_mm[k]),
        });
        let origin_mm = x.zip(y).zip(z).map(|((x, y), z)| [x, y, z]);
        self.zeros.has_height |= values_mm[2].is_some();
        let zero = origin_mm.zip(turn_deg).map(|(origin_mm, turn_deg)| Zero { origin_mm, turn_deg });
        self.set_zero(offset, before, zero)
    }

    /// G10 L20: the present place gets these words.
    fn write_words_here(&mut self) -> Option<()> {
        let values_mm = self.zero_words().filter(|_| self.follows_zeros() && !self.block.has(Address::R))?;
        let offset = self.numbered_offset().filter(|offset| Some(*offset) == self.modal.work_offset)?;
        let before = self.zero_of(offset)?;
        let is_shifted = self.zeros.shift_mm.iter().any(|shift_mm| shift_mm.abs() > 0.0);
        let words_mm = self.linear_words();
        let is_known = |k: usize| words_mm[k].is_some();
        let is_complete = if before.turn_deg.abs() > 0.0 {
            is_known(0) && is_known(1) && (is_known(2) || values_mm[2].is_none())
        } else {
            (0..3).all(|k| values_mm[k].is_none() || is_known(k))
        };
        if is_shifted || !is_complete {
            return None;
        }
        let place_mm = before.place([0.0; 3], words_mm);
        let new_mm: [Option<f64>; 3] = std::array::from_fn(|k| values_mm[k].or(words_mm[k]));
        let arm_mm = Zero { origin_mm: [0.0; 3], ..before }.place([0.0; 3], new_mm);
        let origin_mm = std::array::from_fn(|k| {
            place_mm[k].zip(arm_mm[k]).map_or(before.origin_mm[k], |(at_mm, arm_mm)| at_mm - arm_mm)
        });
        self.set_zero(offset, Some(before), Some(Zero { origin_mm, ..before }))
    }

    fn set_zero(&mut self, offset: WorkOffset, before: Option<Zero>, zero: Option<Zero>) -> Option<()> {
        self.zeros.systems.insert(self.written_name(offset), zero);
        if Some(offset) == self.modal.work_offset {
            let (before, zero) = before.zip(zero)?;
            let place_mm = before.place(self.zeros.shift_mm, self.linear_words());
            self.stand_at_words(zero.words(self.zeros.shift_mm, place_mm));
            self.take_zero().then_some(())?;
        }
        Some(())
    }

    /// G92 of an RS274/NGC control: the present place gets these words. Returns false if it is not followed.
    pub(super) fn write_shift(&mut self) -> bool {
        self.shift_words().is_some()
    }

    fn shift_words(&mut self) -> Option<()> {
        let is_alone = self.is_rs274
            && self.block.g_codes().iter().filter(|code| **code == SHIFT).count() == 1
            && (0..self.block.g_count)
                .all(|index| !matches!(self.meaning(index), Meaning::LocalShift | Meaning::OtherShift));
        let values_mm = self.zero_words().filter(|_| is_alone && self.follows_zeros())?;
        let has_rotary = self.block.present & ROTARY.into_iter().fold(0, |bits, axis| bits | axis.bit()) != 0;
        if has_rotary || self.block.present & AXES == 0 {
            return None;
        }
        let words_mm = self.linear_words();
        let mut shift_mm = self.zeros.shift_mm;
        for k in 0..3 {
            if let Some(value_mm) = values_mm[k] {
                shift_mm[k] += words_mm[k]? - value_mm;
            }
        }
        self.zeros.shift_mm = shift_mm;
        self.stand_at_words(std::array::from_fn(|k| values_mm[k].or(words_mm[k])));
        self.take_zero().then_some(())
    }

    /// G92.1 and G92.2: the shift ends, and the words count from the work offset again. Returns false if they are not
    /// followed.
    pub(super) fn end_shift(&mut self) -> bool {
        if !self.has_own_zeros() {
            return false;
        }
        let shift_mm = std::mem::take(&mut self.zeros.shift_mm);
        let words_mm = self.linear_words();
        self.stand_at_words(std::array::from_fn(|k| words_mm[k].map(|word_mm| word_mm + shift_mm[k])));
        self.take_zero()
    }
}
