//! ISO 6983 G-code: blocks of letters and numbers, with the macros of Fanuc and RS274/NGC.

pub(in crate::program) mod constants;
mod flow;
mod line;
mod plane;
mod statement;
mod writing_out;

pub(in crate::program) use line::read_line;
pub(super) use line::{fail_exponent, read_plain_line};

use super::rules::{Arithmetic, DialectRules, Grammar, Read, StampAfter, StampForm};
use crate::program::writer::Writing;

/// The rules of ISO programs.
pub(super) const RULES: DialectRules = DialectRules {
    name: "iso",
    grammar: Grammar::Letters,
    looks_ahead: false,
    may_roll_over: true,
    // Template text. It is refused as such, whatever its final dialect will be.
    is_shown_by: |line| line.starts_with(b"{"),
    unread_statement: |_| None,
    has_banner: true,
    read: Read::Lines(read_line),
    read_header: None,
    states_feed_apart: false,
    arithmetic: Arithmetic::Rs274,
    flow: Some(flow::read),
    plane: plane::read,
    file_end_returns: false,
    writing_out: writing_out::RULES,
    file_endings: &[],
    stamp: Some(StampForm { after: StampAfter::TapeMarkAndName, comment: ["(", ")"], or_semicolons: true }),
    writing: Writing::LETTERS,
};
