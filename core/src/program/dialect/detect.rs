//! The dialect of a text, found by unmistakable marks, and the line where the actual program starts.

use super::foreign::{ForeignDialect, Marks};
use super::line::Source;
use super::siemens::assigns_a_word;
use super::{Dialect, csv, iso, okuma};
use crate::program::line::is_blank;
use crate::program::{Address, Batch, BlockKind, WordForm};

/// The most lines that are examined.
pub(in crate::program) const MAX_LINES: usize = 200;
/// The most bytes that are examined.
pub(in crate::program) const MAX_BYTES: usize = 64 * 1024;

/// The facts from the beginning of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::program) struct Opening {
    pub(in crate::program) dialect: Dialect,
    /// Lines before the actual program.
    pub(in crate::program) banner_lines: u64,
    /// A dialect that the service does not read, and the line that shows it.
    pub(in crate::program) foreign: Option<(ForeignDialect, u64)>,
}

/// Examines the first whole lines of a text. `wanted` is accepted without a check.
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
    let has_banner = dialect.rules().has_banner && foreign.is_none();
    let banner_lines = if has_banner { banner_lines(text) } else { 0 };
    Opening { dialect, banner_lines, foreign }
}

/// The dialect that a text shows.
#[derive(Debug, Clone, Copy)]
enum Shown {
    Dialect(Dialect),
    /// A dialect that is not read, shown in this line.
    Foreign(ForeignDialect, u64),
}

/// The text up to its first line ending that has something before it.
fn first_line(text: &[u8]) -> &[u8] {
    lines(text).map(<[u8]>::trim_ascii).find(|line| !is_blank(line)).unwrap_or_default()
}

fn lines(text: &[u8]) -> impl Iterator<Item = &[u8]> {
    text.split(|&byte| byte == b'\n').take(MAX_LINES)
}

/// The dialect that the first unmistakable line shows. Without such a line it is OSP if a line selects a work offset
/// of OSP. It is Sinumerik if words have `=` after their letters and no line begins like an ISO program or a
/// template. Otherwise it is ISO.
fn marked(text: &[u8]) -> Shown {
    let is_other = |line: &[u8]| {
        let line = line.trim_ascii_start();
        matches!(line, [b'{' | b'(' | b'<', ..] | [b'O' | b'o', b'0'..=b'9' | b'<', ..])
    };
    let mut marks = Marks::default();
    for (number, line) in (1_usize..).zip(lines(text)) {
        if let Some(dialect) = mark(line) {
            let unread = (number..).zip(lines(text).skip(number - 1)).find_map(|(number, line)| {
                Some(Shown::Foreign((dialect.rules().unread_statement)(line.trim_ascii())?, number as u64))
            });
            return unread.unwrap_or(Shown::Dialect(dialect));
        }
        if let Some(dialect) = marks.see(line) {
            return Shown::Foreign(dialect, number as u64);
        }
    }
    if lines(text).any(okuma::selects_offset) {
        return Shown::Dialect(Dialect::Okuma);
    }
    let assigns = lines(text).any(assigns_a_word) && !lines(text).any(is_other);
    Shown::Dialect(if assigns { Dialect::Siemens } else { Dialect::Iso })
}

/// The dialect that a line shows.
fn mark(line: &[u8]) -> Option<Dialect> {
    let line = line.trim_ascii();
    Dialect::ALL.into_iter().find(|dialect| (dialect.rules().is_shown_by)(line))
}

/// Whether no name continues at this byte.
pub(super) fn ends_word(text: &[u8], at: usize) -> bool {
    text.get(at).is_none_or(|byte| !byte.is_ascii_alphanumeric() && *byte != b'_')
}

/// The line after its block number.
pub(super) fn without_number(line: &[u8]) -> &[u8] {
    match line {
        [b'N' | b'n', rest @ ..] if rest.first().is_some_and(u8::is_ascii_digit) => {
            let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
            rest.get(digits..).unwrap_or_default().trim_ascii_start()
        }
        _ => line,
    }
}

/// Whether a line begins with this mark, in upper or lower case.
pub(super) fn starts(line: &[u8], mark: &[u8]) -> bool {
    line.get(..mark.len()).is_some_and(|start| start.eq_ignore_ascii_case(mark))
}

/// The number of lines before the first `%`, or otherwise the first O number, if they do not look like blocks. They do
/// not if none of them has words and at least one cannot be read. A `%` at the program's end is not its beginning.
fn banner_lines(text: &[u8]) -> u64 {
    let mut batch = Batch::new();
    let mut at = 0;
    let mut o_number = None;
    for line in 1..=MAX_LINES as u64 {
        if at >= text.len() {
            break;
        }
        let source = Source { text, start: at, shift: 0, line, is_last: true };
        at = iso::read_line(source, &mut batch).next;
        let Some(block) = batch.blocks().last() else { break };
        if block.kind == BlockKind::Percent {
            let before_mark = banner_before(&batch, line);
            return if before_mark > 0 { before_mark } else { before_number(&batch, o_number) };
        }
        let names_program = batch
            .words(block)
            .first()
            .is_some_and(|word| word.address == Address::O && word.form == WordForm::Number);
        if names_program && o_number.is_none() {
            o_number = Some(line);
        }
    }
    before_number(&batch, o_number)
}

fn before_number(batch: &Batch, o_number: Option<u64>) -> u64 {
    o_number.map_or(0, |line| banner_before(batch, line))
}

fn banner_before(batch: &Batch, mark: u64) -> u64 {
    let mut before = batch.blocks().iter().take_while(|block| block.line < mark);
    let mut unreadable = false;
    let readable = before.any(|block| {
        // `Operator` is a word for people, but it would be the name of a program elsewhere.
        let is_name = matches!(batch.words(block), [word] if word.form == WordForm::Name);
        unreadable |= block.kind == BlockKind::Malformed || is_name;
        !is_name && !matches!(block.kind, BlockKind::Malformed | BlockKind::Blank | BlockKind::Comment)
    });
    if unreadable && !readable { mark - 1 } else { 0 }
}
