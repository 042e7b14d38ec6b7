//! The marks of an OSP program, and its parts that are not read.

use crate::program::ForeignDialect;
use crate::program::dialect::detect::{ends_word, starts, without_number};

/// Kinds of program files.
const FILES: [&[u8]; 7] = [b".MIN", b".SSB", b".SDF", b".TOP", b".LIB", b".SUB", b".MSB"];
/// System variables with a subscript: zero offsets, tool offsets, inputs, gauges.
const TABLES: [&[u8]; 6] = [b"VZOF", b"VZSH", b"VTOF", b"VTLN", b"VGRIN", b"VSIO"];

/// `$FLANGE.MIN%`: the name of the file in which a program was kept.
pub(super) fn is_program_file(line: &[u8]) -> bool {
    let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
    let Some(name) = line.strip_prefix(b"$") else { return false };
    let name = name.strip_suffix(b"%").unwrap_or(name);
    FILES.iter().any(|kind| {
        name.len() > kind.len()
            && name.get(name.len() - kind.len()..).is_some_and(|end| end.eq_ignore_ascii_case(kind))
    })
}

/// `VC1=5`, `VZOFZ[1]=…`, `NOEX VC2=VC1`: a line with variables. Variables are not read.
pub(in crate::program::dialect) fn unread_statement(line: &[u8]) -> Option<ForeignDialect> {
    has_variables(without_number(line)).then_some(ForeignDialect::Okuma)
}

fn has_variables(statement: &[u8]) -> bool {
    if starts(statement, b"NOEX") && ends_word(statement, 4) {
        return true;
    }
    let digits = |text: &[u8]| text.iter().take_while(|byte| byte.is_ascii_digit()).count();
    if let Some(number) = statement.strip_prefix(b"VC") {
        let count = digits(number);
        return count > 0 && number.get(count..).unwrap_or_default().trim_ascii_start().starts_with(b"=");
    }
    TABLES.iter().any(|name| {
        starts(statement, name)
            && memchr::memchr2(b'[', b' ', statement).is_some_and(|at| statement.get(at) == Some(&b'['))
    })
}

/// Whether a line has `G15 H` or `G16 H`, which select a work coordinate system in OSP. Elsewhere G15 and G16 switch
/// polar words, and H beside them belongs to a length of the same line: G43, G44 or G49.
pub(in crate::program::dialect) fn selects_offset(line: &[u8]) -> bool {
    let codes = Codes::of(line);
    let has_length = [43, 44, 49].into_iter().any(|code| codes.has(code));
    codes.has_h && !has_length && (codes.has(15) || codes.has(16))
}

/// The codes in a line of letters and whole numbers.
#[derive(Debug, Clone, Copy)]
struct Codes {
    /// The G codes below 64, as bits.
    codes: u64,
    has_h: bool,
}

impl Codes {
    /// The codes of a line up to its first comment; no codes if anything but letters and numbers comes before it.
    fn of(line: &[u8]) -> Self {
        let mut found = Self { codes: 0, has_h: false };
        let end = memchr::memchr2(b'(', b';', line).unwrap_or(line.len());
        let line = line.get(..end).unwrap_or_default();
        let is_plain = |byte: &u8| byte.is_ascii_alphanumeric() || b" \t+-./\r".contains(byte);
        if !line.iter().all(is_plain) {
            return found;
        }
        for (at, letter) in line.iter().enumerate().filter(|(_, byte)| byte.is_ascii_alphabetic()) {
            let rest = line.get(at + 1..).unwrap_or_default();
            let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
            let ends = rest.get(digits).is_none_or(|byte| *byte != b'.');
            let number = std::str::from_utf8(rest.get(..digits).unwrap_or_default()).ok();
            let Some(number) = number.and_then(|number| number.parse::<u32>().ok()).filter(|_| ends) else {
                continue;
            };
            match letter.to_ascii_uppercase() {
                b'G' if number < u64::BITS => found.codes |= 1 << number,
                b'H' => found.has_h = true,
                _ => {}
            }
        }
        found
    }

    const fn has(self, code: u32) -> bool {
        self.codes & (1 << code) != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_work_offset_by_h_shows_a_program_and_the_number_of_a_length_does_not() {
        for line in ["G15 H1", "N10 G15 H1", "G90G0G16H0Z100.\r", "G15 H02 (G43)"] {
            assert!(selects_offset(line.as_bytes()), "{line}");
        }
        for line in [
            "N0100 G56 Z4.3307 H01",
            "G15",
            "(G15 H1)",
            "G15 (H1)",
            "G15.1 H1",
            "G15 H#1",
            "G17 G15 G43 H1",
            "G44 G16 H2",
            "G49 G15 H0",
        ] {
            assert!(!selects_offset(line.as_bytes()), "{line}");
        }
    }

    #[test]
    fn files_are_told_by_their_kind() {
        for (line, expected) in [
            ("$FLANGE.MIN%", true),
            ("$flange.min%", true),
            ("\u{feff}$FLANGE.MIN%", true),
            ("$A.SSB", true),
            ("$.MIN%", false),
            ("$100", false),
            ("FLANGE.MIN%", false),
        ] {
            assert_eq!(is_program_file(line.as_bytes()), expected, "{line}");
        }
    }
}
