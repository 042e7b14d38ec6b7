//! The beginning and the end of a statement of cutter location text, and its words.

use super::point::read_plain_point;
use super::statement::{self, TEXT};
use crate::program::dialect::LineRead;
use crate::program::dialect::line::{Line, REPEATABLE, Source, extent};
use crate::program::dialect::number::{Number, Spelling, fingerprint, number};
use crate::program::line::{is_blank, line_end, next_line};
use crate::program::{Address, Batch, BlockFlags, BlockKind, Keyword, WordForm};

/// Reads a statement and adds it to the batch; `None` if lines of the statement have not arrived yet.
pub(in crate::program) fn read_line(source: Source<'_>, batch: &mut Batch) -> Option<LineRead> {
    match read_plain_point(source, batch) {
        Some(next) => Some(LineRead::one(next)),
        None => read_any(source, batch),
    }
}

/// The same for every statement.
pub(super) fn read_any(source: Source<'_>, batch: &mut Batch) -> Option<LineRead> {
    let Source { text, start, is_last, .. } = source;
    let whole = extent(text, start, is_last, |line, _| Some(runs_on(line)))?;
    let matrix = matrix_end(text, start, is_last)?;
    let mut scan = Line::new(source, whole, REPEATABLE, batch);
    if scan.is_at_byte_order_mark() {
        scan.at += 3;
    }
    skip_blanks(&mut scan);
    let from = scan.at;
    let kind = if matrix > start {
        let rows = text.get(start..matrix).unwrap_or_default();
        scan.flags.set(BlockFlags::COMMENT);
        apart(&mut scan, Keyword::CoordinateSystem, start, rows)
    } else if is_blank(scan.slice(from, whole.body_end)) {
        scan.skip_all();
        BlockKind::Blank
    } else if scan.slice(from, from + 2) == b"$$" {
        scan.flags.set(BlockFlags::COMMENT);
        BlockKind::Comment
    } else if scan.byte(from) == b'%' {
        BlockKind::Percent
    } else {
        statement::read(&mut scan)
    };
    Some(scan.close(kind))
}

/// Whether the line ends in a single `$`. Text statements end with their line.
pub(super) fn runs_on(line: &[u8]) -> bool {
    let body = without_comment(line).trim_ascii();
    body.ends_with(b"$") && !TEXT.iter().any(|word| starts(body, word))
}

/// The line up to `$$`.
pub(super) fn without_comment(line: &[u8]) -> &[u8] {
    // Most lines have no dollar sign. A search for two of them costs more.
    let Some(first) = memchr::memchr(b'$', line) else { return line };
    let rest = line.get(first..).unwrap_or_default();
    let comment = rest.windows(2).position(|pair| pair == b"$$");
    comment.map_or(line, |at| line.get(..first + at).unwrap_or_default())
}

pub(super) fn starts(text: &[u8], word: &[u8]) -> bool {
    text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
}

/// Blanks, and the `$` and line ending between the lines of a statement.
pub(super) fn skip_blanks(scan: &mut Line<'_>) {
    while scan.at < scan.extent.body_end && matches!(scan.byte(scan.at), b' ' | b'\t' | b'$' | b'\r' | b'\n')
    {
        if scan.slice(scan.at, scan.at + 2) == b"$$" {
            scan.flags.set(BlockFlags::COMMENT);
            scan.at = line_end(scan.text, scan.at).min(scan.extent.body_end);
            continue;
        }
        scan.at += 1;
    }
}

/// One after the word at `from`.
pub(super) fn word_end(scan: &Line<'_>, from: usize) -> usize {
    let mut end = from;
    while scan.byte(end).is_ascii_alphanumeric() || matches!(scan.byte(end), b'_' | b'-' | b'.' | b'+') {
        end += 1;
    }
    end
}

pub(super) fn is_one_of(word: &[u8], words: &[&[u8]]) -> bool {
    words.iter().any(|known| word.eq_ignore_ascii_case(known))
}

/// A word in upper case, cut to the length of the known statements.
pub(super) struct Upper {
    bytes: [u8; 8],
    length: usize,
}

impl Upper {
    pub(super) fn of(word: &[u8]) -> Self {
        let mut upper = Self { bytes: [0; 8], length: 0 };
        if word.len() <= upper.bytes.len() {
            for (slot, byte) in upper.bytes.iter_mut().zip(word) {
                *slot = byte.to_ascii_uppercase();
            }
            upper.length = word.len();
        }
        upper
    }

    pub(super) fn as_bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

pub(super) fn said(scan: &mut Line<'_>, keyword: Keyword, start: usize) -> BlockKind {
    let end = scan.extent.body_end;
    scan.keyword(keyword, start, end);
    scan.skip_all();
    BlockKind::Words
}

/// The rest of the statement up to a comment.
pub(super) fn rest<'a>(scan: &Line<'a>, from: usize) -> &'a [u8] {
    without_comment(scan.slice(from, scan.extent.body_end))
}

pub(super) fn minors<'a>(scan: &Line<'a>, from: usize) -> impl Iterator<Item = &'a [u8]> + use<'a> {
    rest(scan, from)
        .split(|byte| matches!(byte, b',' | b'/' | b' ' | b'\t' | b'$' | b'\r' | b'\n'))
        .filter(|word| !word.is_empty())
}

pub(super) fn has_minor(scan: &Line<'_>, from: usize, wanted: &[u8]) -> bool {
    minors(scan, from).any(|word| word.eq_ignore_ascii_case(wanted))
}

/// Rows of the matrix in comments with which some systems state the machining axes: `$$ 1.0 0.0 0.0 25.0`.
pub(super) const MATRIX_ROWS: usize = 3;

/// One after the matrix in comments that starts at `start`; `start` itself if there is no matrix; `None` if this is
/// not known yet.
pub(super) fn matrix_end(text: &[u8], start: usize, last: bool) -> Option<usize> {
    let mut at = start;
    for _ in 0..MATRIX_ROWS {
        let end = line_end(text, at);
        if end >= text.len() && !last {
            return None;
        }
        if !is_matrix_row(text.get(at..end).unwrap_or_default()) {
            return Some(start);
        }
        at = next_line(text, end);
    }
    Some(at)
}

/// A comment with four numbers and nothing else.
pub(super) fn is_matrix_row(line: &[u8]) -> bool {
    let Some(rest) = line.trim_ascii_start().strip_prefix(b"$$") else { return false };
    let mut items = rest.split(u8::is_ascii_whitespace).filter(|item| !item.is_empty());
    let is_number =
        |item: &[u8]| number(item, 0, Spelling::Exponent).is_some_and(|number| number.end == item.len());
    (0..4).all(|_| items.next().is_some_and(is_number)) && items.next().is_none()
}

/// A statement whose P word distinguishes it from others of its kind. Equal texts have equal P words.
pub(super) fn told_apart(scan: &mut Line<'_>, keyword: Keyword, start: usize) -> BlockKind {
    let text = rest(scan, scan.at);
    apart(scan, keyword, start, text)
}

/// The same for a text in another place. Blanks do not count.
pub(super) fn apart(scan: &mut Line<'_>, keyword: Keyword, start: usize, text: &[u8]) -> BlockKind {
    let value = fingerprint(text.iter().copied().filter(|byte| !byte.is_ascii_whitespace() && *byte != b'$'));
    let end = scan.extent.body_end;
    scan.keyword(keyword, start, end);
    scan.number_word(Address::P, WordForm::Number, end, 0, Number::standing_for(value, end));
    scan.skip_all();
    BlockKind::Words
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::dialect::plain::tests::compare;

    #[test]
    fn plain_lines_are_read_as_in_the_general_way() {
        let plain = ["GOTO/1.5,-2.25,3", "GOTO/ 1, 2, 3, 0.1234567, .5, 1"];
        let pieces = "GOTO/|goto/|GOTO /|,|, | |GODLTA/|$$|$|E1|D2|FEDRAT/|RAPID|MMPM";
        compare(&plain, pieces, read_plain_point, read_any);
    }
}
