//! Work offsets: their names in programs, and where the caller says they are.

use std::collections::BTreeMap;
use std::fmt;

/// A work offset as a program names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum WorkOffset {
    /// The one in force where the program has named none so far.
    Unnamed,
    /// By its G code in tenths: `G54` is 540, `G59.1` is 591, `G505` is 5050.
    Code(u16),
    /// By a G code in tenths and a number: `G54.1 P3` (`G54 P3` is the same), `G154 P12`, `G15 H2`.
    Numbered(u16, u16),
    /// By the number of a preset of a conversational program (cycle 247).
    Preset(u16),
    /// By the digest of a coordinate system's statement in cutter location data (`CSYS/`).
    System(u32),
}

/// G54 and G54.1, which mean the same beside a P word.
const FIRST: u16 = 540;
const FIRST_NUMBERED: u16 = 541;
/// G15 of some controls, which names the offset by H.
const BY_H: u16 = 150;
/// How presets are named.
const PRESET: &str = "PRESET";

impl WorkOffset {
    /// The offset that a G code in tenths selects with a number beside it.
    #[must_use]
    pub const fn numbered(tenths: u16, number: u16) -> Self {
        Self::Numbered(if tenths == FIRST { FIRST_NUMBERED } else { tenths }, number)
    }

    /// The offset of a name as people write it: `G54`, `G54.1 P3`, `G54.1P3`, `G505`, `G15 H2`, `PRESET 4`. Letters may be small,
    /// blanks do not count. `None` for any other text.
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
        let tenths = tenths(code)?;
        match number.chars().next() {
            None if tenths == BY_H || !is_offset_code(tenths) => None,
            None => Some(Self::Code(tenths)),
            Some(letter) if (letter == 'H') == (tenths == BY_H) => {
                Some(Self::numbered(tenths, whole(number.get(1..)?)?))
            }
            Some(_) => None,
        }
    }
}

/// G54 to G59.9, G154 and G500 to G599.
fn is_offset_code(tenths: u16) -> bool {
    matches!(tenths, 540..=599 | 1540) || (matches!(tenths, 5000..=5990) && tenths.is_multiple_of(10))
}

/// A number of digits alone.
fn whole(text: &str) -> Option<u16> {
    if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) {
        return None;
    }
    text.parse().ok()
}

/// `54` and `54.1` in tenths.
fn tenths(text: &str) -> Option<u16> {
    let (whole_part, fraction) = text.split_once('.').unwrap_or((text, "0"));
    let fraction = whole(fraction).filter(|tenth| *tenth < 10)?;
    whole(whole_part)?.checked_mul(10)?.checked_add(fraction)
}

impl fmt::Display for WorkOffset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let code = |f: &mut fmt::Formatter<'_>, tenths: u16| match tenths % 10 {
            0 => write!(f, "G{}", tenths / 10),
            tenth => write!(f, "G{}.{tenth}", tenths / 10),
        };
        match *self {
            Self::Unnamed => f.write_str("the offset in force at the start"),
            Self::Code(tenths) => code(f, tenths),
            Self::Numbered(tenths, number) => {
                code(f, tenths)?;
                write!(f, " {}{number}", if tenths == BY_H { 'H' } else { 'P' })
            }
            Self::Preset(number) => write!(f, "{PRESET} {number}"),
            Self::System(_) => f.write_str("the coordinate system of CSYS/"),
        }
    }
}

/// Where the program's zero is on the machine, as far as the caller states it: the origin of W in M at zero pose \[mm\].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct WorkOffsets {
    /// The one of a program that names none or one. Where a program names several it is that of its first point.
    pub only_mm: Option<[f64; 3]>,
    /// By name, stated for this program: these win over all others.
    pub named_mm: BTreeMap<WorkOffset, [f64; 3]>,
    /// By name, stated for the machine: these come last.
    pub of_machine_mm: BTreeMap<WorkOffset, [f64; 3]>,
}

impl WorkOffsets {
    /// A program's only offset.
    #[must_use]
    pub fn only(offset_mm: [f64; 3]) -> Self {
        Self { only_mm: Some(offset_mm), ..Self::default() }
    }

    /// Where an offset is \[mm\]; `is_only` says that it is the one `only_mm` speaks of. `None` where nobody stated it.
    #[must_use]
    pub fn of(&self, offset: WorkOffset, is_only: bool) -> Option<[f64; 3]> {
        let named = self.named_mm.get(&offset).copied();
        named.or(self.only_mm.filter(|_| is_only)).or_else(|| self.of_machine_mm.get(&offset).copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_people_write_them_and_printed_in_one_form() {
        let names = [
            ("G54", Some(WorkOffset::Code(540)), "G54"),
            (" g59.1 ", Some(WorkOffset::Code(591)), "G59.1"),
            ("G54.1 P3", Some(WorkOffset::Numbered(541, 3)), "G54.1 P3"),
            ("g54p3", Some(WorkOffset::Numbered(541, 3)), "G54.1 P3"),
            ("G154P12", Some(WorkOffset::Numbered(1540, 12)), "G154 P12"),
            ("G505", Some(WorkOffset::Code(5050)), "G505"),
            ("G15 H2", Some(WorkOffset::Numbered(150, 2)), "G15 H2"),
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
        let (g54, g55) = (WorkOffset::Code(540), WorkOffset::Code(550));
        let offsets = WorkOffsets {
            only_mm: Some([1.0; 3]),
            named_mm: BTreeMap::from([(g55, [2.0; 3])]),
            of_machine_mm: BTreeMap::from([(g54, [3.0; 3]), (g55, [4.0; 3])]),
        };
        assert_eq!(offsets.of(g54, true), Some([1.0; 3]));
        assert_eq!(offsets.of(g54, false), Some([3.0; 3]));
        assert_eq!(offsets.of(g55, true), Some([2.0; 3]));
        assert_eq!(offsets.of(WorkOffset::Unnamed, true), Some([1.0; 3]));
        assert_eq!(offsets.of(WorkOffset::Code(560), false), None);
    }
}
