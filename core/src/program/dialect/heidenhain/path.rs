//! The words of a path: coordinates, vectors, feed, radius compensation and M codes.

use super::line::{Value, value};
use crate::program::comment::comment_end;
use crate::program::dialect::line::Line;
use crate::program::line::{line_end, next_line};
use crate::program::{Address, BlockFlags, BlockKind, Keyword, WordForm};

/// M codes to which the words after them belong: a feed of other motions (M103, M128), limits of the handwheel (M118),
/// axes (M94, M138), distances (M140), blocks or angles (M112, M120, M124).
const WITH_ARGUMENTS: [u32; 9] = [94, 103, 112, 118, 120, 124, 128, 138, 140];
/// M140.
const RETRACT: f64 = 140.0;

/// Reads the words after the statement's own word, which ends at `end`. Without `coordinates` the axis words do not
/// name a place to go to.
pub(super) fn read(
    scan: &mut Line<'_>,
    keyword: Option<Keyword>,
    end: usize,
    coordinates: bool,
) -> BlockKind {
    if let Some(keyword) = keyword {
        scan.keyword(keyword, scan.at, end);
    }
    scan.at = end;
    let has_radius = keyword == Some(Keyword::ArcOfRadius);
    let mut radius_open = has_radius;
    while scan.at < scan.extent.body_end {
        let start = scan.at;
        match scan.byte(start).to_ascii_uppercase() {
            b' ' | b'\t' | b'~' | b'\r' | b'\n' => scan.at += 1,
            b';' => comment(scan),
            letter @ (b'X' | b'Y' | b'Z' | b'A' | b'B' | b'C') => {
                word(scan, axis(letter), WordForm::Number, start, 1, coordinates);
            }
            b'I' => match scan.byte(start + 1).to_ascii_uppercase() {
                letter @ (b'X' | b'Y' | b'Z' | b'A' | b'B' | b'C') => {
                    word(scan, axis(letter), WordForm::Incremental, start, 2, coordinates);
                }
                b'U' | b'V' | b'W' => other_axis(scan, start, start + 2),
                _ => scan.fail_unexpected(start),
            },
            b'U' | b'V' | b'W' => other_axis(scan, start, start + 1),
            b'N' => vector(scan, start, [Address::NX, Address::NY, Address::NZ]),
            b'T' => vector(scan, start, [Address::TI, Address::TJ, Address::TK]),
            b'F' => feed(scan, start),
            b'R' if radius_open => {
                radius_open = false;
                skip_value(scan, start, 1);
            }
            b'R' => compensation(scan, start),
            b'M' => m_code(scan, start),
            b'D' if scan.byte(start + 1).eq_ignore_ascii_case(&b'R') => {
                let end = start + 2 + usize::from(matches!(scan.byte(start + 2), b'+' | b'-'));
                scan.keyword(Keyword::Sense, start, end);
                scan.at = end;
            }
            _ => scan.fail_unexpected(start),
        }
    }
    BlockKind::Words
}

/// Reads only the words that stay in force after the statement, and skips all others.
pub(super) fn read_modes(scan: &mut Line<'_>) {
    let statement = scan.slice(scan.start, scan.at);
    // A rounding or a chamfer has its own feed.
    let own_feed = [b"RND", b"CHF"].iter().any(|word| {
        statement.get(statement.len().saturating_sub(3)..).is_some_and(|end| end.eq_ignore_ascii_case(*word))
    });
    while scan.at < scan.extent.body_end {
        let start = scan.at;
        let letters = scan.letters_end(start);
        match scan.byte(start).to_ascii_uppercase() {
            b';' => comment(scan),
            b'F' if !own_feed => feed(scan, start),
            b'M' if letters == start + 1 => m_code(scan, start),
            b'R' if matches!(scan.slice(start, start + 2), b"RL" | b"RR" | b"R0" | b"rl" | b"rr" | b"r0") => {
                compensation(scan, start);
            }
            byte if byte.is_ascii_alphabetic() => match value(scan, letters) {
                (_, Value::Number(number)) => scan.at = number.end,
                (_, Value::Parameter(end)) => scan.at = end,
                (_, Value::None) => scan.at = letters,
            },
            _ => scan.at += 1,
        }
    }
}

/// Moves to the byte after the comment. The statement may continue on the next line.
fn comment(scan: &mut Line<'_>) {
    scan.flags.set(BlockFlags::COMMENT);
    let end = line_end(scan.text, scan.at).min(scan.extent.body_end);
    scan.at = if end < scan.extent.body_end { next_line(scan.text, end) } else { end };
}

fn axis(letter: u8) -> Address {
    Address::from_letter(letter).unwrap_or(Address::X)
}

/// A word of `lead` letters at `start` with its value.
fn word(scan: &mut Line<'_>, address: Address, form: WordForm, start: usize, lead: usize, counts: bool) {
    match value(scan, start + lead) {
        (_, Value::Number(number)) if !counts => scan.at = number.end,
        (_, Value::Parameter(end)) if !counts => scan.at = end,
        (_, Value::Number(number)) => scan.number_word(address, form, start, lead, number),
        (_, Value::Parameter(end)) => scan.expression(address, start, lead, end),
        (_, Value::None) => scan.fail_number(start),
    }
}

/// An axis that no five-axis machine in this model has.
fn other_axis(scan: &mut Line<'_>, start: usize, end: usize) {
    scan.keyword(Keyword::UnknownStatement, start, end);
    skip_value(scan, start, end - start);
}

fn skip_value(scan: &mut Line<'_>, start: usize, lead: usize) {
    match value(scan, start + lead) {
        (_, Value::Number(number)) => scan.at = number.end,
        (_, Value::Parameter(end)) => scan.at = end,
        (_, Value::None) => scan.fail_number(start),
    }
}

/// `NX+0.3`, `TZ-0.1`
fn vector(scan: &mut Line<'_>, start: usize, [x, y, z]: [Address; 3]) {
    let address = match scan.byte(start + 1).to_ascii_uppercase() {
        b'X' => x,
        b'Y' => y,
        b'Z' => z,
        _ => return scan.fail_unexpected(start),
    };
    word(scan, address, WordForm::Number, start, 2, true);
}

/// `F1000`, `FMAX`, `FAUTO`, `F Q5`, `FU0.1`, `FZ0.05`
fn feed(scan: &mut Line<'_>, start: usize) {
    let mut at = start + 1;
    while matches!(scan.byte(at), b' ' | b'\t') {
        at += 1;
    }
    let letters = scan.letters_end(at);
    let word_text = scan.slice(at, letters);
    if word_text.eq_ignore_ascii_case(b"MAX") {
        scan.keyword(Keyword::Fmax, start, letters);
        scan.at = letters;
    } else if word_text.eq_ignore_ascii_case(b"AUTO") {
        scan.keyword(Keyword::FeedElsewhere, start, letters);
        scan.at = letters;
    } else if word_text.eq_ignore_ascii_case(b"U") || word_text.eq_ignore_ascii_case(b"Z") {
        // Per revolution or per tooth, from here to the next F.
        scan.keyword(Keyword::FeedElsewhere, start, letters);
        skip_value(scan, start, letters - start);
    } else {
        word(scan, Address::F, WordForm::Number, start, 1, true);
    }
}

/// `R0`, `RL`, `RR`, and the `R+` `R-` of single axes.
fn compensation(scan: &mut Line<'_>, start: usize) {
    let keyword = match scan.byte(start + 1).to_ascii_uppercase() {
        b'0' => Keyword::R0,
        b'L' | b'R' | b'+' | b'-' => Keyword::RadiusCompensation,
        _ => return scan.fail_unexpected(start),
    };
    scan.keyword(keyword, start, start + 2);
    scan.at = start + 2;
}

/// `MB MAX` and a feed after M140.
fn retract(scan: &mut Line<'_>, code: f64) {
    let text = scan.slice(scan.at, scan.extent.body_end);
    let text = text.split(|byte| matches!(byte, b';' | b'\r' | b'\n')).next().unwrap_or_default();
    let mut words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let is_max = words.next().is_some_and(|word| word.eq_ignore_ascii_case(b"MB"))
        && words.next().is_some_and(|word| word.eq_ignore_ascii_case(b"MAX"));
    if (code - RETRACT).abs() > 0.0 || !is_max {
        return;
    }
    let keyword = match (words.next(), words.next()) {
        (None, _) => Keyword::RetractToLimit,
        (Some(feed), None) if feed.eq_ignore_ascii_case(b"FMAX") => Keyword::RetractToLimit,
        (Some([b'F' | b'f', digits @ ..]), None) if digits.iter().all(u8::is_ascii_digit) => {
            Keyword::RetractToLimitAtFeed
        }
        _ => return,
    };
    scan.keyword(keyword, scan.at, scan.at);
}

fn m_code(scan: &mut Line<'_>, start: usize) {
    let (_, Value::Number(number)) = value(scan, start + 1) else { return scan.fail_number(start) };
    // `M202(0.0059)`: the argument belongs to its code.
    let mut code = number;
    if scan.byte(number.end) == b'('
        && let Ok(end) = comment_end(scan.text, number.end)
        && scan.slice(number.end, end).ends_with(b")")
    {
        code.end = end;
    }
    scan.number_word(Address::M, WordForm::Number, start, 1, code);
    let takes_words = WITH_ARGUMENTS.iter().any(|code| (f64::from(*code) - number.value).abs() < 1e-6);
    if !takes_words || scan.kind.is_some() {
        return;
    }
    retract(scan, number.value);
    // Up to the next M code.
    while scan.at < scan.extent.body_end {
        match scan.byte(scan.at).to_ascii_uppercase() {
            b';' => comment(scan),
            b'M' if scan.letters_end(scan.at) == scan.at + 1 => return,
            byte if byte.is_ascii_alphabetic() => scan.at = scan.letters_end(scan.at),
            _ => scan.at += 1,
        }
    }
}
