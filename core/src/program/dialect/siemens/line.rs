//! Turns one line of a Sinumerik program into words.

use super::constants::exponent_end;
use super::statement;
use crate::program::comment::comment_end;
use crate::program::dialect::LineRead;
use crate::program::dialect::line::{Extent, Line, REPEATABLE, Source};
use crate::program::dialect::plain::{PlainLine, Shows};
use crate::program::line::line_end;
use crate::program::number::{
    MAX_MAGNITUDE, Unsigned, exponent_at, follows_number, number_start, read_unsigned,
};
use crate::program::{Address, Batch, BlockFlags, BlockKind, DiagnosticCode, Keyword, WordForm};

const SPECIAL: u8 = 0;
const LETTER: u8 = 1;
const BLANK: u8 = 2;
const LINE_END: u8 = 3;

/// The kind of text that a byte can begin. Control bytes are blanks. An underscore begins names, as letters do.
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
        classes[letter as usize] = LETTER;
        classes[letter.to_ascii_lowercase() as usize] = LETTER;
        letter += 1;
    }
    classes[b'\n' as usize] = LINE_END;
    classes[b'\r' as usize] = LINE_END;
    classes
};

/// Addresses that may occur several times in a block. H is one of them, for several functions at once.
const MAY_REPEAT: u32 = REPEATABLE | (1 << Address::H.index());

/// Reads a line and adds it to the batch.
pub(in crate::program) fn read_line(source: Source<'_>, batch: &mut Batch) -> LineRead {
    match read_plain_line(source, batch) {
        Some(next) => LineRead::one(next),
        None => read_any_line(source, batch),
    }
}

/// Reads a line of words `X10` and `X=10`, blanks and a comment after `;`. For any other line it returns `None` and
/// leaves nothing in the batch.
fn read_plain_line(source: Source<'_>, batch: &mut Batch) -> Option<usize> {
    let mut line = PlainLine::begin(source, batch);
    let is_plain = plain_words(&mut line).is_some();
    line.end(is_plain, Shows::PointsAndZeros)
}

#[expect(clippy::inline_always, reason = "the line stays in registers")]
#[inline(always)]
fn plain_words(line: &mut PlainLine<'_>) -> Option<()> {
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
            _ if letter == b';' => {
                let end = line_end(line.text, line.at);
                line.skip_comment(end, Address::M)?;
                continue;
            }
            _ => return None,
        }
        // Parameters, subprograms, exponents, and words that may repeat.
        if matches!(letter | 0x20, b'e' | b'h' | b'l' | b'r') {
            return None;
        }
        line.at += 1;
        if line.byte()? == b'=' && letter | 0x20 != b'n' {
            line.at += 1;
            line.word(Address::of_letter(letter), 2)?;
        } else {
            line.word(Address::of_letter(letter), 1)?;
        }
        // An operator, an index or `=` may follow: then the letter is something else.
        if !matches!(line.byte()?, b' ' | b'\t' | b'\n' | b'\r') {
            return None;
        }
        has_words = true;
    }
}

/// The same for every line.
fn read_any_line(source: Source<'_>, batch: &mut Batch) -> LineRead {
    let text = source.text;
    let mut line = Line::new(source, Extent::ONE_LINE, MAY_REPEAT, batch);
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

/// A letter with a number after it. Anything else is a statement.
#[inline]
fn word(line: &mut Line<'_>, letter: u8) {
    let start = line.at;
    if letter | 0x20 == b'e' && is_exponent(line, start) {
        return fail_exponent(line, start);
    }
    let mut at = start + 1;
    let mut byte = line.byte(at);
    if byte == b'=' {
        return equals_word(line, letter);
    }
    while byte == b' ' || byte == b'\t' {
        at += 1;
        byte = line.byte(at);
    }
    let negative = byte == b'-';
    let signed = negative || byte == b'+';
    if signed {
        at = line.blanks_end(at + 1);
    }
    let Some(number) = read_unsigned(line.text, at) else { return statement::named(line, start) };
    // `X1=`, `L340(…)`, `M[1]=` and similar texts are names. So is a letter with a meaning of its own.
    let next = line.byte(number.end);
    let takes_argument = matches!(letter, b'M' | b'm' | b'H' | b'h');
    let is_odd = matches!(next, b'=' | b'[' | b'_' | b'"' | b'E' | b'e')
        || (next == b'(' && !takes_argument)
        || (matches!(next, b' ' | b'\t') && has_equals(line, number.end))
        || matches!(letter, b'L' | b'l' | b'R' | b'r');
    if is_odd && (!signed || matches!(next, b'E' | b'e' | b'_')) {
        return statement::odd_number(line, start, at, number.end, negative);
    }
    let address = Address::of_letter(letter);
    if number.value > MAX_MAGNITUDE {
        let value = if negative { -number.value } else { number.value };
        return line.fail_too_large(address, value, start, number.end);
    }
    line.unsigned_word(address, start, 1, negative, &number);
}

/// `X=10.5`: a letter and `=`. If only a number follows, the word is as plain as `X10.5`.
#[inline]
fn equals_word(line: &mut Line<'_>, letter: u8) {
    let start = line.at;
    let mut at = start + 2;
    let negative = line.byte(at) == b'-';
    at += usize::from(negative || line.byte(at) == b'+');
    let number = match read_unsigned(line.text, at) {
        Some(number) if number.value <= MAX_MAGNITUDE && is_value_end(line, number.end) => number,
        _ => return statement::named(line, start),
    };
    if matches!(letter, b'L' | b'l' | b'N' | b'n' | b'R' | b'r') {
        return statement::named(line, start);
    }
    line.unsigned_word(Address::of_letter(letter), start, 2, negative, &number);
}

/// Whether a value certainly ends at a byte: the line ends, or blanks follow without an operator after them. Operators
/// of letters have a second letter; the letters of words do not.
#[inline]
fn is_value_end(line: &Line<'_>, at: usize) -> bool {
    match line.byte(at) {
        b'\n' | b'\r' | b';' => true,
        b' ' | b'\t' => {
            let next = line.blanks_end(at);
            let byte = line.byte(next);
            let second = line.byte(next + 1);
            matches!(byte, b'\n' | b'\r' | b';')
                || (byte.is_ascii_alphabetic() && !second.is_ascii_alphabetic() && second != b'_')
        }
        _ => false,
    }
}

/// Whether `=` (and not `==`) comes next, after blanks.
#[inline]
pub(super) fn has_equals(line: &Line<'_>, at: usize) -> bool {
    let at = line.blanks_end(at);
    line.byte(at) == b'=' && line.byte(at + 1) != b'='
}

fn special(line: &mut Line<'_>, byte: u8) {
    match byte {
        b';' => {
            line.flags.set(BlockFlags::COMMENT);
            line.skip_all();
        }
        b'_' | b'$' => statement::named(line, line.at),
        b'%' if line.is_untouched() => {
            line.kind = Some(BlockKind::Percent);
            line.skip_all();
        }
        b'/' if line.has_only_number() => {
            line.flags.set(BlockFlags::DELETE);
            line.at += 1;
            if line.byte(line.at).is_ascii_digit() && !line.byte(line.at + 1).is_ascii_digit() {
                line.at += 1;
            }
        }
        // The number of a main block.
        b':' if line.is_untouched() => match read_unsigned(line.text, line.at + 1) {
            Some(number) if !number.has_point && number.value <= MAX_MAGNITUDE => {
                let number = Unsigned { decimals: 0, ..number };
                line.unsigned_word(Address::N, line.at, 1, false, &number);
            }
            _ => line.fail_unexpected(line.at),
        },
        b'(' if take_argument(line) => {}
        0xef if line.is_at_byte_order_mark() => line.at += 3,
        _ => line.fail_unexpected(line.at),
    }
}

/// `M202(0.0059)`: an argument in round brackets after an M or an H code belongs to its word.
fn take_argument(line: &mut Line<'_>) -> bool {
    let Ok(end) = comment_end(line.text, line.at) else { return false };
    let is_closed = line.slice(line.at, end).ends_with(b")");
    let end_in_batch = line.in_batch(end);
    let code_end = line.in_batch(line.start + line.slice(line.start, line.at).trim_ascii_end().len());
    match line.last_word() {
        Some(word)
            if is_closed
                && matches!(word.address, Address::M | Address::H)
                && word.form != WordForm::Keyword
                && word.end == code_end =>
        {
            word.end = end_in_batch;
            line.at = end;
            true
        }
        _ => false,
    }
}

/// Adds a statement word between two bytes of the line, and moves to the byte after it.
pub(super) fn push_keyword(line: &mut Line<'_>, keyword: Keyword, start: usize, end: usize) {
    line.at = line.at.max(end);
    line.keyword(keyword, start, end);
}

/// Whether the letter at a byte is the `E` of an exponent, directly after a number. The control's own exponents are
/// written `EX`, and none of its words begins with `E` alone there.
fn is_exponent(line: &Line<'_>, at: usize) -> bool {
    follows_number(line.text, line.start, at) && exponent_at(line.text, at).is_some()
}

/// Fails a line because of an exponent whose letter is at this byte.
#[cold]
pub(super) fn fail_exponent(line: &mut Line<'_>, at: usize) {
    let start = number_start(line.text, line.start, at);
    line.fail_with(|text| DiagnosticCode::Exponent { text }, start);
}

/// A number is missing, or a bracket is not closed.
#[cold]
pub(super) fn fail_value(line: &mut Line<'_>, start: usize, is_unclosed: bool) {
    if is_unclosed {
        line.fail_unclosed(start);
    } else {
        line.fail_number(start);
    }
}

/// The kind of a line that does not state its kind.
fn kind_of(line: &Line<'_>) -> BlockKind {
    let says_nothing = || {
        let body = line.slice(line.start, line.at).trim_ascii();
        body.first().is_none_or(|byte| *byte == b';')
    };
    if !line.words().is_empty() || line.flags.has(BlockFlags::DELETE) {
        BlockKind::Words
    } else if line.flags.has(BlockFlags::ASSIGNS) {
        BlockKind::Assignment
    } else if says_nothing() {
        if line.flags.has(BlockFlags::COMMENT) { BlockKind::Comment } else { BlockKind::Blank }
    } else {
        // A message, a label, a statement without meaning for the path: a block without words.
        BlockKind::Words
    }
}

/// Whether an exponent `EX…` is at a byte.
pub(super) fn has_exponent(text: &[u8], at: usize) -> Option<usize> {
    exponent_end(text, at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::dialect::plain::tests::compare;

    #[test]
    fn plain_lines_are_read_as_in_the_general_way() {
        let plain = ["N10 G1 X=1.5 Y-2.25 ; note", "X1 A=-.5 C=+5"];
        let pieces =
            "N10 |G1|G1 |X|Y=|z|A3=|A=|C = |N=|R1=|L5|H2|X1=|AC(|)|M8 |;note|MOD |D1|_|E|EX|EX5|[|/|:";
        compare(&plain, pieces, read_plain_line, |source, batch| Some(read_any_line(source, batch)));
    }
}
