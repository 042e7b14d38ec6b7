//! Okuma OSP for machining centres: blocks of letters and numbers as ISO has them, in which some codes mean something else.
//!
//! Variables (`VC1=5`, `X=VC1`), functions and `IF` are not read: a program with them is refused where they stand.

mod detect;
mod line;

pub(super) use detect::{has_marks, unread_statement};

use super::rules::{Arithmetic, DialectRules, Grammar, Read, StampAfter, StampForm};
use crate::program::writer::Writing;

/// What is true of OSP programs.
pub(super) const RULES: DialectRules = DialectRules {
    name: "okuma",
    grammar: Grammar::Letters,
    looks_ahead: false,
    may_roll_over: true,
    is_shown_by: detect::is_program_file,
    unread_statement,
    has_banner: true,
    read: Read::Lines(line::read_line),
    read_header: None,
    states_feed_apart: false,
    arithmetic: Arithmetic::None,
    stamp: Some(StampForm { after: StampAfter::TapeMarkAndName, comment: ["(", ")"], or_semicolons: false }),
    writing: Writing::LETTERS,
};
