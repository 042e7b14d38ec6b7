//! The meaning of a dialect's texts for motions, where dialects differ: one row for each dialect, in the dialect's
//! file. The code that follows a program looks the row up once.

mod apt;
mod csv;
mod heidenhain;
mod iso;
mod okuma;
mod siemens;

use super::cycle::{HoleRules, Stroke};
use super::meaning::{MFunction, Meaning};
use super::modal::{MotionMode, ToolLength};
use super::{FeedRules, WorkOffset};
use crate::program::{Code, Dialect, Keyword};

/// The row of one dialect.
#[derive(Debug)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about dialects")]
pub(super) struct MotionRules {
    /// The meaning of F.
    pub(super) feed: FeedRules,
    /// The meaning of a G code in tenths.
    pub(super) g: fn(u32) -> Meaning,
    /// The meaning of an M code in tenths.
    pub(super) m: fn(u32) -> MFunction,
    /// How a canned cycle drills, by its code; `None` for a code that is no cycle. A dialect without this has no canned
    /// cycle that is followed.
    pub(super) cycles: Option<fn(Code) -> Option<Stroke>>,
    /// How cycles that state all parameters of a hole make it; `None` if the dialect has no such cycle that is followed.
    pub(super) holes: Option<HoleRules>,
    /// The meaning of a statement word.
    pub(super) keyword: fn(Keyword) -> Meaning,
    /// The motion that holds at the start.
    pub(super) motion: Option<MotionMode>,
    /// The tool length that holds at the start, and also after a call.
    pub(super) tool_length: ToolLength,
    /// The dialect counts in millimetres, and its text does not say so.
    pub(super) counts_in_mm: bool,
    /// A motion holds until another motion is named. In other dialects every statement names its own motion.
    pub(super) motion_is_modal: bool,
    /// The statement word of a block that only moves.
    pub(super) plain_statement: Option<(Keyword, PlainStatement)>,
    /// After a call, units, the sense of words and feeds are those of the program.
    pub(super) call_keeps_modes: bool,
    /// Sections of the text have labels, and a program calls them by these labels.
    pub(super) has_sections: bool,
    /// The program is a list of points of the tip with the tool's axis. Circles have centres that are also points, and
    /// the text describes cutters.
    pub(super) is_of_points: bool,
    /// Words that put another tool length in force.
    pub(super) tool_words: ToolWords,
    /// Controls may read a number without a decimal point in least increments.
    pub(super) counts_points: bool,
    /// U, V or W alone is an axis parallel to X, Y or Z, and Z may count in another way after it.
    pub(super) has_parallel_axes: bool,
    /// I J K are the tool's axis if the tool length group says so.
    pub(super) takes_ijk_as_vector: bool,
    /// If a block has two codes of one modal group, controls differ in which code holds.
    pub(super) two_codes_conflict: bool,
    /// The work offset in force while the program has named none. In other dialects it is not known.
    pub(super) first_offset: Option<WorkOffset>,
    /// How a program puts tools into the spindle.
    pub(super) tools: ToolRules,
    /// Controls of RS274/NGC run its programs.
    pub(super) has_rs274_codes: bool,
    /// G28 and G30 go through the point of their words.
    pub(super) reference_passes_point: bool,
    /// E is the place of an extruder. Elsewhere it is a tolerance, a time or an angle of the spindle.
    pub(super) has_extruder: bool,
    /// After a call or a code that is not known, no code states again everything that it may have changed. All motions
    /// after it are left unchanged.
    pub(super) unknown_is_final: bool,
}

/// A statement that only moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PlainStatement {
    /// A straight line to the words of its block.
    Line,
    /// A point, reached as the statements before it state.
    Point,
}

/// Words that put another tool length in force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ToolWords {
    /// No words: statements and codes put a length in force.
    None,
    /// H with the number of a length.
    LengthByH,
    /// T with another tool, D with another edge.
    EdgeByTAndD,
}

/// How a program puts tools into the spindle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about dialects")]
pub(super) struct ToolRules {
    /// T may itself be the change as long as the program has had no M6.
    pub(super) t_may_change: bool,
    /// D names an edge of the tool.
    pub(super) d_is_edge: bool,
    /// M61 states which tool is in the spindle.
    pub(super) m61_sets: bool,
    /// If no M6 ever changed a tool, a second T may have changed it.
    pub(super) second_t_changes: bool,
}

impl ToolRules {
    /// T makes a tool ready and M6 puts it into the spindle. Statements that call a tool also do so.
    pub(super) const CHANGED_BY_M6: Self =
        Self { t_may_change: false, d_is_edge: false, m61_sets: false, second_t_changes: false };
}

impl MotionRules {
    /// A row to start from: no code has a meaning, and a motion holds until another motion is named.
    const PLAIN: Self = Self {
        feed: iso::FEED,
        g: |_| Meaning::Unknown,
        m: |_| MFunction::Plain,
        cycles: None,
        holes: None,
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
        has_rs274_codes: false,
        reference_passes_point: false,
        has_extruder: true,
        unknown_is_final: false,
    };

    /// Whether it is stated that a tool length is in force.
    pub(super) fn has_length(&self, modal: &super::modal::Modal) -> bool {
        match self.tool_words {
            ToolWords::LengthByH => modal.length_number.is_some_and(|number| number > 0.0),
            ToolWords::EdgeByTAndD => modal.edge.is_none_or(|edge| edge > 0.0),
            ToolWords::None => true,
        }
    }

    /// Whether it is stated that no tool length is in force.
    pub(super) fn has_no_length(&self, modal: &super::modal::Modal) -> bool {
        match self.tool_words {
            ToolWords::LengthByH => modal.has_no_length || modal.length_number == Some(0.0),
            ToolWords::EdgeByTAndD => modal.edge == Some(0.0),
            ToolWords::None => false,
        }
    }

    /// Whether it is certain which tool length is in force: the text states it, or the tool call puts it in force.
    pub(super) fn has_stated_length(&self, modal: &super::modal::Modal) -> bool {
        match self.tool_words {
            // The codes of lengths are many, and some count apart from the tool's own.
            ToolWords::LengthByH => false,
            ToolWords::EdgeByTAndD => modal.edge.is_some_and(|edge| edge > 0.0),
            ToolWords::None => true,
        }
    }

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

    /// The meaning of a G code or a statement word.
    pub(super) fn meaning(&self, code: Code) -> Meaning {
        match code {
            Code::G(tenths) => (self.g)(tenths),
            Code::Keyword(keyword) => (self.keyword)(keyword),
            Code::M(_) => Meaning::Unknown,
        }
    }

    /// The meaning of an M code.
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
