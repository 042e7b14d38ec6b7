//! The dialects: which texts are read, and how a line of each becomes words. Facts that hold for only one dialect are
//! in its folder. Its row of rules is in the folder's `mod.rs`.

mod apt;
mod csv;
pub(super) mod detect;
mod foreign;
pub(super) mod heidenhain;
pub(super) mod iso;
mod line;
mod number;
mod okuma;
mod plain;
mod rules;
pub(super) mod siemens;

pub use apt::CycleUnread;
pub use foreign::ForeignDialect;
pub(super) use line::Source;
pub(super) use rules::{Arithmetic, Read, StampAfter};
pub use rules::{DialectRules, Grammar, WritingOut};

use std::fmt;

use crate::listed::listed;

listed! {
    /// A dialect that is read and written.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Dialect {
        /// ISO 6983 G-code as written for Fanuc, Haas, Mori, Hurco and RS274/NGC controls.
        Iso,
        /// Sinumerik 840D.
        Siemens,
        /// Heidenhain conversational.
        Heidenhain,
        /// APT cutter location text (CLDATA).
        Apt,
        /// A table with a header row: X, Y, Z, two rotary letters and, optionally, F, U V W or nx ny nz.
        Csv,
        /// Okuma OSP for machining centres.
        Okuma,
    }
}

impl fmt::Display for Dialect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.rules().name)
    }
}

/// The result of reading a statement: where the next statement starts, and how many physical lines this one has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct LineRead {
    pub(super) next: usize,
    pub(super) lines: u64,
}

impl LineRead {
    /// A statement that ends with its line.
    pub(super) const fn one(next: usize) -> Self {
        Self { next, lines: 1 }
    }
}
