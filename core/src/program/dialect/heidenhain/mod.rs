//! Heidenhain conversational programs: a statement a line, block numbers or none, `~` where a statement runs on.

pub(in crate::program) mod constants;
mod cycle;
mod line;
mod path;
mod statement;
mod write;

use super::detect::starts;
use super::number::{self, Spelling};
use super::rules::{Arithmetic, DialectRules, Grammar, Read, StampAfter, StampForm};
use crate::program::writer::Writing;
use crate::program::{Address, Code};

/// What is true of conversational programs.
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

/// M codes that act when the block's motion is done.
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

/// Statements of no other dialect.
const STATEMENTS: [&[u8]; 5] = [b"BEGIN PGM", b"BLK FORM", b"CYCL DEF", b"TOOL CALL", b"TOOL DEF"];

/// Whether a line, with no blanks at its ends, is one of a conversational program and of no other.
fn is_shown_by(line: &[u8]) -> bool {
    let digits = line.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let statement = line.get(digits..).unwrap_or_default().trim_ascii_start();
    STATEMENTS.iter().any(|mark| starts(statement, mark))
}

/// The number at `at`, with sign and decimal comma, and one past its end.
fn conversational_number(text: &[u8], at: usize) -> Option<(f64, usize)> {
    number::number(text, at, Spelling::Comma).map(|number| (number.value, number.end))
}
