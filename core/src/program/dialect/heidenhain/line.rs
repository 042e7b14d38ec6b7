//! The beginning and the end of a statement of a conversational program, and its first words.

use super::statement;
use crate::program::dialect::LineRead;
use crate::program::dialect::line::{Line, REPEATABLE, Source, extent};
use crate::program::dialect::number::{Number, Spelling, number};
use crate::program::dialect::plain::{PlainLine, Shows};
use crate::program::line::{is_blank, line_end, next_line};
use crate::program::{Address, Batch, BlockFlags, BlockKind, Keyword, WordForm};

/// The most lines after a path in which a rounding or a chamfer is searched. Comments may be between them.
const MAX_LOOKAHEAD: usize = 32;

/// Reads a statement and adds it to the batch; `None` if lines of the statement have not arrived yet.
pub(in crate::program) fn read_line(source: Source<'_>, batch: &mut Batch) -> Option<LineRead> {
    match read_plain_line(source, batch) {
        Some(next) => Some(LineRead::one(next)),
        None => read_any(source, batch),
    }
}

/// Reads a line `12 L X+1.5 A-30 F1000` that another such line follows: then nothing changes the corner between them.
/// For any other line it returns `None` and leaves nothing in the batch.
fn read_plain_line(source: Source<'_>, batch: &mut Batch) -> Option<usize> {
    let mut line = PlainLine::begin(source, batch);
    let is_plain = plain_words(&mut line).is_some();
    line.end(is_plain, Shows::PointsZerosAndSigns)
}

#[expect(clippy::inline_always, reason = "the line stays in registers")]
#[inline(always)]
fn plain_words(line: &mut PlainLine<'_>) -> Option<()> {
    if line.byte()?.is_ascii_digit() {
        line.word(Address::N, 0)?;
        if line.has_point() {
            return None;
        }
    }
    line.skip_blanks();
    line.at = line_word_end(line.text, line.at)?;
    line.keyword(Keyword::L, 1);
    loop {
        match line.byte()? {
            b' ' | b'\t' => line.at += 1,
            b'\n' | b'\r' => return line_follows(line.text, next_line(line.text, line.at)),
            letter @ (b'X' | b'Y' | b'Z' | b'A' | b'B' | b'C' | b'F' | b'x' | b'y' | b'z') => {
                line.at += 1;
                line.word(Address::of_letter(letter), 1)?;
                // A decimal comma.
                if line.byte()? == b',' {
                    return None;
                }
            }
            _ => return None,
        }
    }
}

/// One after the statement word `L` at a byte, if blanks follow it.
#[inline]
fn line_word_end(text: &[u8], at: usize) -> Option<usize> {
    matches!(text.get(at..at + 2)?, [b'L' | b'l', b' ' | b'\t']).then_some(at + 1)
}

/// Whether the next line is `L` after a block number, blanks and no more.
#[inline]
fn line_follows(text: &[u8], start: usize) -> Option<()> {
    let rest = text.get(start..)?;
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let blanks = rest.iter().skip(digits).take_while(|byte| matches!(byte, b' ' | b'\t')).count();
    line_word_end(text, start + digits + blanks).map(|_| ())
}

/// The same for every statement.
fn read_any(source: Source<'_>, batch: &mut Batch) -> Option<LineRead> {
    let Source { text, start, is_last, .. } = source;
    let whole = extent(text, start, is_last, runs_on)?;
    let first = Opening::of(text.get(start..whole.body_end).unwrap_or_default());
    let corner = first.is_path() && corner_follows(text.get(whole.next..).unwrap_or_default(), is_last)?;
    let mut scan = Line::new(source, whole, REPEATABLE, batch);
    if first.is_deleted {
        scan.flags.set(BlockFlags::DELETE);
    }
    if let Some([from, to]) = first.number {
        block_number(&mut scan, start + from, start + to);
    }
    scan.at = start + first.statement;
    let from = scan.at;
    if corner {
        scan.keyword(Keyword::CornerFollows, from, from);
    }
    let kind = match scan.byte(from) {
        b'\n' | b'\r' if first.is_deleted => BlockKind::Words,
        b'\n' | b'\r' => BlockKind::Blank,
        byte if byte < b' ' && is_blank(scan.slice(from, whole.body_end)) => {
            scan.skip_all();
            BlockKind::Blank
        }
        // `* - …` structures the program for its reader.
        b';' | b'*' => {
            scan.flags.set(BlockFlags::COMMENT);
            scan.skip_all();
            BlockKind::Comment
        }
        b'%' => {
            scan.skip_all();
            BlockKind::Percent
        }
        _ => statement::read(&mut scan),
    };
    Some(scan.close(kind))
}

/// A block number with more digits than this is not read as a word.
const MAX_NUMBER_DIGITS: usize = 9;

fn block_number(scan: &mut Line<'_>, from: usize, to: usize) {
    let body = scan.text.get(..to).unwrap_or_default();
    if to - from <= MAX_NUMBER_DIGITS
        && let Some(number) = number(body, from, Spelling::Comma)
    {
        scan.number_word(Address::N, WordForm::Number, from, 0, number);
    }
}

/// The beginning of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Opening {
    is_deleted: bool,
    /// Start of the statement after mark, blanks and block number.
    statement: usize,
    /// The first two letters of the statement.
    letters: [u8; 2],
    /// The bytes of the block number.
    number: Option<[usize; 2]>,
}

impl Opening {
    fn of(line: &[u8]) -> Self {
        let blank = |at: usize| matches!(line.get(at), Some(b' ' | b'\t'));
        let mut at = if line.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 };
        let mut is_deleted = false;
        let mut number = None;
        loop {
            match line.get(at) {
                _ if blank(at) => at += 1,
                Some(b'/') => {
                    is_deleted = true;
                    at += 1;
                }
                Some(b'0'..=b'9') if number.is_none() => {
                    let from = at;
                    while line.get(at).is_some_and(u8::is_ascii_digit) {
                        at += 1;
                    }
                    number = Some([from, at]);
                }
                _ => break,
            }
        }
        let letter = |at: usize| line.get(at).map_or(b' ', u8::to_ascii_uppercase);
        Self { is_deleted, statement: at, letters: [letter(at), letter(at + 1)], number }
    }

    /// Whether the statement is a line, a circle or a straight line with vectors. Only their corners can be cut off.
    fn is_path(&self) -> bool {
        let [first, second] = self.letters;
        match first {
            b'L' => !matches!(second, b'B'),
            b'C' => !matches!(second, b'Y' | b'A' | b'H'),
            _ => false,
        }
    }
}

/// Elements that depend on the end and the direction of the path before them.
const CHANGE_THE_CORNER: [&[u8]; 7] = [b"RND", b"CHF", b"CT", b"CTP", b"DEP", b"FCT", b"FLT"];

/// Whether a rounding (RND) or a chamfer (CHF) cuts the corner between the text read so far and the next element. Also
/// true if the next element continues in the direction of this one (CT, CTP, DEP and free contours). `None` if this is
/// not known yet.
fn corner_follows(rest: &[u8], last: bool) -> Option<bool> {
    let mut at = 0;
    for _ in 0..MAX_LOOKAHEAD {
        if at >= rest.len() {
            break;
        }
        let end = line_end(rest, at);
        let line = rest.get(at..end).unwrap_or_default();
        let opening = Opening::of(line);
        match line.get(opening.statement) {
            None | Some(b';' | b'*') => at = next_line(rest, end),
            Some(0..b' ') if is_blank(line) => at = next_line(rest, end),
            Some(_) => {
                let word = line.get(opening.statement..).unwrap_or_default();
                let letters = word.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
                let word = word.get(..letters).unwrap_or_default();
                return Some(CHANGE_THE_CORNER.iter().any(|known| word.eq_ignore_ascii_case(known)));
            }
        }
    }
    if last || at < rest.len() { Some(false) } else { None }
}

/// Whether a statement continues after this line: with `~` at its end, in or before its comment, or with the
/// parameters of a cycle indented after it.
fn runs_on(line: &[u8], rest: &[u8]) -> Option<bool> {
    if line.trim_ascii_end().last() == Some(&b'~') {
        return Some(true);
    }
    if let Some(comment) = memchr::memchr(b';', line)
        && line.get(..comment).unwrap_or_default().trim_ascii_end().last() == Some(&b'~')
    {
        return Some(true);
    }
    if !has_parameters(line) {
        return Some(false);
    }
    if rest.is_empty() {
        return None;
    }
    let next = rest.get(..line_end(rest, 0)).unwrap_or_default();
    Some(
        next.first().is_some_and(|byte| matches!(byte, b' ' | b'\t'))
            && is_parameter(next.trim_ascii_start()),
    )
}

/// Whether lines of parameters can follow: after the head of a cycle, and after another line of parameters.
fn has_parameters(line: &[u8]) -> bool {
    let statement = line.get(Opening::of(line).statement..).unwrap_or_default();
    let starts =
        |word: &[u8]| statement.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
    starts(b"CYCL")
        || starts(b"TCH")
        || (line.first().is_some_and(|byte| matches!(byte, b' ' | b'\t')) && is_parameter(statement))
}

/// `Q339=…`
fn is_parameter(text: &[u8]) -> bool {
    let Some((b'Q' | b'q', rest)) = text.split_first() else { return false };
    let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
    digits > 0 && rest.get(digits..).unwrap_or_default().trim_ascii_start().first() == Some(&b'=')
}

/// A value after a letter: where the digits or the parameter begin, and the kind of the value.
pub(super) enum Value {
    Number(Number),
    /// `+Q12`, `-QL3`: one after its end.
    Parameter(usize),
    None,
}

/// Reads the value at `at`, blanks before it included.
pub(super) fn value(scan: &Line<'_>, at: usize) -> (usize, Value) {
    let mut from = at;
    while matches!(scan.byte(from), b' ' | b'\t') {
        from += 1;
    }
    let body = scan.text.get(..scan.extent.body_end).unwrap_or_default();
    if let Some(number) = number(body, from, Spelling::Comma) {
        return (from, Value::Number(number));
    }
    let name = from + usize::from(matches!(scan.byte(from), b'+' | b'-'));
    if !matches!(scan.byte(name), b'Q' | b'q') {
        return (from, Value::None);
    }
    let digits = name + 1 + usize::from(matches!(scan.byte(name + 1), b'L' | b'l' | b'R' | b'r'));
    let mut end = digits;
    while scan.byte(end).is_ascii_digit() {
        end += 1;
    }
    (from, if end > digits { Value::Parameter(end) } else { Value::None })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::dialect::plain::tests::compare;

    #[test]
    fn plain_lines_are_read_as_in_the_general_way() {
        let plain = ["12 L X+1.5 Y-2.25 F1000", "L X+1.12345678"];
        let pieces = "12 |L |l |LN |X|Y|z| A|IX|FMAX|F|R0|RL| M3|;note|~|*|Q1|,|/|7 L X+1 |C |N";
        compare(&plain, pieces, read_plain_line, read_any);
    }
}
