//! Programs as tables: a header row, then one linear motion in each row.

mod table;
mod write;

pub(super) use table::is_header;

use super::rules::{Arithmetic, DialectRules, Grammar, Read, WritingOut};
use crate::program::writer::Writing;

/// The rules of tables.
pub(super) const RULES: DialectRules = DialectRules {
    name: "csv",
    grammar: Grammar::Cells,
    looks_ahead: false,
    may_roll_over: false,
    // The header in the first line shows the dialect.
    is_shown_by: |_| false,
    unread_statement: |_| None,
    has_banner: false,
    read: Read::Lines(table::read_row),
    read_header: Some(table::read_header),
    states_feed_apart: false,
    arithmetic: Arithmetic::None,
    flow: None,
    plane: |_, _| None,
    file_end_returns: false,
    writing_out: WritingOut::PLAIN,
    file_endings: &[],
    stamp: None,
    writing: Writing {
        change: write::print_row,
        insert: write::print_row,
        has_rows: true,
        ..Writing::LETTERS
    },
};
