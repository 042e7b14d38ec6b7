//! Heidenhain conversational programs: one statement on each line, with or without block numbers. A `~` continues a
//! statement.

pub(in crate::program) mod constants;
mod cycle;
mod flow;
mod hole;
mod line;
mod path;
mod plane;
mod statement;
mod write;
mod writing_out;

use super::detect::starts;
use super::number::{self, Spelling};
use super::rules::{Arithmetic, DialectRules, Grammar, Read, StampAfter, StampForm};
use crate::program::writer::Writing;
use crate::program::{Address, Code};

/// The rules of conversational programs.
pub(super) const RULES: DialectRules = DialectRules {
    name: "heidenhain",
    grammar: Grammar::Conversational,
    looks_ahead: true,
    may_roll_over: false,
    is_shown_by,
    unread_statement: |_| None,
    has_banner: false,
    read: Read::Statements(line::read_line),
    read_header: None,
    states_feed_apart: false,
    arithmetic: Arithmetic::Heidenhain,
    flow: Some(flow::read),
    plane: plane::read,
    file_end_returns: false,
    writing_out: writing_out::RULES,
    file_endings: &[".h"],
    stamp: Some(StampForm {
        after: StampAfter::LineWith(b"BEGIN PGM"),
        comment: ["; ", ""],
        or_semicolons: false,
    }),
    writing: Writing {
        end_codes: &[&END_CODES],
        names: &[
            (Address::NX, b"NX"),
            (Address::NY, b"NY"),
            (Address::NZ, b"NZ"),
            (Address::TI, b"TX"),
            (Address::TJ, b"TY"),
            (Address::TK, b"TZ"),
        ],
        keeps_plus: true,
        any_address: true,
        feed_anchor: Some(write::feed_anchor),
        insert: write::insert_block,
        ..Writing::LETTERS
    },
};

/// M codes that act after the block's motion has ended.
const END_CODES: [Code; 17] = [
    Code::M(0),
    Code::M(10),
    Code::M(20),
    Code::M(50),
    Code::M(60),
    Code::M(90),
    Code::M(300),
    Code::M(890),
    Code::M(970),
    Code::M(990),
    Code::M(1110),
    Code::M(1170),
    Code::M(1270),
    Code::M(1290),
    Code::M(1370),
    Code::M(1450),
    Code::M(1490),
];

/// Statements that no other dialect has.
const STATEMENTS: [&[u8]; 5] = [b"BEGIN PGM", b"BLK FORM", b"CYCL DEF", b"TOOL CALL", b"TOOL DEF"];

/// Whether a line, without blanks at its ends, belongs to a conversational program and to no other dialect.
fn is_shown_by(line: &[u8]) -> bool {
    let digits = line.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let statement = line.get(digits..).unwrap_or_default().trim_ascii_start();
    STATEMENTS.iter().any(|mark| starts(statement, mark))
}

/// The number at `at`, with sign and decimal comma, and one after its end.
fn conversational_number(text: &[u8], at: usize) -> Option<(f64, usize)> {
    number::number(text, at, Spelling::Comma).map(|number| (number.value, number.end))
}
