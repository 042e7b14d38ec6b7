//! Turns one line of ISO G-code into words. The plain case is one loop over letters, blanks and numbers; everything
//! else is in `statement`.

use super::statement;
use crate::program::comment::comment_end;
use crate::program::dialect::LineRead;
use crate::program::dialect::line::{Extent, Line, REPEATABLE, Source};
use crate::program::dialect::plain::{PlainLine, Shows};
use crate::program::line::line_end;
use crate::program::number::{MAX_MAGNITUDE, exponent_at, follows_number, number_start, read_unsigned};
use crate::program::{Address, Batch, BlockFlags, BlockKind, DiagnosticCode};

const SPECIAL: u8 = 0;
const LETTER: u8 = 1;
const BLANK: u8 = 2;
const LINE_END: u8 = 3;

/// The kind of text that a byte can begin. O begins words and statements, so it is special. Control bytes are blanks.
const CLASSES: [u8; 256] = {
    let mut classes = [SPECIAL; 256];
    let mut byte = 0;
    while byte < 256 {
        if byte <= b' ' as usize || byte == 0x7f {
            classes[byte] = BLANK;
        }
        byte += 1;
    }
    let mut letter = b'A';
    while letter <= b'Z' {
        if letter != b'O' {
            classes[letter as usize] = LETTER;
            classes[letter.to_ascii_lowercase() as usize] = LETTER;
        }
        letter += 1;
    }
    classes[b'\n' as usize] = LINE_END;
    classes[b'\r' as usize] = LINE_END;
    classes
};

/// Reads a line of letters, plain numbers and blanks, as nearly all lines are. For any other line, a last line and an
/// empty line it returns `None` and leaves nothing in the batch.
#[inline]
pub(in crate::program::dialect) fn read_plain_line(source: Source<'_>, batch: &mut Batch) -> Option<usize> {
    let mut line = PlainLine::begin(source, batch);
    let is_plain = plain_words(&mut line, |_| None).is_some();
    line.end(is_plain, Shows::PointsAndZeros)
}

/// The same with comments.
#[inline]
fn read_plain_line_and_comments(source: Source<'_>, batch: &mut Batch) -> Option<usize> {
    let mut line = PlainLine::begin(source, batch);
    let is_plain = plain_words(&mut line, skip_comment).is_some();
    line.end(is_plain, Shows::PointsAndZeros)
}

/// Moves to the byte after a comment; `None` if there is no comment.
#[inline]
fn skip_comment(line: &mut PlainLine<'_>) -> Option<()> {
    let end = match line.byte()? {
        b'(' => comment_end(line.text, line.at).ok()?,
        b';' => line_end(line.text, line.at),
        _ => return None,
    };
    line.skip_comment(end, Address::M)
}

#[expect(clippy::inline_always, reason = "the line stays in registers")]
#[inline(always)]
fn plain_words(
    line: &mut PlainLine<'_>,
    skip_special: impl Fn(&mut PlainLine<'_>) -> Option<()>,
) -> Option<()> {
    let mut has_words = false;
    loop {
        let letter = line.byte()?;
        match CLASSES[letter as usize] {
            LETTER => {}
            BLANK => {
                line.at += 1;
                continue;
            }
            LINE_END => return has_words.then_some(()),
            _ => {
                skip_special(line)?;
                continue;
            }
        }
        if letter | 0x20 == b'e' && follows_number(line.text, line.start, line.at) {
            return None;
        }
        line.at += 1;
        line.word(Address::of_letter(letter), 1)?;
        has_words = true;
    }
}

/// Reads a line and adds it to the batch.
pub(in crate::program) fn read_line(source: Source<'_>, batch: &mut Batch) -> LineRead {
    match read_plain_line_and_comments(source, batch) {
        Some(next) => LineRead::one(next),
        None => read_any_line(source, batch),
    }
}

/// The same for every line.
fn read_any_line(source: Source<'_>, batch: &mut Batch) -> LineRead {
    let text = source.text;
    let mut line = Line::new(source, Extent::ONE_LINE, REPEATABLE, batch);
    while let Some(&byte) = text.get(line.at) {
        match CLASSES[byte as usize] {
            LETTER => word(&mut line, byte),
            BLANK => line.at += 1,
            LINE_END => break,
            _ => special(&mut line, byte),
        }
    }
    let kind = kind_of(&line);
    line.close(kind)
}

#[inline]
fn word(line: &mut Line<'_>, letter: u8) {
    let start = line.at;
    if letter | 0x20 == b'e' && follows_number(line.text, line.start, start) && is_exponent(line) {
        return fail_exponent(line);
    }
    let mut at = line.blanks_end(start + 1);
    let byte = line.byte(at);
    let negative = byte == b'-';
    if negative || byte == b'+' {
        at = line.blanks_end(at + 1);
    }
    let address = Address::of_letter(letter);
    match read_unsigned(line.text, at) {
        Some(number) if number.value <= MAX_MAGNITUDE => {
            line.unsigned_word(address, start, 1, negative, &number);
        }
        Some(number) => {
            let value = if negative { -number.value } else { number.value };
            line.fail_too_large(address, value, start, number.end);
        }
        None => statement::odd_word(line, letter),
    }
}

/// Whether an `E` directly after a number is its exponent. With a decimal point the `E` is a word: `X10.5E3.2`.
#[cold]
fn is_exponent(line: &Line<'_>) -> bool {
    exponent_at(line.text, line.at).is_some_and(|(_, has_point)| !has_point)
}

/// Fails the line because of an exponent at the present position.
#[cold]
pub(in crate::program::dialect) fn fail_exponent(line: &mut Line<'_>) {
    let start = number_start(line.text, line.start, line.at);
    line.fail_with(|text| DiagnosticCode::Exponent { text }, start);
}

fn special(line: &mut Line<'_>, byte: u8) {
    match byte {
        b'(' => comment(line),
        b';' => {
            line.flags.set(BlockFlags::COMMENT);
            line.skip_all();
        }
        b'%' if line.is_untouched() => {
            line.kind = Some(BlockKind::Percent);
            line.skip_all();
        }
        b'/' => {
            line.flags.set(BlockFlags::DELETE);
            line.at += 1;
            if matches!(line.byte(line.at), b'1'..=b'9') && !line.byte(line.at + 1).is_ascii_digit() {
                line.at += 1;
            }
        }
        0xef if line.is_at_byte_order_mark() => line.at += 3,
        _ => statement::special(line, byte),
    }
}

/// A comment. After an M code it may be the code's argument, `M202(0.0059)`, and then it stays with the code.
fn comment(line: &mut Line<'_>) {
    let start = line.at;
    let Ok(end) = comment_end(line.text, start) else {
        return line.fail_with(|text| DiagnosticCode::NestedComment { text }, start);
    };
    line.flags.set(BlockFlags::COMMENT);
    line.at = end;
    let (from, to) = (line.in_batch(start), line.in_batch(end));
    let is_closed = line.slice(start, end).ends_with(b")");
    if let Some(word) = line.last_word()
        && word.address == Address::M
        && word.end == from
        && is_closed
    {
        word.end = to;
    }
}

/// The kind of a line that does not state its kind.
fn kind_of(line: &Line<'_>) -> BlockKind {
    if !line.words().is_empty() || line.flags.has(BlockFlags::DELETE) {
        BlockKind::Words
    } else if line.flags.has(BlockFlags::ASSIGNS) {
        BlockKind::Assignment
    } else if line.flags.has(BlockFlags::COMMENT) {
        BlockKind::Comment
    } else if line.slice(line.start, line.at).trim_ascii().is_empty() {
        BlockKind::Blank
    } else {
        // Control bytes that old tapes and systems leave: a block without words.
        BlockKind::Words
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::dialect::plain::tests::compare;

    #[test]
    fn plain_lines_are_read_as_in_the_general_way() {
        let plain = ["N10 G1 X1.5 Y-2.25", "X1Y2(note)Z3", "G1 G1 X1 X2", "X0.12345678 ; note"];
        let pieces =
            "N10 |G1|G43.4 |X|Y|z|A|E|e5|G90 |M8|M8 |(note)|(a (b) c)|(a (X1) X2)|;note|X1|#1=2|[|,R2|O1|/|%";
        compare(&plain, pieces, read_plain_line_and_comments, |source, batch| {
            Some(read_any_line(source, batch))
        });
    }
}
