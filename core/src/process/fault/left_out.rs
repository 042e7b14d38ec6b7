//! Why motions are left out of a simulation or a virtual cut.

use crate::motion::Unfollowable;
use crate::process::arc_path::UnknownArc;

/// Why a motion is left out of a simulation or a virtual cut. A simulation does not count its rapids: they cut
/// nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LeftOutReason {
    /// The motion cannot be followed.
    NotFollowed(Unfollowable),
    /// The work offset differs from the one at the program's first complete point.
    WorkOffsetChanged,
    /// An arc in a simulation: the control's way of running it is not known.
    Arc,
    /// An arc whose course is not known.
    UnknownArc(UnknownArc),
    /// Start or end of an axis is not known.
    PositionUnknown,
    /// No feed is known, or the feed is per spindle turn.
    NoFeed,
    /// The tool in the spindle is not the one asked for, or nothing is known of it.
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

    /// What to change so that the motion is not left out; `None` if the reason says it.
    #[must_use]
    pub const fn cure(self) -> Option<&'static str> {
        match self {
            Self::NotFollowed(reason) => reason.cure(),
            Self::WorkOffsetChanged => Some(
                "State the offset in `work_offsets_mm`, set a shift at the control, or replace a call by the blocks that it runs",
            ),
            Self::Arc => Some("Post it as lines"),
            Self::UnknownArc(_) | Self::NoFeed => None,
            Self::PositionUnknown => Some("Program all axes before the motion, or state them in `start`"),
            Self::OtherTool => Some("Correct `tool_number`, or put the tool into the machine's tool table"),
        }
    }

    /// The reason in words.
    #[must_use]
    pub fn text(self) -> String {
        match self {
            Self::NotFollowed(reason) => format!("a motion that cannot be followed: {reason}"),
            Self::WorkOffsetChanged => "a motion under a work offset that is not known, or with a shifted zero".to_owned(),
            Self::Arc => "an arc: the control decides how the tool moves along it".to_owned(),
            Self::UnknownArc(why) => format!("an arc whose path is not known: {why}"),
            Self::PositionUnknown => "an axis whose position is not known".to_owned(),
            Self::OtherTool => "the tool in the spindle is not the one that `tool_number` names, or neither the request nor the machine's tool table describes it".to_owned(),
            Self::NoFeed => "no feed is known, or it is per spindle turn: give feed_mm_per_min".to_owned(),
        }
    }
}

/// Motions left out of a simulation or a virtual cut for one reason.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOut {
    /// The reason. If several have the same name, the first one met.
    pub reason: LeftOutReason,
    /// Number of motions.
    pub count: u64,
    /// The first such line of the upload.
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
