//! The statements that are not paths, by their first words.

use super::cycle;
use super::hole;
use super::line::{Value, value};
use super::path;
use crate::program::dialect::line::Line;
use crate::program::dialect::number::{Number, fingerprint};
use crate::program::{Address, BlockFlags, BlockKind, Keyword, WordForm};

/// Statements that change nothing on which the path depends.
const HARMLESS: [&[u8]; 11] = [
    b"BLK", b"STOP", b"PATTERN", b"SEL", b"SELECT", b"DECLARE", b"DEFINE", b"OPEN", b"CLOSE", b"ERROR",
    b"NULL",
];

/// Reads the statement at the present position.
pub(super) fn read(scan: &mut Line<'_>) -> BlockKind {
    let start = scan.at;
    let end = scan.letters_end(start);
    let mut word = [0; 9];
    let text = scan.slice(start, end);
    if text.len() > word.len() || text.is_empty() {
        return unknown(scan, start);
    }
    for (slot, byte) in word.iter_mut().zip(text) {
        *slot = byte.to_ascii_uppercase();
    }
    let word = word.get(..text.len()).unwrap_or_default();
    match word {
        b"L" => path::read(scan, Some(Keyword::L), end, true),
        b"LN" => path::read(scan, Some(Keyword::Ln), end, true),
        b"C" => path::read(scan, Some(Keyword::ArcAboutCentre), end, true),
        // The radius decides the circle and not the end.
        b"CR" => path::read(scan, Some(Keyword::ArcOfRadius), end, true),
        b"CT" => path::read(scan, Some(Keyword::TangentArc), end, true),
        // The pole is not a place to go to.
        b"CC" => path::read(scan, Some(Keyword::CircleCentre), end, false),
        b"M" => path::read(scan, None, start, true),
        b"CP" | b"CTP" | b"LP" | b"RND" | b"CHF" | b"APPR" | b"DEP" | b"FL" | b"FLT" | b"FC" | b"FCT"
        | b"FPOL" | b"FSELECT" | b"SPL" => contour_element(scan, start, end),
        b"LBL" => label(scan, end),
        b"CALL" => call(scan, start, end),
        b"FN" => function(scan, start, end),
        b"Q" | b"QL" | b"QR" | b"QS" => assignment(scan, start),
        b"CYCL" | b"CYCLE" => cycle::read(scan, start, end),
        b"TOOL" => tool(scan, start, end),
        b"BEGIN" => begin(scan, start, end),
        b"END" => end_program(scan, start, end),
        b"PLANE" => plane(scan, start, end),
        b"FUNCTION" => control_function(scan, start, end),
        b"TRANS" => cycle::datum_function(scan, start, end),
        b"TCH" => said(scan, Keyword::Probe, start),
        _ if HARMLESS.contains(&word) => harmless(scan, start),
        _ => unknown(scan, start),
    }
}

/// Reads the statement as this word only.
pub(super) fn said(scan: &mut Line<'_>, keyword: Keyword, start: usize) -> BlockKind {
    let end = scan.extent.body_end;
    scan.keyword(keyword, start, end);
    scan.skip_all();
    BlockKind::Words
}

fn unknown(scan: &mut Line<'_>, start: usize) -> BlockKind {
    // Text with which no statement begins cannot be read. An unknown statement can be left unchanged.
    if scan.byte(start).is_ascii_alphabetic() {
        return said(scan, Keyword::UnknownStatement, start);
    }
    scan.fail_unexpected(start);
    BlockKind::Malformed
}

/// A harmless statement. The M codes after `STOP` count.
fn harmless(scan: &mut Line<'_>, start: usize) -> BlockKind {
    let end = scan.letters_end(start);
    if scan.slice(start, end).eq_ignore_ascii_case(b"STOP") {
        scan.keyword(Keyword::Statement, start, end);
        return path::read(scan, None, end, true);
    }
    said(scan, Keyword::Statement, start)
}

/// An element that the control computes from its neighbours or in polar coordinates. Only the modes are read.
fn contour_element(scan: &mut Line<'_>, start: usize, end: usize) -> BlockKind {
    scan.keyword(Keyword::ContourElement, start, end);
    scan.at = end;
    path::read_modes(scan);
    BlockKind::Words
}

/// The word at the present position in upper case, up to eight letters, and one after it.
fn next_word(scan: &mut Line<'_>) -> ([u8; 8], usize) {
    scan.skip_blanks();
    let end = scan.letters_end(scan.at);
    let mut word = [b' '; 8];
    for (slot, byte) in word.iter_mut().zip(scan.slice(scan.at, end)) {
        *slot = byte.to_ascii_uppercase();
    }
    (word, end)
}

/// A label's number, or a number that represents its name; `None` if a parameter names it.
fn label_name(scan: &mut Line<'_>) -> Option<(f64, usize)> {
    scan.skip_blanks();
    let from = scan.at;
    if scan.byte(from) == b'"' {
        let rest = scan.slice(from + 1, scan.extent.body_end);
        let length = memchr::memchr3(b'"', b'\n', b'\r', rest)?;
        let name = rest.get(..length)?;
        // Larger than all label numbers. If two names had the same number, they would only be taken as one label.
        let number = 1e6 + fingerprint(name.iter().copied());
        return Some((number, from + length + 2));
    }
    match value(scan, from) {
        (_, Value::Number(number)) => Some((number.value, number.end)),
        _ => None,
    }
}

/// Adds a label's name as a P word.
fn name_word(scan: &mut Line<'_>, name: Option<(f64, usize)>) {
    let start = scan.at;
    match name {
        Some((value, end)) => {
            let number = Number::standing_for(value, end);
            scan.number_word(Address::P, WordForm::Number, start, 0, number);
        }
        None => scan.expression(Address::P, start, 0, start),
    }
}

fn label(scan: &mut Line<'_>, end: usize) -> BlockKind {
    let start = scan.at;
    scan.at = end;
    let name = label_name(scan);
    let is_end = name.is_some_and(|(value, _)| value.abs() < 0.5);
    scan.keyword(if is_end { Keyword::LabelEnd } else { Keyword::Label }, start, end);
    name_word(scan, name);
    scan.skip_all();
    BlockKind::Words
}

/// `CALL LBL n [REP k]`, `CALL PGM …` and all other calls.
fn call(scan: &mut Line<'_>, start: usize, end: usize) -> BlockKind {
    scan.at = end;
    let (word, word_end) = next_word(scan);
    if word != *b"LBL     " {
        scan.skip_all();
        return BlockKind::Call;
    }
    scan.at = word_end;
    let name = label_name(scan);
    let behind = name.map_or(word_end, |(_, end)| end);
    let repeats = memchr::memmem::find(scan.slice(behind, scan.extent.body_end), b"REP").is_some();
    scan.keyword(if repeats { Keyword::RepeatLabel } else { Keyword::CallLabel }, start, word_end);
    name_word(scan, name);
    scan.skip_all();
    BlockKind::Words
}

/// `FN 0: Q1 = …` and similar functions.
fn function(scan: &mut Line<'_>, start: usize, end: usize) -> BlockKind {
    scan.at = end;
    scan.skip_blanks();
    let digits = scan.at;
    while scan.byte(scan.at).is_ascii_digit() {
        scan.at += 1;
    }
    let number: u32 = std::str::from_utf8(scan.slice(digits, scan.at))
        .ok()
        .and_then(|text| text.parse().ok())
        .unwrap_or(99);
    match number {
        // Sums, roots, angles, and values from the control.
        0..=8 | 13 | 18 | 24 | 28 => {
            assigns(scan, start);
            // A row of a table may have several parameters.
            if matches!(number, 24 | 28) {
                scan.flags.set(BlockFlags::SETS_CYCLE);
            }
            BlockKind::Assignment
        }
        9..=12 => {
            scan.skip_all();
            BlockKind::Flow
        }
        // Messages, prints, tables.
        14..=16 | 19 | 20 | 26 | 27 | 29 | 35 | 37 | 38 => said(scan, Keyword::Statement, start),
        // FN 17 writes into the control, FN 25 sets a datum.
        _ => said(scan, Keyword::UnknownStatement, start),
    }
}

/// `Q5 = 2 * Q3`
fn assignment(scan: &mut Line<'_>, start: usize) -> BlockKind {
    let mut at = scan.letters_end(start);
    while scan.byte(at).is_ascii_digit() {
        at += 1;
    }
    scan.at = at;
    scan.skip_blanks();
    if scan.byte(scan.at) != b'=' {
        scan.fail_unexpected(start);
        return BlockKind::Malformed;
    }
    assigns(scan, start);
    BlockKind::Assignment
}

/// The statement sets a parameter.
fn assigns(scan: &mut Line<'_>, start: usize) {
    scan.flags.set(BlockFlags::ASSIGNS);
    if hole::sets_cycle(scan.slice(start, scan.extent.body_end)) {
        scan.flags.set(BlockFlags::SETS_CYCLE);
    }
    scan.skip_all();
}

/// `TOOL CALL 5 Z S2000 F350 DL+0.1`: another tool, unless only the speed is called. `TOOL DEF` only defines a tool.
fn tool(scan: &mut Line<'_>, start: usize, end: usize) -> BlockKind {
    scan.at = end;
    let (word, word_end) = next_word(scan);
    if word != *b"CALL    " {
        return said(scan, Keyword::Statement, start);
    }
    scan.at = word_end;
    scan.skip_blanks();
    let named = scan.byte(scan.at);
    // `TOOL CALL DL+0.5`: the same tool with another length.
    let rest = scan.slice(scan.at, scan.extent.body_end);
    let has_delta =
        rest.windows(2).any(|two| two.eq_ignore_ascii_case(b"DL") || two.eq_ignore_ascii_case(b"DR"));
    let changes = has_delta || matches!(named, b'0'..=b'9' | b'"' | b'Q' | b'q');
    scan.keyword(if changes { Keyword::ToolCall } else { Keyword::Statement }, start, word_end);
    if named == b'"' {
        let (from, rest) = (scan.at, scan.slice(scan.at + 1, scan.extent.body_end));
        match memchr::memchr3(b'"', b'\n', b'\r', rest) {
            Some(length) if rest.get(length) == Some(&b'"') => {
                scan.name(Address::T, from, 0, from + length + 2);
            }
            _ => scan.at += rest.len(),
        }
    } else if let (true, (from, Value::Number(number))) = (changes, value(scan, scan.at)) {
        scan.number_word(Address::T, WordForm::Number, from, 0, number);
    } else if changes {
        while !matches!(scan.byte(scan.at), b' ' | b'\t' | b'\n' | b'\r' | b';') {
            scan.at += 1;
        }
    }
    scan.skip_blanks();
    if matches!(scan.byte(scan.at), b'X' | b'Y' | b'U' | b'V' | b'W' | b'x' | b'y' | b'u' | b'v' | b'w') {
        scan.keyword(Keyword::OtherToolAxis, scan.at, scan.at + 1);
    }
    path::read_modes(scan);
    BlockKind::Words
}

/// `BEGIN PGM name MM`
fn begin(scan: &mut Line<'_>, start: usize, end: usize) -> BlockKind {
    let rest = scan.slice(end, scan.extent.body_end);
    let rest = rest.get(..memchr::memchr(b';', rest).unwrap_or(rest.len())).unwrap_or_default().trim_ascii();
    let unit = rest.rsplit(|byte| matches!(byte, b' ' | b'\t')).next().unwrap_or_default();
    let keyword = if unit.eq_ignore_ascii_case(b"MM") {
        Keyword::BeginMm
    } else if unit.eq_ignore_ascii_case(b"INCH") || unit.eq_ignore_ascii_case(b"IN") {
        Keyword::BeginInch
    } else {
        scan.fail_unexpected(start);
        return BlockKind::Malformed;
    };
    said(scan, keyword, start)
}

/// `END PGM name MM`
fn end_program(scan: &mut Line<'_>, start: usize, end: usize) -> BlockKind {
    scan.at = end;
    let (word, _) = next_word(scan);
    if word == *b"PGM     " {
        said(scan, Keyword::EndPgm, start)
    } else {
        said(scan, Keyword::UnknownStatement, start)
    }
}

/// `PLANE RESET …` ends a tilted plane, and every other PLANE begins one.
fn plane(scan: &mut Line<'_>, start: usize, end: usize) -> BlockKind {
    scan.at = end;
    let (word, _) = next_word(scan);
    said(scan, if word == *b"RESET   " { Keyword::TiltOff } else { Keyword::TiltOn }, start)
}

/// `FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS`, `FUNCTION RESET TCPM` and others.
fn control_function(scan: &mut Line<'_>, start: usize, end: usize) -> BlockKind {
    let body = scan.slice(end, scan.extent.body_end);
    let body = body.get(..memchr::memchr(b';', body).unwrap_or(body.len())).unwrap_or_default();
    let words = || body.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let follows = |first: &[u8], second: &[u8]| {
        words()
            .zip(words().skip(1))
            .any(|(a, b)| a.eq_ignore_ascii_case(first) && b.eq_ignore_ascii_case(second))
    };
    let has = |wanted: &[u8]| words().any(|word| word.eq_ignore_ascii_case(wanted));
    let keyword = if follows(b"RESET", b"TCPM") {
        Keyword::TcpmOff
    } else if has(b"TCPM") {
        // Only this form is followed: rotary words as angles, the feed of the tip, the axes interpolated.
        let is_followed =
            follows(b"F", b"TCP") && follows(b"AXIS", b"POS") && !follows(b"PATHCTRL", b"VECTOR");
        let elsewhere = has(b"REFPNT") && !has(b"TIP-TIP");
        if is_followed && !elsewhere { Keyword::TcpmOn } else { Keyword::TcpmOther }
    } else if ["FEED", "S-PULSE", "PARAXCOMP", "DCM", "AFC", "FILE", "COUNT", "DWELL", "PROG"]
        .into_iter()
        .any(|name| words().next().is_some_and(|word| word.eq_ignore_ascii_case(name.as_bytes())))
    {
        Keyword::Statement
    } else {
        Keyword::UnknownStatement
    };
    said(scan, keyword, start)
}
