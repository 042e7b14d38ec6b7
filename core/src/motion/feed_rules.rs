//! What F means: one row a dialect. The interpreter takes the modes from it, the time of a block what a speed counts
//! along, and the writer what must not come between a divided block and the F that it owes.

use super::{FeedMode, Interpolation};
use crate::program::{Address, Dialect, Keyword, Word};
use crate::units::MM_PER_INCH;

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
    /// G codes, in tenths, that say how F counts.
    g_modes: &'static [(u32, FeedMode)],
    /// M codes, in tenths, that do.
    m_modes: &'static [(u32, FeedMode)],
    /// Statement words that do, with the unit they count in \[mm\] where that is not the program's.
    words: &'static [(Keyword, FeedMode, Option<f64>)],
    /// G codes, in tenths, that change the unit of F, or may have it count otherwise.
    otherwise: &'static [u32],
}

const BY_MODE: FeedPaths = FeedPaths { machine: FeedPath::LinearAxes, tcp: FeedPath::Tip };

/// ISO programs. Controls that count millimetres and degrees of a block together are not told apart.
const ISO: FeedRules = FeedRules {
    paths: BY_MODE,
    form: FeedForm::Word,
    dwell_may_set_feed: true,
    g_modes: &[(930, FeedMode::InverseTime), (940, FeedMode::PerMinute), (950, FeedMode::PerRevolution)],
    m_modes: &[],
    words: &[],
    otherwise: &[200, 210, 700, 710, 960, 970],
};

/// Tables, with words as ISO programs have them.
const CSV: FeedRules = FeedRules { form: FeedForm::Cell, ..ISO };

/// 840D: the default of FGROUP are the geometry axes; under TRAORI they are the tip's.
const SIEMENS: FeedRules = FeedRules {
    paths: BY_MODE,
    form: FeedForm::Word,
    dwell_may_set_feed: false,
    g_modes: &[
        (930, FeedMode::InverseTime),
        (940, FeedMode::PerMinute),
        (9610, FeedMode::PerMinute),
        (9710, FeedMode::PerMinute),
        (950, FeedMode::PerRevolution),
        (960, FeedMode::PerRevolution),
        (970, FeedMode::PerRevolution),
        (9730, FeedMode::PerRevolution),
    ],
    m_modes: &[],
    words: &[],
    otherwise: &[700, 710, 7000, 7100],
};

/// TNC: there is no inverse time.
const HEIDENHAIN: FeedRules = FeedRules {
    paths: BY_MODE,
    form: FeedForm::Word,
    dwell_may_set_feed: true,
    g_modes: &[],
    m_modes: &[(1360, FeedMode::PerRevolution), (1370, FeedMode::PerMinute)],
    words: &[],
    otherwise: &[],
};

/// Cutter location data: its points are tips.
const APT: FeedRules = FeedRules {
    paths: FeedPaths { machine: FeedPath::Tip, tcp: FeedPath::Tip },
    form: FeedForm::Statement,
    dwell_may_set_feed: true,
    g_modes: &[],
    m_modes: &[],
    words: &[
        (Keyword::MmPerMinute, FeedMode::PerMinute, Some(1.0)),
        (Keyword::InchPerMinute, FeedMode::PerMinute, Some(MM_PER_INCH)),
        (Keyword::UnitPerMinute, FeedMode::PerMinute, None),
        (Keyword::MmPerRevolution, FeedMode::PerRevolution, Some(1.0)),
        (Keyword::InchPerRevolution, FeedMode::PerRevolution, Some(MM_PER_INCH)),
        (Keyword::UnitPerRevolution, FeedMode::PerRevolution, None),
    ],
    otherwise: &[],
};

impl FeedRules {
    /// The row of a dialect.
    #[must_use]
    #[inline]
    pub const fn of(dialect: Dialect) -> &'static Self {
        match dialect {
            Dialect::Iso => &ISO,
            Dialect::Csv => &CSV,
            Dialect::Siemens => &SIEMENS,
            Dialect::Heidenhain => &HEIDENHAIN,
            Dialect::Apt => &APT,
        }
    }

    /// How F counts behind this G code, if it says so.
    pub(super) fn g_mode(&self, tenths: u32) -> Option<FeedMode> {
        mode_of(self.g_modes, tenths)
    }

    /// The same for an M code.
    pub(super) fn m_mode(&self, tenths: u32) -> Option<FeedMode> {
        mode_of(self.m_modes, tenths)
    }

    /// The same for a statement word, with its unit.
    pub(super) fn word(&self, keyword: Keyword) -> Option<(FeedMode, Option<f64>)> {
        let found = self.words.iter().find(|(word, ..)| *word == keyword);
        found.map(|&(_, mode, mm_per_unit)| (mode, mm_per_unit))
    }

    /// Whether the word gives F another meaning, or may: another mode or unit, or a feed that stands elsewhere.
    #[must_use]
    pub fn is_changed_by(&self, word: &Word) -> bool {
        if let Some(keyword) = word.keyword() {
            return keyword == Keyword::FeedElsewhere || self.word(keyword).is_some();
        }
        let tenths = || word.code_tenths();
        match word.address {
            Address::G => {
                tenths().is_some_and(|code| self.g_mode(code).is_some() || self.otherwise.contains(&code))
            }
            Address::M => tenths().is_some_and(|code| self.m_mode(code).is_some()),
            _ => false,
        }
    }
}

fn mode_of(codes: &[(u32, FeedMode)], tenths: u32) -> Option<FeedMode> {
    codes.iter().find(|(code, _)| *code == tenths).map(|(_, mode)| *mode)
}
