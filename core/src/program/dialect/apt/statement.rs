//! The kind of a statement of cutter location text, from its major word.

use super::circle::circle;
use super::code::{is_harmless_code, is_harmless_number};
use super::cycle::cycle;
use super::line::{Upper, has_minor, is_one_of, minors, rest, said, starts, told_apart, word_end};
use super::point::{delta, feed, point, tool_axis};
use crate::program::dialect::line::Line;
use crate::program::dialect::number::{Spelling, number};
use crate::program::{Address, BlockKind, Keyword, WordForm};

/// Statements whose rest is text for the post-processor, dollar signs included.
pub(super) const TEXT: [&[u8]; 9] = [
    b"PPRINT",
    b"PARTNO",
    b"INSERT",
    b"REMARK",
    b"PPFUN",
    b"DISPLY",
    b"OPFEATSTART",
    b"OPFEATEND",
    b"TITLES",
];

/// Statements that move the points after them, or count them in another way.
const TRANSFORMATIONS: [&[u8]; 12] = [
    b"TRACUT", b"ROTATE", b"TRANS", b"COPY", b"MIRROR", b"INDEX", b"MODE", b"ORIGIN", b"MATRIX", b"SCALE",
    b"ZOFF", b"REFSYS",
];

/// Motions along surfaces that the processor has not computed.
const SURFACE_MOTIONS: [&[u8]; 8] =
    [b"GO", b"GOFWD", b"GOLFT", b"GORGT", b"GOBACK", b"GOUP", b"GODOWN", b"ARC"];
/// Statements that are motions in some systems, in a form that is not read.
const MAY_BE_MOTIONS: [&[u8]; 9] =
    [b"HELIX", b"SPLINE", b"BSPLINE", b"NURBS", b"MOVETO", b"MOVARC", b"CURVE", b"GOCONT", b"GOCLER"];
/// Statements that call or repeat other statements.
const CALLS: [&[u8]; 4] = [b"CALL", b"CALSUB", b"CALLSUB", b"SUBPRG"];

const FLOW: [&[u8]; 7] = [b"JUMPTO", b"IF", b"DO", b"LOOPST", b"LOOPND", b"MACRO", b"TERMAC"];

pub(super) fn read(scan: &mut Line<'_>) -> BlockKind {
    let start = scan.at;
    let end = word_end(scan, start);
    let major = scan.slice(start, end);
    scan.at = end;
    if major.is_empty() {
        scan.fail_unexpected(start);
        return BlockKind::Malformed;
    }
    if major.eq_ignore_ascii_case(b"GOTO") {
        return point(scan, Keyword::Goto, start);
    }
    if major.eq_ignore_ascii_case(b"INSERT") {
        let harmless = is_harmless_code(scan.slice(end, scan.extent.body_end));
        return said(scan, if harmless { Keyword::PostWord } else { Keyword::UnknownStatement }, start);
    }
    if is_one_of(major, &TEXT) {
        return said(scan, Keyword::PostWord, start);
    }
    if is_one_of(major, &TRANSFORMATIONS) {
        return said(scan, Keyword::PointsMoved, start);
    }
    if is_one_of(major, &CALLS) {
        return BlockKind::Call;
    }
    if is_one_of(major, &FLOW) {
        return BlockKind::Flow;
    }
    // `TLON,GOFWD/…`, `TLLFT,GORGT/…`: motions along surfaces.
    if is_one_of(major, &SURFACE_MOTIONS)
        || is_one_of(major, &MAY_BE_MOTIONS)
        || names_surface_motion(scan, end)
    {
        return said(scan, Keyword::SurfaceMotion, start);
    }
    let word = Upper::of(major);
    match word.as_bytes() {
        b"RAPID" => said(scan, Keyword::Rapid, start),
        b"FEDRAT" => feed(scan, start),
        b"FROM" => point(scan, Keyword::From, start),
        b"GODLTA" => delta(scan, start),
        b"GOHOME" => said(scan, Keyword::GoHome, start),
        b"CIRCLE" => circle(scan, start),
        b"CYCLE" => cycle(scan, start),
        b"CUTCOM" if is_of_length(scan, end) => said(scan, Keyword::PostWord, start),
        b"CUTCOM" => {
            let off = has_minor(scan, end, b"OFF");
            said(scan, if off { Keyword::R0 } else { Keyword::RadiusCompensation }, start)
        }
        b"MULTAX" => {
            let off = has_minor(scan, end, b"OFF");
            said(scan, if off { Keyword::MultaxOff } else { Keyword::MultaxOn }, start)
        }
        b"TLAXIS" => tool_axis(scan, start),
        b"UNITS" | b"UNIT" => units(scan, start),
        // A motion along the tool to a plane that other statements set, or blocks up to OPSKIP/OFF that the operator
        // may skip.
        b"RETRCT" | b"OPSKIP" => said(scan, Keyword::SurfaceMotion, start),
        b"PREFUN" => {
            let codes = || minors(scan, end).filter(|word| word.first().is_some_and(u8::is_ascii_digit));
            let harmless = codes().next().is_some() && codes().all(is_harmless_number);
            said(scan, if harmless { Keyword::PostWord } else { Keyword::UnknownStatement }, start)
        }
        b"CSYS" | b"MSYS" => told_apart(scan, Keyword::CoordinateSystem, start),
        b"CUTTER" => told_apart(scan, Keyword::Cutter, start),
        b"TRNTYP" => {
            let moves = |word: &[u8]| {
                number(word, 0, Spelling::Exponent).is_some_and(|number| number.value.abs() > 0.0)
            };
            let plain = has_minor(scan, end, b"WORLD") && !minors(scan, end).any(moves);
            said(scan, if plain { Keyword::WorldPoints } else { Keyword::PointsMoved }, start)
        }
        b"ROTABL" | b"ROTHED" => rotation(scan, start),
        // A pallet, a head, a fixture: what the points count from may be elsewhere.
        b"LOAD" if !names_tool(scan, end) => said(scan, Keyword::UnknownStatement, start),
        b"UNLOAD" if !names_tool(scan, end) && !is_of_number(scan, end) => {
            said(scan, Keyword::UnknownStatement, start)
        }
        b"LOADTL" | b"TOOLNO" | b"TURRET" | b"LOAD" | b"UNLOAD" => tool(scan, start),
        b"END" | b"FINI" => said(scan, Keyword::EndPgm, start),
        _ => said(scan, Keyword::PostWord, start),
    }
}

/// `TLON,GOFWD/`: a surface motion named before the slash.
fn names_surface_motion(scan: &Line<'_>, from: usize) -> bool {
    let rest = rest(scan, from);
    let head = rest.get(..memchr::memchr(b'/', rest).unwrap_or(rest.len())).unwrap_or_default();
    head.split(|byte| matches!(byte, b',' | b' ' | b'\t')).any(|word| is_one_of(word, &SURFACE_MOTIONS))
}

/// `UNITS/MM`, `UNITS/INCHES`
fn units(scan: &mut Line<'_>, start: usize) -> BlockKind {
    let unit = minors(scan, scan.at).next().unwrap_or_default();
    let keyword = if unit.eq_ignore_ascii_case(b"MM") || starts(unit, b"MILLI") {
        Keyword::BeginMm
    } else if starts(unit, b"INCH") || unit.eq_ignore_ascii_case(b"IN") {
        Keyword::BeginInch
    } else {
        scan.fail_unexpected(start);
        return BlockKind::Malformed;
    };
    said(scan, keyword, start)
}

/// Whether `CUTCOM/` is about the length of the tool alone: `CUTCOM/ON,LENGTH,7`.
fn is_of_length(scan: &Line<'_>, from: usize) -> bool {
    let is_of_length = |word: &[u8]| {
        is_one_of(word, &[b"LENGTH", b"ON", b"OFF", b"ADJUST"]) || word.iter().all(u8::is_ascii_digit)
    };
    has_minor(scan, from, b"LENGTH") && minors(scan, from).all(is_of_length)
}

/// Whether `LOAD/` and `UNLOAD/` name a tool.
fn names_tool(scan: &Line<'_>, from: usize) -> bool {
    minors(scan, from).next().is_some_and(|word| word.eq_ignore_ascii_case(b"TOOL"))
}

/// `UNLOAD/1`, `UNLOAD`: the tool goes out.
fn is_of_number(scan: &Line<'_>, from: usize) -> bool {
    minors(scan, from).next().is_none_or(|word| word.iter().all(u8::is_ascii_digit))
}

/// `LOADTL/5`, `LOAD/TOOL,5`: the tool's number as a T word. Only the first item is the number of the tool: a number
/// after a name may be one of anything.
fn tool(scan: &mut Line<'_>, start: usize) -> BlockKind {
    let (head, end) = (scan.at, scan.extent.body_end);
    scan.keyword(Keyword::ToolCall, start, end);
    let is_between = |byte: u8| matches!(byte, b',' | b'/' | b' ' | b'\t' | b'$' | b'\r' | b'\n');
    let after_blanks = |from: usize| (from..end).find(|at| !is_between(scan.byte(*at))).unwrap_or(end);
    let mut from = after_blanks(head);
    if scan.slice(from, from + 4).eq_ignore_ascii_case(b"TOOL") && is_between(scan.byte(from + 4)) {
        from = after_blanks(from + 4);
    }
    let body = scan.text.get(..end).unwrap_or_default();
    if scan.byte(from).is_ascii_digit()
        && let Some(number) = number(body, from, Spelling::Exponent)
        && (number.end >= end || is_between(scan.byte(number.end)))
    {
        scan.number_word(Address::T, WordForm::Number, from, 0, number);
    }
    scan.skip_all();
    BlockKind::Words
}

/// `ROTABL/ 1.570796,AAXIS,TABLE,CCLW`: an angle of zero is harmless; otherwise the points after it are turned.
fn rotation(scan: &mut Line<'_>, start: usize) -> BlockKind {
    let turns = minors(scan, scan.at).any(|word| {
        number(word, 0, Spelling::Exponent).is_none_or(|number| number.value.abs() > 0.0)
            && word.first().is_some_and(|byte| byte.is_ascii_digit() || matches!(byte, b'-' | b'+' | b'.'))
    });
    said(scan, if turns { Keyword::PointsMoved } else { Keyword::PostWord }, start)
}
