//! The marks of an OSP program, and its parts that are not read.

use crate::program::ForeignDialect;
use crate::program::dialect::detect::{ends_word, starts, without_number};

/// Kinds of program files.
const FILES: [&[u8]; 7] = [b".MIN", b".SSB", b".SDF", b".TOP", b".LIB", b".SUB", b".MSB"];
/// System variables with a subscript: zero offsets, tool offsets, inputs, gauges.
const TABLES: [&[u8]; 6] = [b"VZOF", b"VZSH", b"VTOF", b"VTLN", b"VGRIN", b"VSIO"];

/// `$FLANGE.MIN%`: the name of the file in which a program was kept.
pub(super) fn is_program_file(line: &[u8]) -> bool {
    let Some(name) = line.strip_prefix(b"$") else { return false };
    let name = name.strip_suffix(b"%").unwrap_or(name);
    FILES.iter().any(|kind| {
        name.len() > kind.len() && name.get(name.len() - kind.len()..).is_some_and(|end| end == *kind)
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

/// Whether two lines together show that a text is an OSP program, if no line alone does. One line has `G15 H` or
/// `G16 H`, which select a work coordinate system in OSP. The other has `G56` and H, which is a tool length in OSP and
/// a work offset without H everywhere else.
pub(in crate::program::dialect) fn has_marks<'a>(lines: impl Iterator<Item = &'a [u8]>) -> bool {
    let (mut selects, mut has_length) = (false, false);
    for line in lines {
        let codes = Codes::of(line);
        selects |= codes.has_h && (codes.has(15) || codes.has(16));
        has_length |= codes.has_h && codes.has(56);
    }
    selects && has_length
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
    fn a_work_offset_by_h_and_a_length_by_g56_show_a_program_together_and_not_alone() {
        let shown = |text: &str| has_marks(text.as_bytes().split(|byte| *byte == b'\n'));
        assert!(shown("O1\nN10 G15 H1\nT1 M6\nG0 X1. Y2.\nG56 Z5. H01\n"));
        assert!(shown("G90G0G16H0Z100.\r\nG56H3Z5\r\n"));
        for text in [
            "G15 H1\nG0 X1\n",
            "O0001 (PROGRAM)\nN0100 G56 Z4.3307 H01\n",
            "G15\nG56 Z5. H1\n",
            "(G15 H1)\nG56 Z5. H1\n",
            "G15 H1\nG56 X1 (H1)\n",
            "G15.1 H1\nG56.1 H1\n",
            "G15 H#1\nG56 Z5 H1\n",
        ] {
            assert!(!shown(text), "{text}");
        }
    }

    #[test]
    fn files_are_told_by_their_kind() {
        for (line, expected) in [
            ("$FLANGE.MIN%", true),
            ("$A.SSB", true),
            ("$.MIN%", false),
            ("$100", false),
            ("FLANGE.MIN%", false),
        ] {
            assert_eq!(is_program_file(line.as_bytes()), expected, "{line}");
        }
    }
}
