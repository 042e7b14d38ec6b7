//! APT cutter location text (CLDATA): a major word, `/`, minor words and numbers separated by commas. A `$` at the end
//! of a line continues the statement on the next line, and `$$` begins a comment.
//!
//! A `GOTO/` has three values (tip), six (tip and tool axis) or nine (tip, tool axis, contact normal out of the part
//! toward the tool). Unknown words of post-processors are left unchanged, because they do not move the points.

mod circle;
mod code;
mod cycle;
mod line;
mod point;
mod statement;
mod write;

pub use cycle::CycleUnread;

use super::detect::starts;
use super::rules::{Arithmetic, DialectRules, Grammar, Read, StampAfter, StampForm, WritingOut};
use crate::program::writer::Writing;

/// The rules of cutter location data.
pub(super) const RULES: DialectRules = DialectRules {
    name: "apt",
    grammar: Grammar::Points,
    looks_ahead: true,
    may_roll_over: false,
    is_shown_by: |line| STATEMENTS.iter().any(|mark| starts(line, mark)) || is_statement_with_slash(line),
    unread_statement: |_| None,
    has_banner: false,
    read: Read::Statements(line::read_line),
    read_header: None,
    states_feed_apart: true,
    arithmetic: Arithmetic::None,
    flow: None,
    plane: |_, _| None,
    file_end_returns: false,
    writing_out: WritingOut::PLAIN,
    file_endings: &[],
    stamp: Some(StampForm {
        after: StampAfter::LinesThatBeginWith(&[b"PARTNO"]),
        comment: ["$$ ", ""],
        or_semicolons: false,
    }),
    writing: Writing {
        any_address: true,
        change: write::print_point,
        insert: write::insert_point,
        ..Writing::LETTERS
    },
};

/// Statements that no other dialect has.
const STATEMENTS: [&[u8]; 11] = [
    b"PARTNO/", b"PARTNO ", b"GOTO/", b"CUTTER/", b"FEDRAT/", b"LOADTL/", b"LOAD/", b"TLAXIS/", b"SPINDL/",
    b"UNITS/", b"UNIT/",
];

/// `GOTO / …`: an APT statement with blanks before its slash.
fn is_statement_with_slash(line: &[u8]) -> bool {
    let letters = line.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    let (word, rest) = line.split_at(letters);
    rest.trim_ascii_start().first() == Some(&b'/')
        && STATEMENTS
            .iter()
            .any(|mark| mark.strip_suffix(b"/").is_some_and(|mark| word.eq_ignore_ascii_case(mark)))
}
