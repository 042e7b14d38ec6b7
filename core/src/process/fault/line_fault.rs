//! Faults of single lines, and how they are gathered.

use super::not_posted::NotPosted;
use super::unknown_axes::UnknownAxes;
use crate::contact::ContactFault;
use crate::machine::Travel;
use crate::motion::{Unfollowable, WorkOffset};
use crate::wear::ShiftFault;
use thiserror::Error;

/// What the caller has to state before a motion can be computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum Unstated {
    /// Where the workpiece is on the machine.
    #[error(
        "the result depends on where the workpiece is on the machine{}, and that is not stated: give `work_offset_mm` (0,0,0 is an answer), or `work_offsets_mm` by name in the request or in the machine's profile",
        named(*name)
    )]
    WorkOffset {
        /// The offset in force, if it is known.
        name: Option<WorkOffset>,
    },
    /// How long the tool is.
    #[error(
        "the result depends on the length of the tool, which a head axis turns, and it is not stated: give `tool_length_mm` (0 is an answer), or a tool with `length_mm` in the machine's tool table"
    )]
    ToolLength,
}

impl Unstated {
    /// The member of the request that states it.
    #[must_use]
    pub const fn member(self) -> &'static str {
        match self {
            Self::WorkOffset { .. } => "work_offset_mm",
            Self::ToolLength => "tool_length_mm",
        }
    }
}

fn named(offset: Option<WorkOffset>) -> String {
    match offset {
        None | Some(WorkOffset::Unnamed) => String::new(),
        Some(offset) => format!(" ({offset})"),
    }
}

/// What is wrong with one line of the upload.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LineFaultKind {
    /// The contact stated at the end of this line cannot be one.
    #[error(transparent)]
    Contact(#[from] ContactFault),
    /// Something the motion depends on is not stated.
    #[error(transparent)]
    Unstated(#[from] Unstated),
    /// An axis is commanded outside its travel.
    #[error(
        "{axis} {commanded} is outside the travel of {min} to {max}: move the part, change the work offset, or correct the limits in the machine's profile"
    )]
    OutOfTravel {
        /// Address letter.
        axis: char,
        /// The word commanded \[mm or deg\].
        commanded: f64,
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
    /// The decimals of the words cannot keep the tolerance.
    #[error(
        "the program's decimals reach {reachable_um:.3} µm in this block, not the tolerance of {tolerance_um:.3} µm"
    )]
    ToleranceOutOfReach {
        /// Smallest deviation reached \[µm\].
        reachable_um: f64,
        /// Asked for \[µm\].
        tolerance_um: f64,
    },
    /// `interpolated` needs the block's time.
    #[error("the block has no feed, and the number of interpolation steps follows from it")]
    NoFeed,
    /// G93 without F.
    #[error("G93 needs an F word in every block; this block has none and has to be divided")]
    NoInverseTime,
    /// A part would need a feed that cannot be written.
    #[error("a part of the block would need F {feed:e}; the smallest F written is {min:e}")]
    FeedTooSmall {
        /// F of the part.
        feed: f64,
        /// Smallest written.
        min: f64,
    },
    /// More parts than any program would want.
    #[error("the block would become {parts:.0} blocks; the limit is {max:.0}")]
    TooManyParts {
        /// How many.
        parts: f64,
        /// Most accepted.
        max: f64,
    },
    /// The contact at the end of this line cannot be kept by the worn cutter.
    #[error(transparent)]
    Shift(#[from] ShiftFault),
    /// An arc whose ends would move by different vectors, or whose course the contact does not follow.
    #[error("the moved arc would be no arc: {why}; post it as lines")]
    ArcShift {
        /// What differs.
        why: &'static str,
    },
    /// A motion that has to move for the worn cutter and cannot be followed.
    #[error("the motion has to be moved, but {0}")]
    NotMovable(Unfollowable),
    /// A motion of another tool on a machine whose words depend on the tool's length.
    #[error(
        "linear words of this motion depend on the length of its tool, which a head axis turns, and the length is not known: put the tool with its `length_mm` into the machine's tool table"
    )]
    OtherToolLength,
    /// A tool axis that the machine as it is does not reach.
    #[error(
        "the machine as it is does not reach this tool axis: it stands {tilt_deg}° from the rotary axis next to the workpiece, within reach are {min_deg}° to {max_deg}°"
    )]
    OutOfReach {
        /// Angle between the tool axis and the rotary axis next to the workpiece \[deg\].
        tilt_deg: f64,
        /// Smallest angle within reach \[deg\].
        min_deg: f64,
        /// Largest angle within reach \[deg\].
        max_deg: f64,
    },
    /// A line of cutter location data that cannot be posted.
    #[error(transparent)]
    NotPosted(#[from] NotPosted),
    /// The same under another work offset.
    #[error("the motion has to be moved, but another work offset than the first is active")]
    OtherWorkOffset,
    /// The same where not all five axes are known.
    #[error("the motion has to be moved, but not all five axes are known here")]
    PositionUnknown,
    /// The same with the axes named.
    #[error(
        "the motion has to be moved, but it is not known where {axes} stand: give their words before it, or state by `start` where they stand before the first block (as start.{}=0)", .axes.first()
    )]
    AxesUnknown {
        /// Their letters.
        axes: UnknownAxes,
    },
    /// A purely rotary block gets a linear path, which gives its F another meaning, and the F is not known.
    #[error("the block turns between degrees and millimetres per minute, and its feed is not known")]
    FeedUnknown,
    /// An extruder word whose start is unknown.
    #[error("E counts from an unknown value, so the block cannot be divided")]
    ExtraUnknown,
}

impl LineFaultKind {
    /// Whether both have one cause, so that one of them speaks for all lines.
    fn has_cause_of(&self, other: &Self) -> bool {
        match (self, other) {
            (
                Self::OutOfTravel { axis, commanded, max, .. },
                Self::OutOfTravel { axis: other_axis, commanded: other, .. },
            ) => axis == other_axis && (commanded > max) == (other > max),
            (Self::Unstated(unstated), Self::Unstated(other)) => unstated.member() == other.member(),
            (Self::NotMovable(reason), Self::NotMovable(other)) => {
                std::mem::discriminant(reason) == std::mem::discriminant(other)
            }
            (Self::NotPosted(why), Self::NotPosted(other)) => {
                std::mem::discriminant(why) == std::mem::discriminant(other)
            }
            (Self::ArcShift { why }, Self::ArcShift { why: other }) => why == other,
            _ => std::mem::discriminant(self) == std::mem::discriminant(other),
        }
    }

    /// Takes the numbers of the worse of both, which have one cause.
    fn keep_worse(&mut self, other: &Self) {
        match (&mut *self, other) {
            (Self::OutOfTravel { commanded, max, .. }, Self::OutOfTravel { commanded: other, .. })
                if (*commanded > *max && other > commanded) || (*commanded <= *max && other < commanded) =>
            {
                *commanded = *other;
            }
            (
                Self::ToleranceOutOfReach { reachable_um, .. },
                Self::ToleranceOutOfReach { reachable_um: other, .. },
            ) => *reachable_um = reachable_um.max(*other),
            _ => {}
        }
    }

    /// An axis commanded outside its travel by more than `slack` \[mm or deg\], if it is.
    pub(in crate::process) fn outside(axis: char, commanded: f64, travel: Option<Travel>) -> Option<Self> {
        let Travel { min, max } = travel.filter(|travel| !travel.contains(commanded, Travel::WORD_SLACK))?;
        Some(Self::OutOfTravel { axis, commanded, min, max })
    }
}

/// One cause of faulty lines.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("line {line}{}: {kind}", more_lines(*count, *worst_line, *line))]
pub struct LineFault {
    /// 1-based line of the upload: the first with this fault.
    pub line: u64,
    /// The block's text, cut to a readable length.
    pub block: String,
    /// What is wrong with it; of several lines the worst numbers.
    pub kind: LineFaultKind,
    /// How many lines have it.
    pub count: u64,
    /// The line that the numbers are of.
    pub worst_line: u64,
}

fn more_lines(count: u64, worst_line: u64, line: u64) -> String {
    match (count, worst_line == line) {
        (0 | 1, _) => String::new(),
        (count, true) => format!(" and {} more", count - 1),
        (count, false) => format!(" and {} more, the worst is line {worst_line}", count - 1),
    }
}

/// Line faults: one a line, or one for all lines of a cause that has many; all lines are counted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LineFaults {
    /// The first ones, in the order of the program.
    pub kept: Vec<LineFault>,
    /// How many there are.
    pub total: u64,
}

impl LineFaults {
    /// How many are kept.
    pub const MAX_KEPT: usize = 100;
    /// So many lines with one cause are named each; more become one fault with their count.
    pub const NAMED_EACH: usize = 10;
    /// Longest excerpt of a block \[characters\].
    const EXCERPT_CHARS: usize = 80;

    pub(in crate::process) fn add(&mut self, line: u64, text: &[u8], kind: LineFaultKind) {
        self.total += 1;
        let alike = self.kept.iter().filter(|known| known.kind.has_cause_of(&kind)).count();
        if alike == Self::NAMED_EACH {
            self.join(&kind);
        }
        let joined = self.kept.iter_mut().find(|known| known.count > 1 && known.kind.has_cause_of(&kind));
        if let Some(joined) = joined {
            joined.take(line, &kind);
        } else if self.kept.len() < Self::MAX_KEPT {
            let block = String::from_utf8_lossy(text).trim().chars().take(Self::EXCERPT_CHARS).collect();
            self.kept.push(LineFault { line, block, kind, count: 1, worst_line: line });
        }
    }
}

impl LineFaults {
    /// Makes one fault of those that have this cause.
    fn join(&mut self, cause: &LineFaultKind) {
        let mut joined: Option<LineFault> = None;
        let mut place = 0;
        let mut index = 0;
        self.kept.retain(|known| {
            let is_alike = known.kind.has_cause_of(cause);
            match &mut joined {
                _ if !is_alike => {}
                None => (place, joined) = (index, Some(known.clone())),
                Some(first) => first.take(known.line, &known.kind),
            }
            index += usize::from(!is_alike);
            !is_alike
        });
        if let Some(joined) = joined {
            self.kept.insert(place, joined);
        }
    }
}

impl LineFault {
    /// Another line has the same fault.
    fn take(&mut self, line: u64, kind: &LineFaultKind) {
        self.count += 1;
        let before = self.kind.clone();
        self.kind.keep_worse(kind);
        if self.kind != before {
            self.worst_line = line;
        }
    }
}
