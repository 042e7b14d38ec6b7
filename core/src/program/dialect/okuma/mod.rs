//! Okuma OSP for machining centres: blocks of letters and numbers as in ISO programs. Some codes have another meaning.
//!
//! Variables (`VC1=5`, `X=VC1`), functions and `IF` are not read. A program that has them is refused at the line that
//! has them.

mod detect;
mod line;

pub(super) use detect::{selects_offset, unread_statement};

use super::rules::{Arithmetic, DialectRules, Grammar, Read, StampAfter, StampForm, WritingOut};
use crate::program::writer::Writing;

/// The rules of OSP programs.
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
    flow: None,
    plane: |_, _| None,
    file_end_returns: false,
    writing_out: WritingOut::PLAIN,
    file_endings: &[],
    stamp: Some(StampForm { after: StampAfter::TapeMarkAndName, comment: ["(", ")"], or_semicolons: false }),
    writing: Writing::LETTERS,
};
