//! Lines that tell a survey nothing new, found without reading their words.

use super::survey::{CONTROL_DECIMALS, Survey};
use crate::program::{Address, Batch, Grammar};

/// Approximate length of a piece of text \[bytes\]. If one line has to be read, its whole piece is read.
const PIECE_BYTES: usize = 4096;
/// Text without an LF is handed over at this length, so that a reader can report its fault \[bytes\].
const MAX_UNBROKEN_BYTES: usize = 128 * 1024;

/// How a piece of text is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::process) struct Glance {
    has_letters: bool,
    rotary: [char; 2],
}

impl Glance {
    /// The glance for the text after this batch; `None` if that text has to be read. The dialect and everything
    /// before the program proper are known by then.
    pub(in crate::process) fn behind(batch: &Batch, rotary: [char; 2]) -> Option<Self> {
        let has_letters = match batch.dialect().rules().grammar {
            Grammar::Letters => true,
            // The columns that count apart from decimals are known. A decimal comma would look like a separator.
            Grammar::Cells
                if batch.separator() == b',' && !batch.columns().iter().copied().any(is_counted) =>
            {
                false
            }
            _ => return None,
        };
        Some(Self { has_letters, rotary })
    }

    /// Whether these whole lines cannot add to the survey: they have no block number, no U V W, and no number with
    /// more decimals than its class of axes has shown.
    pub(in crate::process) fn tells_nothing_new(self, lines: &[u8], survey: &Survey) -> bool {
        let coarse = survey.linear_decimals.min(survey.rotary_decimals);
        // A reader has to refuse lines that are longer than it accepts.
        lines.len() <= 2 * PIECE_BYTES
            && self.is_of_plain_bytes(lines)
            && (coarse >= CONTROL_DECIMALS
                || !has_fraction_longer_than(coarse, lines)
                || (self.has_letters && self.keeps_decimals(lines, survey, coarse)))
    }

    fn is_of_plain_bytes(self, lines: &[u8]) -> bool {
        let is_number = |byte: u8| (b'+'..=b'9').contains(&byte) | matches!(byte, b' ' | b'\n' | b'\r');
        let odd = if self.has_letters {
            // No N, no U V W, no O, which begins statements, and no T or M, which change tools.
            let is_letter = |byte: u8| {
                (b'A'..=b'L').contains(&byte) | (b'P'..=b'S').contains(&byte) | (b'X'..=b'Z').contains(&byte)
            };
            lines.iter().fold(false, |odd, &byte| odd | !(is_number(byte) | is_letter(byte)))
        } else {
            lines.iter().fold(false, |odd, &byte| odd | !is_number(byte))
        };
        !odd
    }

    /// Whether every long fraction belongs to an axis of a class that has shown as many decimals, or to no axis.
    fn keeps_decimals(self, lines: &[u8], survey: &Survey, coarse: u8) -> bool {
        memchr::memchr_iter(b'.', lines).all(|point| {
            let (before, behind) = lines.split_at(point);
            let digits = behind.iter().skip(1).take_while(|byte| byte.is_ascii_digit()).count();
            let decimals = u8::try_from(digits).unwrap_or(u8::MAX).min(CONTROL_DECIMALS);
            if decimals <= coarse {
                return true;
            }
            let address = before.iter().rev().find(|byte| byte.is_ascii_alphabetic());
            match address {
                Some(b'X'..=b'Z') => decimals <= survey.linear_decimals,
                Some(&letter) if self.rotary.contains(&char::from(letter)) => {
                    decimals <= survey.rotary_decimals
                }
                Some(_) => true,
                None => false,
            }
        })
    }
}

/// Whether a survey counts more of such a column than its decimals.
fn is_counted(column: Address) -> bool {
    matches!(column, Address::N | Address::U | Address::V | Address::W)
}

/// Number of bytes to look at next: whole lines, or at the end the rest. `None` if more text is needed.
pub(in crate::process) fn whole_lines(text: &[u8], ended: bool) -> Option<usize> {
    let head = text.get(..PIECE_BYTES).unwrap_or(text);
    if head.len() == text.len() && !ended {
        return None;
    }
    memchr::memrchr(b'\n', head)
        .or_else(|| memchr::memchr(b'\n', text))
        .map(|at| at + 1)
        .or_else(|| (!text.is_empty() && (ended || text.len() > MAX_UNBROKEN_BYTES)).then_some(text.len()))
}

/// Number of lines in this text of whole lines. A CR without an LF ends a line too.
pub(in crate::process) fn line_count(lines: &[u8]) -> u64 {
    let ends = memchr::memchr2_iter(b'\n', b'\r', lines);
    ends.filter(|&at| lines[at] == b'\n' || lines.get(at + 1) != Some(&b'\n')).count() as u64
}

/// Whether a number in the text has more than `decimals` digits after its point.
fn has_fraction_longer_than(decimals: u8, text: &[u8]) -> bool {
    match decimals {
        0 => has_fraction::<2>(text),
        1 => has_fraction::<3>(text),
        2 => has_fraction::<4>(text),
        3 => has_fraction::<5>(text),
        4 => has_fraction::<6>(text),
        _ => has_fraction::<7>(text),
    }
}

/// A point and `N` − 1 digits. It looks at every position, so that many are compared side by side.
fn has_fraction<const N: usize>(text: &[u8]) -> bool {
    text.windows(N).fold(false, |found, window| {
        let is_fraction = window
            .iter()
            .skip(1)
            .fold(window.first() == Some(&b'.'), |all, byte| all & byte.is_ascii_digit());
        found | is_fraction
    })
}

#[cfg(test)]
mod tests {
    use super::super::numbering::Numbering;
    use super::*;
    use crate::program::{Dialect, ReadLimits, Reader};

    const ROTARY: [char; 2] = ['A', 'C'];

    fn survey(linear_decimals: u8, rotary_decimals: u8) -> Survey {
        let numbering = Numbering::default();
        let mut survey = Survey { linear_decimals, rotary_decimals, numbering, ..Survey::nothing() };
        survey.tools.pass_over();
        survey
    }

    /// The survey after these lines were read, after a head that adds nothing to it.
    fn read(head: &str, lines: &str, dialect: Dialect, before: Survey) -> (Survey, Option<Glance>) {
        let mut reader = Reader::new(Some(dialect), ReadLimits::default());
        let mut batch = Batch::new();
        reader.feed(format!("{head}{lines}").as_bytes());
        reader.finish();
        assert!(reader.next_batch(&mut batch).unwrap());
        let mut survey = before;
        survey.see(&batch, ROTARY);
        (survey, Glance::behind(&batch, ROTARY))
    }

    #[test]
    fn what_is_passed_over_would_have_told_nothing() {
        let lines = [
            ("X1.234 Y-2.5 A.5 C12.125", true),
            ("X1.2345 A1.5", true),
            ("X1. A1.2345", false),
            ("X1.23456", false),
            ("X 1.2345 G1 F100.123456", true),
            ("F100.5 X1.2345 C12.3\r", true),
            ("B1.2345678", true),
            ("N10 X1", false),
            ("X1 U1 V2 W3", false),
            ("x1.2345678", false),
            ("X1 (1.2345678)", false),
            ("X1.2.3456 Y1.12345", false),
            ("/X1.5 G90", true),
            ("X#1", false),
            ("", true),
            (".5 X1", true),
            ("O7", false),
            ("T5", false),
            ("M6", false),
        ];
        for (line, expected) in lines {
            for known in [survey(4, 3), survey(0, 0), survey(2, 6), survey(6, 6)] {
                let lines = format!("{line}\n");
                let (after, glance) = read("", &lines, Dialect::Iso, known);
                let is_old = glance.unwrap().tells_nothing_new(lines.as_bytes(), &known);
                assert!(!is_old || after == known, "{line}");
                assert!(is_old == expected || known != survey(4, 3), "{line}");
            }
        }
    }

    #[test]
    fn of_a_table_only_decimals_count() {
        for (lines, expected) in [("1.234,2,3,4.1,5\n", true), ("1.2345,2,3,4,5\n", false), ("a,2\n", false)]
        {
            let (after, glance) = read("X,Y,Z,A,C\n", lines, Dialect::Csv, survey(3, 3));
            assert_eq!(
                glance.unwrap().tells_nothing_new(lines.as_bytes(), &survey(3, 3)),
                expected,
                "{lines}"
            );
            assert!(!expected || after.linear_decimals == 3);
        }
        let (_, glance) = read("X,Y,Z,A,C,U,V,W\n", "1,2,3,4,5,6,7,8\n", Dialect::Csv, survey(3, 3));
        assert_eq!(glance, None);
    }

    #[test]
    fn lines_are_taken_whole() {
        assert_eq!(whole_lines(b"X1\nX2", false), None);
        assert_eq!(whole_lines(b"X1\nX2", true), Some(3));
        assert_eq!(whole_lines(b"X2", true), Some(2));
        assert_eq!(whole_lines(b"", true), None);
        let long = [vec![b'X'; PIECE_BYTES + 7], b"\nX1\n".to_vec()].concat();
        assert_eq!(whole_lines(&long, false), Some(PIECE_BYTES + 8));
        assert_eq!(whole_lines(&vec![b'\r'; MAX_UNBROKEN_BYTES + 1], false), Some(MAX_UNBROKEN_BYTES + 1));
    }
}
