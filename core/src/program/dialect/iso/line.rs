//! Turns one line of ISO G-code into words. The plain case is one loop over letters, blanks and numbers; everything
//! else is in `statement`.

use super::statement;
use crate::program::comment::comment_end;
use crate::program::dialect::LineRead;
use crate::program::dialect::line::{Extent, Line, MAX_WORDS, REPEATABLE, Source};
use crate::program::line;
use crate::program::number::{
    MAX_MAGNITUDE, exponent_at, follows_number, number_start, read_short, read_unsigned,
};
use crate::program::{Address, Batch, Block, BlockFlags, BlockKind, DiagnosticCode, Word, WordForm};

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

/// The words and the block of a plain line. If the line is not plain, some words may already have been added.
#[inline]
fn words_of_plain_line(source: Source<'_>, batch: &mut Batch) -> Option<usize> {
    let Source { text, start, shift, line: number, .. } = source;
    #[expect(clippy::cast_possible_truncation, reason = "a batch is closed far below 4 GiB")]
    let in_batch = |at: usize| at.wrapping_add(shift) as u32;
    let words = &mut batch.words;
    let first_word = words.len();
    let (mut seen, mut repeated) = (0_u32, 0_u32);
    let (mut drops_zero, mut points) = (false, false);
    let mut at = start;
    loop {
        let letter = *text.get(at)?;
        match CLASSES[letter as usize] {
            LETTER => {}
            BLANK => {
                at += 1;
                continue;
            }
            LINE_END => break,
            _ => return None,
        }
        if letter | 0x20 == b'e' && follows_number(text, start, at) {
            return None;
        }
        let sign = *text.get(at + 1)?;
        let negative = sign == b'-';
        let read = read_short(text, at + 1 + usize::from(negative || sign == b'+'))?;
        let address = Address::of_letter(letter);
        let bit = 1 << address.index();
        repeated |= seen & bit;
        seen |= bit;
        drops_zero |= !read.has_whole;
        points |= read.has_point;
        words.push(Word {
            // 0 − 0 is +0, so a negative zero never gets in.
            value: if negative { 0.0 - read.value } else { read.value },
            start: in_batch(at),
            end: in_batch(read.end),
            address,
            lead: 1,
            decimals: read.decimals,
            form: WordForm::Number,
            has_point: read.has_point,
        });
        at = read.end;
    }
    let words_end = words.len();
    if words_end == first_word || words_end - first_word > MAX_WORDS {
        return None;
    }
    batch.habits.drops_zero |= drops_zero;
    batch.habits.points |= points;
    let mut flags = BlockFlags::default();
    if repeated & !REPEATABLE != 0 {
        flags.set(BlockFlags::REPEATED);
    }
    let end = line::next_line(text, at);
    #[expect(clippy::cast_possible_truncation, reason = "fewer words than bytes")]
    let (words_start, words_end) = (first_word as u32, words_end as u32);
    batch.blocks.push(Block {
        line: number,
        start: in_batch(start),
        body_end: in_batch(at),
        end: in_batch(end),
        words_start,
        words_end,
        kind: BlockKind::Words,
        flags,
    });
    Some(end)
}

/// Reads a line of letters, short numbers and blanks, as nearly all lines are. For any other line, a last line and an
/// empty line it returns `None` and leaves nothing in the batch.
#[inline]
pub(in crate::program::dialect) fn read_plain_line(
    source: Source<'_>,
    batch: &mut Batch,
) -> Option<LineRead> {
    let first_word = batch.words.len();
    let next = words_of_plain_line(source, batch);
    if next.is_none() {
        batch.words.truncate(first_word);
    }
    next.map(LineRead::one)
}

/// Reads a line and adds it to the batch.
pub(in crate::program) fn read_line(source: Source<'_>, batch: &mut Batch) -> LineRead {
    if let Some(read) = read_plain_line(source, batch) {
        return read;
    }
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
