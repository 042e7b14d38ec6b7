//! Which dialect a text is, by unmistakable marks, and where the program proper starts.

use super::foreign::{ForeignDialect, Marks};
use super::{Dialect, csv, iso};
use crate::program::line::is_blank;
use crate::program::{Address, Batch, BlockKind, WordForm};

/// Lines looked at.
pub(in crate::program) const MAX_LINES: usize = 200;
/// Bytes looked at.
pub(in crate::program) const MAX_BYTES: usize = 64 * 1024;

/// Words that open a Sinumerik statement and no ISO block.
const SIEMENS: [&[u8]; 31] = [
    b"RET",
    b"REPEAT",
    b"REPEATB",
    b"UNTIL",
    b"ENDFOR",
    b"ENDWHILE",
    b"ENDLOOP",
    b"TRAORI",
    b"TRAFOOF",
    b"SUPA",
    b"MCALL",
    b"DEF",
    b"PROC",
    b"CYCLE",
    b"WORKPIECE",
    b"GOTOF",
    b"GOTOB",
    b"EXTERN",
    b"ATRANS",
    b"AROT",
    b"TRANS",
    b"STOPRE",
    b"ORIWKS",
    b"ORIMKS",
    b"ORIAXES",
    b"ORIVECT",
    b"FFWON",
    b"COMPCAD",
    b"COMPON",
    b"SOFT",
    b"BRISK",
];
const HEIDENHAIN: [&[u8]; 5] = [b"BEGIN PGM", b"BLK FORM", b"CYCL DEF", b"TOOL CALL", b"TOOL DEF"];
const APT: [&[u8]; 11] = [
    b"PARTNO/", b"PARTNO ", b"GOTO/", b"CUTTER/", b"FEDRAT/", b"LOADTL/", b"LOAD/", b"TLAXIS/", b"SPINDL/",
    b"UNITS/", b"UNIT/",
];

/// What the beginning of a text tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::program) struct Opening {
    pub(in crate::program) dialect: Dialect,
    /// Lines before the program proper.
    pub(in crate::program) banner_lines: u64,
    /// A dialect that is not read, and the line that shows it.
    pub(in crate::program) foreign: Option<(ForeignDialect, u64)>,
}

/// Looks at the first whole lines of a text. `wanted` is taken without asking.
pub(in crate::program) fn opening(text: &[u8], wanted: Option<Dialect>) -> Opening {
    let shown = match wanted {
        Some(dialect) => Shown::Dialect(dialect),
        None if csv::is_header(first_line(text)) => Shown::Dialect(Dialect::Csv),
        None => marked(text),
    };
    let (dialect, foreign) = match shown {
        Shown::Dialect(dialect) => (dialect, None),
        Shown::Foreign(dialect, line) => (Dialect::Iso, Some((dialect, line))),
    };
    let banner_lines = if dialect == Dialect::Iso && foreign.is_none() { banner_lines(text) } else { 0 };
    Opening { dialect, banner_lines, foreign }
}

/// What a text shows.
#[derive(Debug, Clone, Copy)]
enum Shown {
    Dialect(Dialect),
    /// One that is not read, in this line.
    Foreign(ForeignDialect, u64),
}

/// The text up to its first line ending that has something before it.
fn first_line(text: &[u8]) -> &[u8] {
    lines(text).map(<[u8]>::trim_ascii).find(|line| !is_blank(line)).unwrap_or_default()
}

fn lines(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(|&byte| byte == b'\n').take(MAX_LINES)
}

/// The dialect that the first unmistakable line shows; without one, Sinumerik where words have `=` behind their
/// letters and no line begins like an ISO program or a template, else ISO.
fn marked(text: &[u8]) -> Shown {
    let is_other = |line: &[u8]| {
        let line = line.trim_ascii_start();
        matches!(line, [b'{' | b'(' | b'<', ..] | [b'O' | b'o', b'0'..=b'9' | b'<', ..])
    };
    let mut marks = Marks::default();
    for (number, line) in (1..).zip(lines(text)) {
        if let Some(dialect) = mark(line) {
            return Shown::Dialect(dialect);
        }
        if let Some(dialect) = marks.see(line) {
            return Shown::Foreign(dialect, number);
        }
    }
    let assigns = lines(text).any(assigns_a_word) && !lines(text).any(is_other);
    Shown::Dialect(if assigns { Dialect::Siemens } else { Dialect::Iso })
}

fn mark(line: &[u8]) -> Option<Dialect> {
    let line = line.trim_ascii();
    if line.starts_with(b"{") {
        // Template text: whatever it is to become, it is refused as such.
        return Some(Dialect::Iso);
    }
    if starts(line, b"%_N_") || starts(line, b";$PATH=") {
        return Some(Dialect::Siemens);
    }
    if APT.iter().any(|mark| starts(line, mark)) || is_statement_with_slash(line) {
        return Some(Dialect::Apt);
    }
    let without_number = line.trim_ascii_start();
    let digits = without_number.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let statement = without_number.get(digits..)?.trim_ascii_start();
    if HEIDENHAIN.iter().any(|mark| starts(statement, mark)) {
        return Some(Dialect::Heidenhain);
    }
    let statement = match line.split_first() {
        Some((b'N' | b'n', rest)) => {
            let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
            rest.get(digits..)?.trim_ascii_start()
        }
        _ => line,
    };
    let is_siemens = starts(statement, b"MSG(\"")
        || starts(statement, b"T=\"")
        || assigns_a_name(statement)
        || SIEMENS.iter().any(|word| {
            starts(statement, word)
                && statement
                    .get(word.len())
                    .is_none_or(|byte| matches!(byte, b' ' | b'\t' | b'(' | b'8' | b';'))
        });
    is_siemens.then_some(Dialect::Siemens)
}

/// `_X_HOME=-365.`, `_LIST[2]=1`: a name that begins with an underscore, which no other dialect has bare.
fn assigns_a_name(statement: &[u8]) -> bool {
    let Some(rest) = statement.strip_prefix(b"_") else { return false };
    let length = rest.iter().take_while(|byte| byte.is_ascii_alphanumeric() || **byte == b'_').count();
    let next = rest.get(length..).unwrap_or_default().trim_ascii_start();
    length > 0 && matches!(next, [b'=' | b'[', ..])
}

/// Addresses that have `=` behind them in Sinumerik programs only.
const ASSIGNED: [&[u8]; 18] = [
    b"X", b"Y", b"Z", b"A", b"B", b"C", b"I", b"J", b"K", b"F", b"A3", b"B3", b"C3", b"CR", b"AR", b"AP",
    b"RP", b"TURN",
];

/// Whether an axis word, a feed, a radius or an R parameter has `=` behind it: `X=IC(5)`, `CR=12.5`, `R1=2`.
fn assigns_a_word(statement: &[u8]) -> bool {
    let statement = statement.trim_ascii_start();
    let end = statement.iter().position(|byte| b"([{;\"#".contains(byte)).unwrap_or(statement.len());
    let statement = statement.get(..end).unwrap_or_default();
    memchr::memchr_iter(b'=', statement).any(|equals| {
        let before = statement.get(..equals).unwrap_or_default().trim_ascii_end();
        let length =
            before.iter().rev().take_while(|byte| byte.is_ascii_alphanumeric() || **byte == b'_').count();
        let name = before.get(before.len() - length..).unwrap_or_default();
        let is_parameter = matches!(name, [b'R' | b'r', digits @ ..] if !digits.is_empty()
            && digits.iter().all(u8::is_ascii_digit));
        is_parameter || ASSIGNED.iter().any(|known| name.eq_ignore_ascii_case(known))
    })
}

/// `GOTO / …`: an APT statement with blanks before its slash.
fn is_statement_with_slash(line: &[u8]) -> bool {
    let letters = line.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    let (word, rest) = line.split_at(letters);
    rest.trim_ascii_start().first() == Some(&b'/')
        && APT.iter().any(|mark| mark.strip_suffix(b"/").is_some_and(|mark| word.eq_ignore_ascii_case(mark)))
}

fn starts(line: &[u8], mark: &[u8]) -> bool {
    line.get(..mark.len()).is_some_and(|start| start.eq_ignore_ascii_case(mark))
}

/// How many lines stand before the first `%`, or else the first O number, if they do not look like blocks: none of
/// them has words, and one at least cannot be read.
fn banner_lines(text: &[u8]) -> u64 {
    let mut batch = Batch::new();
    let mut at = 0;
    let mut o_number = None;
    for line in 1..=MAX_LINES as u64 {
        if at >= text.len() {
            break;
        }
        at = iso::read_line(text, at, 0, line, &mut batch);
        let Some(block) = batch.blocks().last() else { break };
        if block.kind == BlockKind::Percent {
            return banner_before(&batch, line);
        }
        let names_program = batch
            .words(block)
            .first()
            .is_some_and(|word| word.address == Address::O && word.form == WordForm::Number);
        if names_program && o_number.is_none() {
            o_number = Some(line);
        }
    }
    o_number.map_or(0, |line| banner_before(&batch, line))
}

fn banner_before(batch: &Batch, mark: u64) -> u64 {
    let mut before = batch.blocks().iter().take_while(|block| block.line < mark);
    let mut unreadable = false;
    let readable = before.any(|block| {
        // `Operator` is a word for people, and would be the name of a program elsewhere.
        let is_name = matches!(batch.words(block), [word] if word.form == WordForm::Name);
        unreadable |= block.kind == BlockKind::Malformed || is_name;
        !is_name && !matches!(block.kind, BlockKind::Malformed | BlockKind::Blank | BlockKind::Comment)
    });
    if unreadable && !readable { mark - 1 } else { 0 }
}
