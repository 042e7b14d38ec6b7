//! The meaning of F: a part of every dialect's row. The interpreter takes the modes from it, and the time of a block
//! takes the path of a speed. The writer takes the words that must not come between a divided block and the F word
//! that it owes.

use super::dialect::MotionRules;
use super::meaning::BlockMotion;
use super::{FeedMode, Interpolation};
use crate::program::{Code, Dialect, Keyword, Word};

/// The path along which an F counts if it is a speed. If that path has no length and only the rotary axes turn, all
/// dialects count degrees of the largest turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeedPath {
    /// X Y Z of the words. Rotary axes that turn in the same motion follow.
    LinearAxes,
    /// The tool tip in the workpiece.
    Tip,
}

/// The path along which a speed counts, by interpolation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FeedPaths {
    /// If the axes are interpolated.
    pub machine: FeedPath,
    /// With tool-centre-point control.
    pub tcp: FeedPath,
}

impl FeedPaths {
    /// The path along which a speed counts in this mode.
    #[must_use]
    pub fn of(self, mode: Interpolation) -> FeedPath {
        match mode {
            Interpolation::Machine => self.machine,
            Interpolation::Tcp => self.tcp,
        }
    }
}

/// How a feed is written in the text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FeedForm {
    /// A word of the block that moves, left out if the feed does not change.
    Word,
    /// A cell of every row.
    Cell,
    /// A separate statement before the motion.
    Statement,
}

/// The meaning of F in one dialect.
#[derive(Debug)]
pub struct FeedRules {
    /// The path along which a speed counts.
    pub paths: FeedPaths,
    /// How the feed is written.
    pub form: FeedForm,
    /// Whether F in a block with a dwell may be a feed that stays. In other dialects it is only a time.
    pub(super) dwell_may_set_feed: bool,
    /// Words of axes that may be the time of a dwell in its block. Another axis word beside a dwell may be a motion.
    pub(super) dwell_times: u32,
    /// Codes and statement words that state how F counts. The unit \[mm\] is given if F does not count in the
    /// program's unit.
    pub(super) modes: &'static [(Code, FeedMode, Option<f64>)],
    /// Codes that change the unit of F, or that may change how it counts.
    pub(super) otherwise: &'static [Code],
}

impl FeedRules {
    /// X Y Z of the words if the axes are interpolated, the tip if the tip is interpolated.
    pub(super) const BY_MODE: FeedPaths = FeedPaths { machine: FeedPath::LinearAxes, tcp: FeedPath::Tip };

    /// The row of a dialect.
    #[must_use]
    #[inline]
    pub const fn of(dialect: Dialect) -> &'static Self {
        &MotionRules::of(dialect).feed
    }

    /// What a word of this dialect says about the motion of its block, if it says anything.
    #[must_use]
    pub fn block_motion(dialect: Dialect, word: &Word) -> Option<BlockMotion> {
        word.code().and_then(|code| MotionRules::of(dialect).meaning(code).block_motion())
    }

    /// How F counts after this code and in which unit, if the code states it.
    pub(super) fn mode(&self, code: Code) -> Option<(FeedMode, Option<f64>)> {
        let found = self.modes.iter().find(|(known, ..)| *known == code);
        found.map(|&(_, mode, mm_per_unit)| (mode, mm_per_unit))
    }

    /// Whether the word changes or may change the meaning of F: another mode or unit, or a feed stated elsewhere.
    #[must_use]
    pub fn is_changed_by(&self, word: &Word) -> bool {
        word.code().is_some_and(|code| {
            code == Code::Keyword(Keyword::FeedElsewhere)
                || self.mode(code).is_some()
                || self.otherwise.contains(&code)
        })
    }
}
