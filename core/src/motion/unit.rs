//! The unit in which a program counts. The text or the caller states it; otherwise the program is refused.

use super::block_words::DWELL;
use super::interpreter::{Interpreter, at_bytes};
use super::meaning::Meaning;
use crate::program::{Address, Batch, Block, DiagnosticCode, Diagnostics};
use crate::units::LengthUnit;

/// The source of the program's unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum UnitFrom {
    /// The program itself, or a table, which counts in millimetres.
    Text,
    /// The caller.
    Caller,
    /// No source so far.
    Nobody,
    /// There was a length without a known unit: the program is refused.
    Refused,
}

/// The unit of a program so far, besides the modal unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ProgramUnit {
    from: UnitFrom,
    /// The last unit that held, also after a call that may have changed it.
    last_mm_per_unit: Option<f64>,
    /// First line where the text states another unit than the caller.
    disagrees_at: Option<u64>,
}

impl ProgramUnit {
    /// Whether the unit of the program is not known so far and no length has been met.
    #[inline]
    pub(super) fn is_unknown(&self) -> bool {
        self.from == UnitFrom::Nobody
    }
}

impl Default for ProgramUnit {
    fn default() -> Self {
        Self { from: UnitFrom::Nobody, last_mm_per_unit: None, disagrees_at: None }
    }
}

/// Words that are lengths: X Y Z, U V W, the centre of an arc and its radius.
const LENGTHS: u32 = Address::X.bit()
    | Address::Y.bit()
    | Address::Z.bit()
    | Address::U.bit()
    | Address::V.bit()
    | Address::W.bit()
    | Address::I.bit()
    | Address::J.bit()
    | Address::K.bit()
    | Address::R.bit();

impl Interpreter {
    /// The dialect is now known. Sets the unit in which its programs count before they state one.
    pub(super) fn begin_unit(&mut self) {
        let (unit, from) = match self.options.unit {
            _ if self.rules.counts_in_mm => (Some(LengthUnit::Millimetre), UnitFrom::Text),
            Some(unit) => (Some(unit), UnitFrom::Caller),
            None => (None, UnitFrom::Nobody),
        };
        self.modal.mm_per_unit = unit.map(LengthUnit::mm);
        self.program_unit.from = from;
        self.program_unit.last_mm_per_unit = self.modal.mm_per_unit;
    }

    /// The text states two units at once, so the program is refused.
    pub(super) fn lose_unit(&mut self) {
        self.modal.void_feed();
        self.modal.mm_per_unit = None;
        self.program_unit.from = UnitFrom::Refused;
    }

    /// The program states its unit.
    pub(super) fn set_unit(&mut self, mm_per_unit: f64) {
        if self.modal.mm_per_unit != Some(mm_per_unit) {
            self.modal.void_feed();
        }
        self.modal.mm_per_unit = Some(mm_per_unit);
        self.program_unit.last_mm_per_unit = Some(mm_per_unit);
        let differs = self.options.unit.is_some_and(|unit| (unit.mm() - mm_per_unit).abs() > 0.0);
        if differs {
            self.program_unit.disagrees_at.get_or_insert(self.line);
        }
        if self.program_unit.from != UnitFrom::Refused {
            self.program_unit.from = UnitFrom::Text;
        }
    }

    /// Refuses the program if this block has a length and no unit has been stated.
    pub(super) fn ask_for_unit(&mut self, batch: &Batch, block: &Block, diagnostics: &mut Diagnostics) {
        let lengths = self.block.present & LENGTHS;
        if lengths == 0 || self.needs_no_unit() {
            return;
        }
        let Some(word) = batch.words(block).iter().find(|word| lengths & word.address.bit() != 0) else {
            return;
        };
        let code = DiagnosticCode::UnitUnknown { address: word.address };
        diagnostics.push(at_bytes(batch, block, word.start, word.end, code));
        self.program_unit.from = UnitFrom::Refused;
        self.modal.mm_per_unit = Some(1.0);
        self.find_obstacle();
    }

    /// Whether the block needs no stated unit. It states the unit itself, or it dwells, where X is a time. Or it goes
    /// to a place of the machine by zeros (`G91 G28 Z0`), which are the same in every unit.
    fn needs_no_unit(&self) -> bool {
        let meanings = (0..self.block.g_codes().len()).map(|index| self.meaning(index));
        let is_free = |meaning: Meaning| match meaning {
            Meaning::Units(_) => true,
            Meaning::Reference | Meaning::MachineCoordinates | Meaning::NearMachineZero => {
                self.has_zeros_alone()
            }
            _ => false,
        };
        self.block.g_codes().contains(&DWELL) || meanings.into_iter().any(is_free)
    }

    fn has_zeros_alone(&self) -> bool {
        let lengths = self.block.present & LENGTHS;
        let is_zero = |index: usize| lengths & (1 << index) == 0 || self.block.values[index] == 0.0;
        lengths & self.block.unknown == 0 && (0..self.block.values.len()).all(is_zero)
    }

    /// The unit in which the program counts, or counted before a call that may have changed it; `None` if no unit was
    /// stated.
    #[must_use]
    pub fn unit(&self) -> Option<LengthUnit> {
        let units = [LengthUnit::Millimetre, LengthUnit::Inch];
        let mm_per_unit = self.modal.mm_per_unit.or(self.program_unit.last_mm_per_unit)?;
        units.into_iter().find(|unit| (unit.mm() - mm_per_unit).abs() <= 0.0)
    }

    /// Whether the program itself states its unit, or is a table, which counts in millimetres.
    #[must_use]
    pub fn states_unit(&self) -> bool {
        self.program_unit.from == UnitFrom::Text
    }

    /// First line in which the text states another unit than the caller. The caller's unit is not used then.
    #[must_use]
    pub fn unit_disagrees_at(&self) -> Option<u64> {
        self.program_unit.disagrees_at
    }
}
