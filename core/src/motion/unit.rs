//! In which unit a program counts: the text says so, or the caller does, or the program cannot be read.

use super::interpreter::{DWELL, Interpreter, at_bytes, bit};
use super::meaning::Meaning;
use crate::program::{Address, Batch, Block, DiagnosticCode, Diagnostics};
use crate::units::LengthUnit;

/// Who says in which unit the program counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum UnitFrom {
    /// The program itself, or a table, which counts in millimetres.
    Text,
    /// The caller.
    Caller,
    /// Nobody so far.
    Nobody,
    /// Nobody, and there was a length: the program is refused.
    Refused,
}

/// Words that are lengths: X Y Z, U V W, the centre of an arc and its radius.
const LENGTHS: u32 = bit(Address::X)
    | bit(Address::Y)
    | bit(Address::Z)
    | bit(Address::U)
    | bit(Address::V)
    | bit(Address::W)
    | bit(Address::I)
    | bit(Address::J)
    | bit(Address::K)
    | bit(Address::R);

impl Interpreter {
    /// The program states its unit.
    pub(super) fn set_unit(&mut self, mm_per_unit: f64) {
        if self.modal.mm_per_unit != Some(mm_per_unit) {
            self.modal.void_feed();
        }
        self.modal.mm_per_unit = Some(mm_per_unit);
        self.last_mm_per_unit = Some(mm_per_unit);
        let differs = self.options.unit.is_some_and(|unit| (unit.mm() - mm_per_unit).abs() > 0.0);
        if differs {
            self.unit_disagrees_at.get_or_insert(self.line);
        }
        if self.unit_from != UnitFrom::Refused {
            self.unit_from = UnitFrom::Text;
        }
    }

    /// Refuses the program where this block has a length and nobody has said what its unit is.
    pub(super) fn ask_for_unit(&mut self, batch: &Batch, block: &Block, diagnostics: &mut Diagnostics) {
        let lengths = self.block.present & LENGTHS;
        if lengths == 0 || self.needs_no_unit() {
            return;
        }
        let Some(word) = batch.words(block).iter().find(|word| lengths & bit(word.address) != 0) else {
            return;
        };
        let code = DiagnosticCode::UnitUnknown { address: word.address };
        diagnostics.push(at_bytes(batch, block, word.start, word.end, code));
        self.unit_from = UnitFrom::Refused;
        self.modal.mm_per_unit = Some(1.0);
        self.obstacle = self.modal.obstacle();
    }

    /// Whether the block states the unit itself; or dwells, where X is a time; or goes to a place of the machine by zeros
    /// (`G91 G28 Z0`), which are the same in every unit.
    fn needs_no_unit(&self) -> bool {
        let meanings = (0..self.block.g_codes().len()).map(|index| self.meaning(index));
        let is_free = |meaning: Meaning| match meaning {
            Meaning::Units(_) => true,
            Meaning::Reference | Meaning::MachineCoordinates => self.has_zeros_alone(),
            _ => false,
        };
        self.block.g_codes().contains(&DWELL) || meanings.into_iter().any(is_free)
    }

    fn has_zeros_alone(&self) -> bool {
        let lengths = self.block.present & LENGTHS;
        let is_zero = |index: usize| lengths & (1 << index) == 0 || self.block.values[index] == 0.0;
        lengths & self.block.unknown == 0 && (0..self.block.values.len()).all(is_zero)
    }

    /// The unit that the program counts in, or counted in before a call that may have changed it; `None` where nobody stated one.
    #[must_use]
    pub fn unit(&self) -> Option<LengthUnit> {
        let units = [LengthUnit::Millimetre, LengthUnit::Inch];
        let mm_per_unit = self.modal.mm_per_unit.or(self.last_mm_per_unit)?;
        units.into_iter().find(|unit| (unit.mm() - mm_per_unit).abs() <= 0.0)
    }

    /// Whether the program itself says in which unit it counts, or is a table, which counts in millimetres.
    #[must_use]
    pub fn states_unit(&self) -> bool {
        self.unit_from == UnitFrom::Text
    }

    /// First line where the text states another unit than the caller, who then does not count.
    #[must_use]
    pub fn unit_disagrees_at(&self) -> Option<u64> {
        self.unit_disagrees_at
    }
}
