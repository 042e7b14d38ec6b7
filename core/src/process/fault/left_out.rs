//! Why motions are neither simulated nor cut.

use crate::motion::Unfollowable;
use crate::process::arc_path::UnknownArc;

/// Why a motion is not simulated, or not cut. Rapids of a simulation are not counted: no part is cut with them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LeftOutReason {
    /// It cannot be followed.
    NotFollowed(Unfollowable),
    /// Another work offset than at the program's first complete point.
    WorkOffsetChanged,
    /// An arc, in a simulation: how the control runs it along is not known.
    Arc,
    /// An arc whose course is not known.
    UnknownArc(UnknownArc),
    /// Start or end of an axis is not known.
    PositionUnknown,
    /// No feed is known, or it is per spindle turn.
    NoFeed,
    /// A tool is in the spindle that was not asked for, or of which nothing is known.
    OtherTool,
}

impl LeftOutReason {
    /// The name in the report.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NotFollowed(_) => "not_followed",
            Self::WorkOffsetChanged => "work_offset_changed",
            Self::Arc | Self::UnknownArc(_) => "arc",
            Self::PositionUnknown => "position_unknown",
            Self::NoFeed => "no_feed",
            Self::OtherTool => "other_tool",
        }
    }

    /// What it means.
    #[must_use]
    pub fn text(self) -> String {
        match self {
            Self::NotFollowed(reason) => format!("a motion that cannot be followed: {reason}"),
            Self::WorkOffsetChanged => "a motion under another work offset than the first".to_owned(),
            Self::Arc => "an arc: its course is the control's".to_owned(),
            Self::UnknownArc(why) => format!("an arc whose course is not known: {why}"),
            Self::PositionUnknown => "an axis whose position is not known".to_owned(),
            Self::OtherTool => "a tool is in the spindle that `tool_number` does not name, or that neither the request nor the machine's tool table tells".to_owned(),
            Self::NoFeed => "no feed is known, or it is per spindle turn: give feed_mm_per_min".to_owned(),
        }
    }
}

/// Motions that were not simulated, or not cut, for one reason.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOut {
    /// Why; of several reasons of one name the first met.
    pub reason: LeftOutReason,
    /// How many.
    pub count: u64,
    /// The first line of the upload.
    pub first_line: u64,
}

/// What was left out, each reason once.
#[derive(Debug, Default)]
pub(in crate::process) struct LeftOuts(pub(in crate::process) Vec<LeftOut>);

impl LeftOuts {
    /// Counts one more; without a reason nothing was left out.
    pub(in crate::process) fn add(&mut self, reason: Option<LeftOutReason>, line: u64) {
        let Some(reason) = reason else { return };
        match self.0.iter_mut().find(|kind| kind.reason.name() == reason.name()) {
            Some(kind) => kind.count += 1,
            None => self.0.push(LeftOut { reason, count: 1, first_line: line }),
        }
    }
}
