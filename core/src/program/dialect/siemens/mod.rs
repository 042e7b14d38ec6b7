//! Sinumerik 840D: blocks of words, statement words, assignments, calls.
//!
//! The plain case, letters with numbers, is one loop in `line`. Everything else is in `statement`. The table of
//! `names` states what the names of the control's language are.

pub(in crate::program) mod constants;
mod cycle;
mod detect;
mod flow;
mod line;
mod names;
mod plane;
mod statement;
mod writing_out;

pub(super) use detect::assigns_a_word;

use super::rules::{Arithmetic, DialectRules, Grammar, Read, StampAfter, StampForm};
use crate::program::writer::{END_CODES, Writing};
use crate::program::{Address, Code};

/// The rules of Sinumerik programs.
pub(super) const RULES: DialectRules = DialectRules {
    name: "siemens",
    grammar: Grammar::Assignments,
    looks_ahead: false,
    may_roll_over: false,
    is_shown_by: detect::is_shown_by,
    unread_statement: |_| None,
    has_banner: false,
    read: Read::Lines(line::read_line),
    read_header: None,
    states_feed_apart: false,
    arithmetic: Arithmetic::Siemens,
    flow: Some(flow::read),
    plane: plane::read,
    file_end_returns: true,
    writing_out: writing_out::RULES,
    file_endings: &[".spf", ".mpf", "_spf", "_mpf"],
    stamp: Some(StampForm {
        after: StampAfter::LinesThatBeginWith(&[b"%", b";$"]),
        comment: ["; ", ""],
        or_semicolons: false,
    }),
    writing: Writing {
        // M17 and RET: the end of a subprogram.
        end_codes: &[END_CODES, &[Code::M(170)]],
        names: &[(Address::TI, b"A3="), (Address::TJ, b"B3="), (Address::TK, b"C3=")],
        has_equals: true,
        any_address: true,
        ..Writing::LETTERS
    },
};
