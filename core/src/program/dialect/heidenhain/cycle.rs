//! Cycles. Most of them only define the effect of a later call. A few act at their own place.

use super::hole::hole;
use super::line::{Value, value};
use super::statement::said;
use crate::program::dialect::line::Line;
use crate::program::{Address, BlockFlags, BlockKind, Keyword, WordForm};

/// Cycles of points and patterns. At their own place they call the cycle that was defined before.
const CALLING: [u32; 4] = [220, 221, 224, 239];
/// Cycles that act where they are defined, so that the cycle that waits for its call stays: dwell, spindle, contours,
/// tolerance.
const AT_ONCE: [u32; 5] = [9, 13, 14, 20, 32];
/// M codes beside a call that only switch spindle and coolant.
const BESIDE_CALL: [&[u8]; 7] = [b"M3", b"M4", b"M5", b"M8", b"M9", b"M13", b"M14"];
/// From this number on: cycles of turning, grinding and probing, some of which move at once.
const FIRST_UNKNOWN: u32 = 290;

/// `CYCL DEF 7.1 X+10`, `CYCL CALL`; `CYCLE` is accepted for `CYCL`.
pub(super) fn read(scan: &mut Line<'_>, start: usize, end: usize) -> BlockKind {
    scan.at = end;
    scan.skip_blanks();
    let verb_end = scan.letters_end(scan.at);
    let verb = scan.slice(scan.at, verb_end);
    if verb.eq_ignore_ascii_case(b"CALL") {
        let rest = scan.slice(verb_end, comment(scan, verb_end));
        let is_beside = |word: &[u8]| BESIDE_CALL.iter().any(|code| word.eq_ignore_ascii_case(code));
        let is_here = rest.split(u8::is_ascii_whitespace).all(|word| word.is_empty() || is_beside(word));
        let keyword = if is_here { Keyword::CycleCallHere } else { Keyword::CycleCall };
        return said(scan, keyword, start);
    }
    if !verb.eq_ignore_ascii_case(b"DEF") {
        return said(scan, Keyword::UnknownStatement, start);
    }
    scan.at = verb_end;
    scan.skip_blanks();
    let Some((cycle, part)) = number_and_part(scan) else {
        return said(scan, Keyword::UnknownStatement, start);
    };
    let head = scan.at;
    match cycle {
        7 => datum(scan, start, head, part),
        8 => {
            // The named axes are mirrored. If no axis is named, no axis is mirrored.
            let named =
                part == 1 && scan.slice(head, comment(scan, head)).iter().any(u8::is_ascii_alphabetic);
            let on = part != 1 || named;
            said(scan, if on { Keyword::MirrorOn } else { Keyword::MirrorOff }, start)
        }
        10 => {
            let off = part == 1 && all_values(scan, head, 0.0);
            said(scan, if off { Keyword::RotationOff } else { Keyword::RotationOn }, start)
        }
        11 => {
            let off = part == 1 && all_values(scan, head, 1.0);
            said(scan, if off { Keyword::ScalingOff } else { Keyword::ScalingOn }, start)
        }
        26 => axis_scaling(scan, start, head, part),
        19 => {
            // Without angles (answered with NO ENT) the cycle is off.
            let is_bare = || !scan.slice(head, comment(scan, head)).iter().any(u8::is_ascii_alphabetic);
            let off = part == 1 && (is_bare() || all_values(scan, head, 0.0));
            said(scan, if off { Keyword::TiltOff } else { Keyword::TiltOn }, start)
        }
        247 => preset(scan, start, head),
        number if CALLING.contains(&number) => said(scan, Keyword::CycleCall, start),
        number if number >= FIRST_UNKNOWN => said(scan, Keyword::UnknownStatement, start),
        number => {
            // The parameters of the cycle are Q parameters, and the cycle sets them.
            if memchr::memchr(b'=', scan.slice(head, scan.extent.body_end)).is_some() {
                scan.flags.set(BlockFlags::ASSIGNS);
            }
            if AT_ONCE.contains(&number) {
                said(scan, Keyword::Statement, start)
            } else if hole(scan, number, start, head) {
                BlockKind::Words
            } else {
                said(scan, Keyword::OtherCycle, start)
            }
        }
    }
}

/// `7.1` as cycle and part. The part is 0 if none is written.
fn number_and_part(scan: &mut Line<'_>) -> Option<(u32, u32)> {
    let from = scan.at;
    while scan.byte(scan.at).is_ascii_digit() {
        scan.at += 1;
    }
    let whole = scan.slice(from, scan.at);
    let number = std::str::from_utf8(whole).ok()?.parse().ok()?;
    let mut part = 0;
    if scan.byte(scan.at) == b'.' {
        let from = scan.at + 1;
        scan.at = from;
        while scan.byte(scan.at).is_ascii_digit() {
            scan.at += 1;
        }
        part = std::str::from_utf8(scan.slice(from, scan.at)).ok()?.parse().ok()?;
    }
    Some((number, part))
}

/// The position where the comment begins, or the end.
fn comment(scan: &Line<'_>, from: usize) -> usize {
    let body = scan.slice(from, scan.extent.body_end);
    from + memchr::memchr(b';', body).unwrap_or(body.len())
}

/// Whether the text has letters with values that are all `wanted`. Words of a positioning (F, R0) do not count.
fn all_values(scan: &Line<'_>, head: usize, wanted: f64) -> bool {
    let end = comment(scan, head);
    let mut at = head;
    let mut some = false;
    while at < end {
        if !scan.byte(at).is_ascii_alphabetic() {
            at += 1;
            continue;
        }
        let letters = scan.letters_end(at);
        let name = scan.slice(at, letters);
        if matches!(name, [b'I' | b'i', ..]) {
            // `IROT+0` adds nothing and removes nothing.
            return false;
        }
        let counts = !matches!(name, b"F" | b"R" | b"FMAX" | b"ABST" | b"f" | b"r");
        at = match value(scan, letters) {
            (_, Value::Number(number)) => {
                if counts && (number.value - wanted).abs() > 0.0 {
                    return false;
                }
                some |= counts;
                number.end
            }
            (_, Value::Parameter(_)) => return false,
            (_, Value::None) => letters,
        };
    }
    some
}

/// `26.1 X0.99 Y1`: each axis has its own scale. The statement gets no axis words if the scaled axes cannot be read.
fn axis_scaling(scan: &mut Line<'_>, start: usize, head: usize, part: u32) -> BlockKind {
    if part == 0 {
        return said(scan, Keyword::Statement, start);
    }
    let end = comment(scan, head);
    scan.keyword(Keyword::AxisScaling, start, head);
    let mut at = head;
    while at < end {
        let letters = scan.letters_end(at);
        if letters == at {
            at += 1;
            continue;
        }
        let name = scan.slice(at, letters);
        // `CCX+15`: the centre.
        let is_centre = matches!(name, [b'C' | b'c', b'C' | b'c', _]);
        let axis = match name {
            [letter] => Address::from_letter(*letter),
            _ => None,
        };
        let lead = letters - at;
        at = match (axis, value(scan, letters)) {
            (Some(axis), (_, Value::Number(number))) => {
                scan.number_word(axis, WordForm::Number, at, lead, number);
                number.end
            }
            (Some(axis), (_, Value::Parameter(end))) => {
                scan.expression(axis, at, lead, end);
                end
            }
            (None, (_, Value::Number(number))) if is_centre => number.end,
            (None, (_, Value::Parameter(end))) if is_centre => end,
            _ => return said(scan, Keyword::ScalingOn, at),
        };
    }
    if scan.kind.is_none() {
        scan.skip_all();
    }
    BlockKind::Words
}

/// Datum shift: `7.0` begins it, `7.1 X+10`, `7.2 Y+5`, … state it axis by axis. `#5` takes it from a table.
fn datum(scan: &mut Line<'_>, start: usize, head: usize, part: u32) -> BlockKind {
    if part == 0 {
        return said(scan, Keyword::Statement, start);
    }
    if scan.slice(head, comment(scan, head)).contains(&b'#') {
        return said(scan, Keyword::DatumTable, start);
    }
    scan.keyword(Keyword::DatumShift, start, head);
    axis_words(scan, head);
    BlockKind::Words
}

/// `TRANS DATUM AXIS X+10 Y-3`, `TRANS DATUM RESET`
pub(super) fn datum_function(scan: &mut Line<'_>, start: usize, end: usize) -> BlockKind {
    let rest = scan.slice(end, comment(scan, end)).trim_ascii();
    let starts = |word: &[u8]| rest.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word));
    if starts(b"DATUM RESET") {
        return said(scan, Keyword::DatumReset, start);
    }
    if !starts(b"DATUM AXIS") {
        return said(
            scan,
            if starts(b"DATUM") { Keyword::DatumTable } else { Keyword::UnknownStatement },
            start,
        );
    }
    let Some(at) = memchr::memmem::find(scan.slice(end, scan.extent.body_end), b"AXIS") else {
        return said(scan, Keyword::DatumTable, start);
    };
    let head = end + at + 4;
    scan.keyword(Keyword::DatumShift, start, head);
    axis_words(scan, head);
    BlockKind::Words
}

/// The axis words after `head`.
fn axis_words(scan: &mut Line<'_>, head: usize) {
    let end = comment(scan, head);
    scan.at = head;
    while scan.at < end {
        let start = scan.at;
        let incremental = scan.byte(start).eq_ignore_ascii_case(&b'I');
        let letter = start + usize::from(incremental);
        let Some(address) = Address::from_letter(scan.byte(letter)) else {
            if matches!(scan.byte(start), b' ' | b'\t' | b'~' | b'\r' | b'\n') {
                scan.at += 1;
                continue;
            }
            return scan.fail_unexpected(start);
        };
        let form = if incremental { WordForm::Incremental } else { WordForm::Number };
        match value(scan, letter + 1) {
            (_, Value::Number(number)) => scan.number_word(address, form, start, letter + 1 - start, number),
            (_, Value::Parameter(end)) => scan.expression(address, start, letter + 1 - start, end),
            (_, Value::None) => return scan.fail_number(start),
        }
    }
    if scan.kind.is_none() {
        scan.skip_all();
    }
}

/// `CYCL DEF 247 … Q339=+1`: selects another preset.
fn preset(scan: &mut Line<'_>, start: usize, head: usize) -> BlockKind {
    scan.keyword(Keyword::Preset, start, head);
    let body = scan.slice(head, scan.extent.body_end);
    if let Some(name) = memchr::memmem::find(body, b"Q339") {
        let mut at = head + name + 4;
        while matches!(scan.byte(at), b' ' | b'\t') {
            at += 1;
        }
        if scan.byte(at) == b'=' {
            match value(scan, at + 1) {
                (from, Value::Number(number)) => {
                    scan.number_word(Address::P, WordForm::Number, from, 0, number);
                }
                (from, Value::Parameter(end)) => scan.expression(Address::P, from, 0, end),
                (_, Value::None) => {}
            }
        }
    }
    if scan.kind.is_none() {
        scan.skip_all();
    }
    BlockKind::Words
}
