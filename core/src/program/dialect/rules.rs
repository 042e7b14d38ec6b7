//! What is true of one dialect and not of others, as data: one row a dialect. Whoever reads, writes or stamps a text looks
//! the row up, and asks nowhere which dialect it is.
//!
//! What codes mean on a machine is the row of `motion::dialect`.

use super::line::Source;
use super::{Dialect, ForeignDialect, LineRead};
use crate::program::writer::Writing;
use crate::program::{Address, Batch, ReadFault};

/// How the plain lines of a program are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grammar {
    /// `N12 X1.5 A-30`: letters and numbers.
    Letters,
    /// `N12 X1.5 A=-30`: the same, with `=` where it is wanted.
    Assignments,
    /// `12 L X+1.5 A-30`
    Conversational,
    /// `GOTO/1.5,2,3,0.,0.,1.`
    Points,
    /// `1.5,2,3,-30,0`: a row of a table.
    Cells,
}

/// How the text becomes blocks: reads what begins on a line and adds its block to the batch.
#[derive(Debug, Clone, Copy)]
pub(in crate::program) enum Read {
    /// Every line by itself.
    Lines(fn(Source<'_>, &mut Batch) -> LineRead),
    /// Statements that run on; `None` where lines that belong to one are not there yet.
    Statements(fn(Source<'_>, &mut Batch) -> Option<LineRead>),
}

/// Reads the header of a table on this line: its columns, and what stands between them.
pub(in crate::program) type ReadHeader = fn(&[u8], u64) -> Result<(Vec<Address>, u8), ReadFault>;

/// How the parameters and expressions of a program are worked out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::program) enum Arithmetic {
    /// There are none.
    None,
    /// `#1`, `#<name>`, `[#1+2]`
    Rs274,
    /// `R1`, `DEF REAL`, `X=R1+2`
    Siemens,
    /// `Q1`, `FN 0:`
    Heidenhain,
}

/// Where the stamp of a program stands, and the comment that it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::program) struct StampForm {
    pub(in crate::program) after: StampAfter,
    /// What opens and closes a comment.
    pub(in crate::program) comment: [&'static str; 2],
    /// What does where the program has comments of this kind alone: `;`.
    pub(in crate::program) or_semicolons: bool,
}

/// Lines of a head that a stamp stands after.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::program) enum StampAfter {
    /// A listing's banner, the tape mark and the program's name.
    TapeMarkAndName,
    /// The first lines that all begin with one of these.
    LinesThatBeginWith(&'static [&'static [u8]]),
    /// The first line with this text.
    LineWith(&'static [u8]),
}

/// One row.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about dialects")]
pub struct DialectRules {
    /// How callers name the dialect.
    pub name: &'static str,
    /// How its plain lines are written.
    pub grammar: Grammar,
    /// A statement may mean something else by what stands after it: it is read when the next one is there.
    pub looks_ahead: bool,
    /// On some controls a rotary axis without an end goes the shorter way, whichever way its words say.
    pub may_roll_over: bool,
    /// Whether this line shows that a text is of this dialect and of no other one that is read.
    pub(in crate::program) is_shown_by: fn(&[u8]) -> bool,
    /// A dialect, or a part of this one, that such a line shows and that is not read.
    pub(in crate::program) unread_statement: fn(&[u8]) -> Option<ForeignDialect>,
    /// A listing's lines for people may stand before its program proper.
    pub(in crate::program) has_banner: bool,
    pub(in crate::program) read: Read,
    /// Of a table.
    pub(in crate::program) read_header: Option<ReadHeader>,
    /// A feed is a statement of its own, and how the last one was written is remembered.
    pub(in crate::program) states_feed_apart: bool,
    pub(in crate::program) arithmetic: Arithmetic,
    pub(in crate::program) stamp: Option<StampForm>,
    pub(in crate::program) writing: Writing,
}

impl Dialect {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Iso, Self::Siemens, Self::Heidenhain, Self::Apt, Self::Csv, Self::Okuma];

    /// Its row.
    #[must_use]
    #[inline]
    pub const fn rules(self) -> &'static DialectRules {
        match self {
            Self::Iso => &super::iso::RULES,
            Self::Siemens => &super::siemens::RULES,
            Self::Heidenhain => &super::heidenhain::RULES,
            Self::Apt => &super::apt::RULES,
            Self::Csv => &super::csv::RULES,
            Self::Okuma => &super::okuma::RULES,
        }
    }

    /// The dialect that callers name so.
    #[must_use]
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|dialect| dialect.rules().name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dialect_has_a_row_of_its_own() {
        for (index, dialect) in Dialect::ALL.into_iter().enumerate() {
            assert_eq!(dialect as usize, index, "{dialect} stands in `ALL` where the enum has it");
            assert_eq!(Dialect::of_name(dialect.rules().name), Some(dialect));
            assert_eq!(dialect.to_string(), dialect.rules().name);
            let others = Dialect::ALL.into_iter().filter(|other| *other != dialect);
            for other in others {
                assert!(!std::ptr::eq(dialect.rules(), other.rules()), "{dialect} and {other} share a row");
            }
        }
        assert_eq!(Dialect::ALL.len(), Dialect::ALL[Dialect::ALL.len() - 1] as usize + 1);
    }
}
