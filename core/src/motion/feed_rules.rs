//! What F means: a part of the row of every dialect. The interpreter takes the modes from it, the time of a block what a speed counts
//! along, and the writer what must not come between a divided block and the F that it owes.

use super::dialect::MotionRules;
use super::{FeedMode, Interpolation};
use crate::program::{Code, Dialect, Keyword, Word};

/// What an F that is a speed counts along. Where that rests, and the rotary axes turn alone, all dialects count degrees
/// of the largest turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeedPath {
    /// X Y Z of the words; rotary axes that turn beside them come along.
    LinearAxes,
    /// The tool tip in the workpiece.
    Tip,
}

/// What a speed counts along, by who interpolates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FeedPaths {
    /// Where the axes are interpolated.
    pub machine: FeedPath,
    /// Under tool-centre-point control.
    pub tcp: FeedPath,
}

impl FeedPaths {
    /// What a speed counts along in this mode.
    #[must_use]
    pub fn of(self, mode: Interpolation) -> FeedPath {
        match mode {
            Interpolation::Machine => self.machine,
            Interpolation::Tcp => self.tcp,
        }
    }
}

/// How a feed stands in the text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeedForm {
    /// A word of the block that moves; left out where it does not change.
    Word,
    /// A cell of every row.
    Cell,
    /// A statement of its own before the motion.
    Statement,
}

/// What F means in one dialect.
#[derive(Debug)]
pub struct FeedRules {
    /// What a speed counts along.
    pub paths: FeedPaths,
    /// How it is written.
    pub form: FeedForm,
    /// Whether F beside a dwell may be a feed that stays; elsewhere it is a time and nothing else.
    pub(super) dwell_may_set_feed: bool,
    /// Codes and statement words that say how F counts, with the unit they count in \[mm\] where that is not the program's.
    pub(super) modes: &'static [(Code, FeedMode, Option<f64>)],
    /// Codes that change the unit of F, or may have it count otherwise.
    pub(super) otherwise: &'static [Code],
}

impl FeedRules {
    /// X Y Z of the words where the axes are interpolated, the tip where it is.
    pub(super) const BY_MODE: FeedPaths = FeedPaths { machine: FeedPath::LinearAxes, tcp: FeedPath::Tip };

    /// The row of a dialect.
    #[must_use]
    #[inline]
    pub const fn of(dialect: Dialect) -> &'static Self {
        &MotionRules::of(dialect).feed
    }

    /// How F counts behind this code, if it says so, and its unit.
    pub(super) fn mode(&self, code: Code) -> Option<(FeedMode, Option<f64>)> {
        let found = self.modes.iter().find(|(known, ..)| *known == code);
        found.map(|&(_, mode, mm_per_unit)| (mode, mm_per_unit))
    }

    /// Whether the word gives F another meaning, or may: another mode or unit, or a feed that stands elsewhere.
    #[must_use]
    pub fn is_changed_by(&self, word: &Word) -> bool {
        word.code().is_some_and(|code| {
            code == Code::Keyword(Keyword::FeedElsewhere)
                || self.mode(code).is_some()
                || self.otherwise.contains(&code)
        })
    }
}
