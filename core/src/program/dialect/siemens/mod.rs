//! Sinumerik 840D: blocks of words, statement words, assignments, calls.
//!
//! The plain case, letters with numbers, is one loop in `line`; everything else is in `statement`, and what the names
//! of the control's language are is the table of `names`.

mod line;
mod names;
mod statement;

pub(in crate::program) use line::read_line;
