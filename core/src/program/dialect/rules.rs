//! The facts in which one dialect differs from others, as data: one row for each dialect. The code that reads, writes
//! or stamps a text looks the row up. It never asks which dialect the text has.
//!
//! The row of `motion::dialect` states what codes mean on a machine.

use super::line::Source;
use super::{Dialect, ForeignDialect, LineRead};
use crate::program::course::Statement;
use crate::program::plane::PlaneStatement;
use crate::program::writer::Writing;
use crate::program::{Address, Batch, Block, OwnNames, ReadFault};

/// The notation of a program's plain lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grammar {
    /// `N12 X1.5 A-30`: letters and numbers.
    Letters,
    /// `N12 X1.5 A=-30`: the same, with `=` where it is needed.
    Assignments,
    /// `12 L X+1.5 A-30`
    Conversational,
    /// `GOTO/1.5,2,3,0.,0.,1.`
    Points,
    /// `1.5,2,3,-30,0`: a row of a table.
    Cells,
}

/// How the text becomes blocks: reads the statement that begins on a line and adds its block to the batch.
#[derive(Debug, Clone, Copy)]
pub(in crate::program) enum Read {
    /// Every line separately.
    Lines(fn(Source<'_>, &mut Batch) -> LineRead),
    /// Statements of several lines; `None` if lines of the statement have not arrived yet.
    Statements(fn(Source<'_>, &mut Batch) -> Option<LineRead>),
}

/// What a block does to the course of its program.
pub(in crate::program) type ReadFlow = fn(&Batch, &Block) -> Statement;

/// The tilted plane that a block defines, if it is one that is understood.
pub(in crate::program) type ReadPlane = fn(&Batch, &Block) -> Option<PlaneStatement>;

/// Reads the header of a table on this line: its columns and their separator.
pub(in crate::program) type ReadHeader = fn(&[u8], u64) -> Result<(Vec<Address>, u8), ReadFault>;

/// How the parameters and expressions of a program are computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::program) enum Arithmetic {
    /// The dialect has none.
    None,
    /// `#1`, `#<name>`, `[#1+2]`
    Rs274,
    /// `R1`, `DEF REAL`, `X=R1+2`
    Siemens,
    /// `Q1`, `FN 0:`
    Heidenhain,
}

/// The place of a program's stamp, and the form of its comment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::program) struct StampForm {
    pub(in crate::program) after: StampAfter,
    /// The beginning and the end of a comment.
    pub(in crate::program) comment: [&'static str; 2],
    /// Comments with `;` are used if the program has only comments of this kind.
    pub(in crate::program) or_semicolons: bool,
}

/// The lines of a head after which the stamp comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::program) enum StampAfter {
    /// A listing's banner, the tape mark and the program's name.
    TapeMarkAndName,
    /// The first lines, as long as each begins with one of these texts.
    LinesThatBeginWith(&'static [&'static [u8]]),
    /// The first line with this text.
    LineWith(&'static [u8]),
}

/// How loops and calls of a dialect are written out as one text.
#[derive(Debug)]
pub struct WritingOut {
    /// Whether a block names a parameter or a variable of the program, or a value of the control.
    pub names_value: fn(&[u8], &OwnNames) -> bool,
    /// Whether nothing but programs uses what an assignment sets.
    pub is_own: fn(&[u8], &OwnNames) -> bool,
    /// What a block has that defines a cycle, if cycles use parameters of the program.
    pub cycle: Option<&'static [u8]>,
    /// Places have a sign also if they are positive.
    pub places_have_signs: bool,
    /// A whole feed keeps its decimal point.
    pub feed_keeps_point: bool,
}

impl WritingOut {
    /// A row to start from: no value is named, and no assignment is left out.
    pub(in crate::program) const PLAIN: Self = Self {
        names_value: |_, _| false,
        is_own: |_, _| false,
        cycle: None,
        places_have_signs: false,
        feed_keeps_point: false,
    };
}

/// A block up to the first of these bytes.
pub(in crate::program) fn without_comment<'a>(text: &'a [u8], marks: &[u8]) -> &'a [u8] {
    let end = text.iter().position(|byte| marks.contains(byte)).unwrap_or(text.len());
    text.get(..end).unwrap_or_default()
}

/// The row of one dialect.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about dialects")]
pub struct DialectRules {
    /// The name by which callers select the dialect.
    pub name: &'static str,
    /// The notation of its plain lines.
    pub grammar: Grammar,
    /// The meaning of a statement may depend on the text after it. It is read when the next statement has arrived.
    pub looks_ahead: bool,
    /// On some controls a rotary axis without end stops takes the shorter way, whatever its words say.
    pub may_roll_over: bool,
    /// Whether this line shows that a text has this dialect and no other dialect that is read.
    pub(in crate::program) is_shown_by: fn(&[u8]) -> bool,
    /// A dialect, or a part of this dialect, that such a line shows and that is not read.
    pub(in crate::program) unread_statement: fn(&[u8]) -> Option<ForeignDialect>,
    /// A listing's lines for people may come before the actual program.
    pub(in crate::program) has_banner: bool,
    pub(in crate::program) read: Read,
    /// For a table only.
    pub(in crate::program) read_header: Option<ReadHeader>,
    /// A feed is a separate statement, and the style of the last one is remembered.
    pub(in crate::program) states_feed_apart: bool,
    pub(in crate::program) arithmetic: Arithmetic,
    /// How its loops, jumps and calls are spelled; `None` if they are not followed.
    pub(in crate::program) flow: Option<ReadFlow>,
    /// How its tilted planes are spelled.
    pub(in crate::program) plane: ReadPlane,
    /// At its end a called file returns to its caller. In other dialects a statement has to return.
    pub(in crate::program) file_end_returns: bool,
    /// How its loops and calls are written out.
    pub writing_out: WritingOut,
    /// How the names of its files end, in lower case, if that shows the dialect.
    pub(in crate::program) file_endings: &'static [&'static str],
    pub(in crate::program) stamp: Option<StampForm>,
    pub(in crate::program) writing: Writing,
}

impl DialectRules {
    /// How its tilted planes are read.
    #[must_use]
    pub fn plane(&self) -> fn(&Batch, &Block) -> Option<PlaneStatement> {
        self.plane
    }

    /// Whether loops, jumps and calls of programs in this dialect can be followed.
    #[must_use]
    pub const fn follows_flow(&self) -> bool {
        self.flow.is_some()
    }
}

impl Dialect {
    /// The row of this dialect.
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

    /// The dialect that the name of a file shows.
    #[must_use]
    pub fn of_file(name: &str) -> Option<Self> {
        let name = name.to_ascii_lowercase();
        let ends = |dialect: &Self| dialect.rules().file_endings.iter().any(|ending| name.ends_with(ending));
        Self::ALL.into_iter().find(ends)
    }

    /// The dialect that callers select by this name.
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
        for dialect in Dialect::ALL {
            assert_eq!(Dialect::of_name(dialect.rules().name), Some(dialect));
            assert_eq!(dialect.to_string(), dialect.rules().name);
            let others = Dialect::ALL.into_iter().filter(|other| *other != dialect);
            for other in others {
                assert!(!std::ptr::eq(dialect.rules(), other.rules()), "{dialect} and {other} share a row");
            }
        }
    }
}
