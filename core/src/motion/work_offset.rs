//! Work offsets: their names in programs, and their positions as the caller states them.

use std::collections::BTreeMap;
use std::fmt;

/// The number of a G code that names a work offset, with its decimal: `G54`, `G59.1`, `G505`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct OffsetCode {
    whole: u16,
    tenth: u8,
}

impl OffsetCode {
    /// G54.
    const FIRST: Self = Self::new(54, 0);
    /// G54.1. With a P word it means the same as G54.
    const FIRST_NUMBERED: Self = Self::new(54, 1);
    /// G15 of some controls. It names the offset by H.
    const BY_H: Self = Self::new(15, 0);

    /// `G54.1` by 54 and 1.
    #[must_use]
    pub const fn new(whole: u16, tenth: u8) -> Self {
        Self { whole, tenth }
    }

    /// A code in tenths. Codes of tables are far below 6553.
    pub(super) const fn of_tenths(tenths: u32) -> Self {
        #[expect(clippy::cast_possible_truncation, reason = "codes of tables are small")]
        let (whole, tenth) = ((tenths / 10) as u16, (tenths % 10) as u8);
        Self { whole, tenth }
    }

    /// `54` and `54.1`; `None` for other texts and numbers larger than [`MAX_CODE`].
    fn from_digits(text: &str) -> Option<Self> {
        let (whole_part, fraction) = text.split_once('.').unwrap_or((text, "0"));
        let tenth = u8::try_from(whole(fraction)?).ok().filter(|tenth| *tenth < 10)?;
        let whole = whole(whole_part).filter(|whole| *whole <= MAX_CODE)?;
        Some(Self { whole, tenth })
    }

    /// G54 to G59.9, G154 and G500 to G599.
    const fn names_an_offset(self) -> bool {
        matches!((self.whole, self.tenth), (54..=59, _) | (154 | 500..=599, 0))
    }
}

impl fmt::Display for OffsetCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.tenth {
            0 => write!(f, "G{}", self.whole),
            tenth => write!(f, "G{}.{tenth}", self.whole),
        }
    }
}

/// A work offset as a program names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WorkOffset {
    /// The offset in force while the program has named none.
    Unnamed,
    /// By its G code: `G54`, `G59.1`, `G505`.
    Code(OffsetCode),
    /// By a G code and a number: `G54.1 P3` (`G54 P3` is the same), `G154 P12`, `G15 H2`.
    Numbered(OffsetCode, u16),
    /// By the number of a preset of a conversational program (cycle 247).
    Preset(u16),
    /// By the digest of a coordinate system's statement in cutter location data (`CSYS/`).
    System(u32),
}

/// The largest number of a code in a name.
const MAX_CODE: u16 = 6553;
/// The name of presets.
const PRESET: &str = "PRESET";

impl WorkOffset {
    /// G54.
    pub const G54: Self = Self::Code(OffsetCode::FIRST);

    /// The offset that a G code selects together with a number.
    #[must_use]
    pub fn numbered(code: OffsetCode, number: u16) -> Self {
        Self::Numbered(if code == OffsetCode::FIRST { OffsetCode::FIRST_NUMBERED } else { code }, number)
    }

    /// `G15 H2`.
    #[must_use]
    pub const fn by_h(number: u16) -> Self {
        Self::Numbered(OffsetCode::BY_H, number)
    }

    /// The offset of a name as people write it: `G54`, `G54.1 P3`, `G54.1P3`, `G505`, `G15 H2`, `PRESET 4`. Letters
    /// may be lower case, and blanks do not matter. `None` for any other text.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        let text: String =
            name.chars().filter(|c| !c.is_ascii_whitespace()).map(|c| c.to_ascii_uppercase()).collect();
        if let Some(number) = text.strip_prefix(PRESET) {
            return Some(Self::Preset(whole(number)?));
        }
        let code = text.strip_prefix('G')?;
        let split = code.find(['P', 'H']).unwrap_or(code.len());
        let (code, number) = code.split_at(split);
        let code = OffsetCode::from_digits(code)?;
        match number.chars().next() {
            None => code.names_an_offset().then_some(Self::Code(code)),
            Some(letter) if (letter == 'H') == (code == OffsetCode::BY_H) => {
                Some(Self::numbered(code, whole(number.get(1..)?)?))
            }
            Some(_) => None,
        }
    }
}

/// A number that consists only of digits.
fn whole(text: &str) -> Option<u16> {
    if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    text.parse().ok()
}

impl fmt::Display for WorkOffset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Unnamed => f.write_str("the offset in force at the start"),
            Self::Code(code) => code.fmt(f),
            Self::Numbered(code, number) => {
                write!(f, "{code} {}{number}", if code == OffsetCode::BY_H { 'H' } else { 'P' })
            }
            Self::Preset(number) => write!(f, "{PRESET} {number}"),
            Self::System(_) => f.write_str("the coordinate system of CSYS/"),
        }
    }
}

/// The position of the program's zero on the machine, as far as the caller states it: the origin of W in M at zero
/// pose \[mm\].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WorkOffsets {
    /// The offset of a program that names no offset or one offset. If a program names several, this is the offset of
    /// its first point.
    pub only_mm: Option<[f64; 3]>,
    /// Offsets by name, stated for this program. They have priority over all others.
    pub named_mm: BTreeMap<WorkOffset, [f64; 3]>,
    /// Offsets by name, stated for the machine. They are used last.
    pub of_machine_mm: BTreeMap<WorkOffset, [f64; 3]>,
}

impl WorkOffsets {
    /// A program's only offset.
    #[must_use]
    pub fn only(offset_mm: [f64; 3]) -> Self {
        Self { only_mm: Some(offset_mm), ..Self::default() }
    }

    /// The position of an offset \[mm\]; `None` if it was not stated. `is_only` says that it is the offset that
    /// `only_mm` means.
    #[must_use]
    pub fn of(&self, offset: WorkOffset, is_only: bool) -> Option<[f64; 3]> {
        let named = self.named_mm.get(&offset).copied();
        named.or(self.only_mm.filter(|_| is_only)).or_else(|| self.of_machine_mm.get(&offset).copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn g(whole: u16, tenth: u8) -> OffsetCode {
        OffsetCode::new(whole, tenth)
    }

    #[test]
    fn names_are_read_as_people_write_them_and_printed_in_one_form() {
        let names = [
            ("G54", Some(WorkOffset::G54), "G54"),
            (" g59.1 ", Some(WorkOffset::Code(g(59, 1))), "G59.1"),
            ("G54.1 P3", Some(WorkOffset::Numbered(g(54, 1), 3)), "G54.1 P3"),
            ("g54p3", Some(WorkOffset::Numbered(g(54, 1), 3)), "G54.1 P3"),
            ("G154P12", Some(WorkOffset::Numbered(g(154, 0), 12)), "G154 P12"),
            ("G505", Some(WorkOffset::Code(g(505, 0))), "G505"),
            ("G15 H2", Some(WorkOffset::by_h(2)), "G15 H2"),
            ("preset 4", Some(WorkOffset::Preset(4)), "PRESET 4"),
        ];
        for (name, expected, printed) in names {
            assert_eq!(WorkOffset::from_name(name), expected, "{name}");
            assert_eq!(WorkOffset::from_name(printed), expected, "{printed}");
            assert_eq!(expected.map(|offset| offset.to_string()).as_deref(), Some(printed));
        }
        for name in [
            "", "G", "54", "G1", "G53", "G54 H1", "G15 P1", "G15", "G54.12", "G54.1 P", "G54 P-1", "X1",
            "G99999",
        ] {
            assert_eq!(WorkOffset::from_name(name), None, "{name}");
        }
    }

    #[test]
    fn what_is_stated_for_the_program_wins_over_what_is_stated_for_the_machine() {
        let (g54, g55) = (WorkOffset::G54, WorkOffset::Code(g(55, 0)));
        let offsets = WorkOffsets {
            only_mm: Some([1.0; 3]),
            named_mm: BTreeMap::from([(g55, [2.0; 3])]),
            of_machine_mm: BTreeMap::from([(g54, [3.0; 3]), (g55, [4.0; 3])]),
        };
        assert_eq!(offsets.of(g54, true), Some([1.0; 3]));
        assert_eq!(offsets.of(g54, false), Some([3.0; 3]));
        assert_eq!(offsets.of(g55, true), Some([2.0; 3]));
        assert_eq!(offsets.of(WorkOffset::Unnamed, true), Some([1.0; 3]));
        assert_eq!(offsets.of(WorkOffset::Code(g(56, 0)), false), None);
    }
}
