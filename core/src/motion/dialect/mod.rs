//! What the texts of one dialect mean for motions, where others mean something else: one row a dialect, in its file.
//! Whoever follows a program looks the row up once.

mod apt;
mod csv;
mod heidenhain;
mod iso;
mod okuma;
mod siemens;

use super::meaning::{MFunction, Meaning};
use super::modal::{MotionMode, ToolLength};
use super::{FeedRules, WorkOffset};
use crate::program::{Code, Dialect, Keyword};

/// One row.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about dialects")]
pub(super) struct MotionRules {
    /// What F means.
    pub(super) feed: FeedRules,
    /// What the G code of so many tenths means.
    pub(super) g: fn(u32) -> Meaning,
    /// What the M code of so many tenths means.
    pub(super) m: fn(u32) -> MFunction,
    /// What a statement word means.
    pub(super) keyword: fn(Keyword) -> Meaning,
    /// The motion that holds at the start.
    pub(super) motion: Option<MotionMode>,
    /// The tool length that does, behind a call too.
    pub(super) tool_length: ToolLength,
    /// It counts in millimetres, and says so nowhere.
    pub(super) counts_in_mm: bool,
    /// A motion holds until another one is named; elsewhere every statement names its own.
    pub(super) motion_is_modal: bool,
    /// The statement word of a block that only moves.
    pub(super) plain_statement: Option<(Keyword, PlainStatement)>,
    /// Behind a call units, the sense of words and feeds are those of the program.
    pub(super) call_keeps_modes: bool,
    /// Sections of the text have labels, by which they are called.
    pub(super) has_sections: bool,
    /// It is a list of points of the tip with the tool's axis; circles have centres that are points, too, and cutters
    /// are described.
    pub(super) is_of_points: bool,
    /// Words that put another tool length in force.
    pub(super) tool_words: ToolWords,
    /// Controls may read a number without a decimal point in least increments.
    pub(super) counts_points: bool,
    /// U, V or W alone is an axis beside X Y Z, and Z may count otherwise behind it.
    pub(super) has_parallel_axes: bool,
    /// I J K are the tool's axis where the tool length group says so.
    pub(super) takes_ijk_as_vector: bool,
    /// Where two codes of one modal group stand in a block, controls differ in the one that holds.
    pub(super) two_codes_conflict: bool,
    /// The work offset in force where the program has named none; elsewhere nobody knows it.
    pub(super) first_offset: Option<WorkOffset>,
    /// How tools get into the spindle.
    pub(super) tools: ToolRules,
}

/// A statement that only moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PlainStatement {
    /// A straight line to the words of its block.
    Line,
    /// A point, reached as the statements before it say.
    Point,
}

/// Words that put another tool length in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ToolWords {
    /// None: statements and codes do.
    None,
    /// The number of a length by H.
    LengthByH,
    /// Another tool by T, another edge by D.
    EdgeByTAndD,
}

/// How tools get into the spindle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about dialects")]
pub(super) struct ToolRules {
    /// T may be the change itself, as long as no M6 came.
    pub(super) t_may_change: bool,
    /// D names an edge of the tool.
    pub(super) d_is_edge: bool,
    /// M61 says which tool is in the spindle.
    pub(super) m61_sets: bool,
    /// Where no M6 ever changed a tool, a second T may have.
    pub(super) second_t_changes: bool,
}

impl ToolRules {
    /// T makes a tool ready and M6 puts it in; so do statements that call a tool.
    pub(super) const CHANGED_BY_M6: Self =
        Self { t_may_change: false, d_is_edge: false, m61_sets: false, second_t_changes: false };
}

impl MotionRules {
    /// A row to change: no code means anything, and a motion holds until another one is named.
    const PLAIN: Self = Self {
        feed: iso::FEED,
        g: |_| Meaning::Unknown,
        m: |_| MFunction::Plain,
        keyword: |_| Meaning::Unknown,
        motion: None,
        tool_length: ToolLength::Plain,
        counts_in_mm: false,
        motion_is_modal: true,
        plain_statement: None,
        call_keeps_modes: false,
        has_sections: false,
        is_of_points: false,
        tool_words: ToolWords::None,
        counts_points: false,
        has_parallel_axes: false,
        takes_ijk_as_vector: false,
        two_codes_conflict: false,
        first_offset: None,
        tools: ToolRules::CHANGED_BY_M6,
    };

    /// The row of a dialect.
    #[inline]
    pub(super) const fn of(dialect: Dialect) -> &'static Self {
        match dialect {
            Dialect::Iso => &iso::RULES,
            Dialect::Siemens => &siemens::RULES,
            Dialect::Heidenhain => &heidenhain::RULES,
            Dialect::Apt => &apt::RULES,
            Dialect::Csv => &csv::RULES,
            Dialect::Okuma => &okuma::RULES,
        }
    }

    /// What a G code or a statement word means.
    pub(super) fn meaning(&self, code: Code) -> Meaning {
        match code {
            Code::G(tenths) => (self.g)(tenths),
            Code::Keyword(keyword) => (self.keyword)(keyword),
            Code::M(_) => Meaning::Unknown,
        }
    }

    /// What an M code means.
    pub(super) fn m_function(&self, code: Code) -> MFunction {
        match code {
            Code::M(tenths) => (self.m)(tenths),
            Code::G(_) | Code::Keyword(_) => MFunction::Plain,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_dialect_has_a_row_of_meanings_of_its_own() {
        for dialect in Dialect::ALL {
            let rules = MotionRules::of(dialect);
            let others = Dialect::ALL.into_iter().filter(|other| *other != dialect);
            for other in others {
                assert!(!std::ptr::eq(rules, MotionRules::of(other)), "{dialect} and {other} share a row");
            }
            let moves = rules.motion.is_some()
                || rules.plain_statement.is_some()
                || matches!(rules.meaning(Code::G(10)), Meaning::Motion(MotionMode::Linear));
            assert!(moves, "nothing moves in {dialect}");
        }
    }
}
