//! Faults of single lines, and how they are gathered.

use super::not_posted::NotPosted;
use super::unknown_axes::UnknownAxes;
use crate::contact::ContactFault;
use crate::machine::Travel;
use crate::motion::{Unfollowable, WorkOffset};
use crate::wear::ShiftFault;
use thiserror::Error;

use crate::units::legible;

/// What the caller has to state before a motion can be computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum Unstated {
    /// The position of the workpiece on the machine.
    #[error(
        "the result depends on where the workpiece is on the machine{}, which is not stated: give `work_offset_mm` (0,0,0 is an answer), or `work_offsets_mm` by name in the request or in the machine's profile",
        named(*name)
    )]
    WorkOffset {
        /// The offset in force, if it is known.
        name: Option<WorkOffset>,
    },
    /// The length of the tool.
    #[error(
        "a head axis turns the tool, so the result depends on the tool length, which is not stated: give `tool_length_mm` (0 is an answer), or a tool with `length_mm` in the machine's tool table"
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

/// Why a motion cannot be followed, and what to change.
fn with_cure(reason: Unfollowable) -> String {
    reason.cure().map_or_else(|| reason.to_string(), |cure| format!("{reason}. {cure}"))
}

/// What is wrong with one line of the upload.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LineFaultKind {
    /// The contact stated at the end of this line is not a valid contact.
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
        /// The commanded word \[mm or deg\].
        commanded: f64,
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
    /// The decimals of the words are too coarse for the tolerance.
    #[error(
        "with the program's decimals this block deviates by at least {reachable_um:.3} µm; the tolerance is {tolerance_um:.3} µm: write more decimals, or take a larger tolerance"
    )]
    ToleranceOutOfReach {
        /// Smallest deviation reached \[µm\].
        reachable_um: f64,
        /// The tolerance asked for \[µm\].
        tolerance_um: f64,
    },
    /// `interpolated` needs the block's time.
    #[error("the number of interpolation steps depends on the feed, and this block has none: give an F word")]
    NoFeed,
    /// A block in G93 without an F word.
    #[error(
        "this block has to be divided, but it has no F word: give one, because G93 needs it in every block"
    )]
    NoInverseTime,
    /// A part needs a feed that is too small to be written.
    #[error(
        "a part of the block needs F {}, but the smallest F that can be written is {}: raise the feed", legible(.feed), legible(.min))]
    FeedTooSmall {
        /// F of the part.
        feed: f64,
        /// Smallest written.
        min: f64,
    },
    /// The block would become more parts than the limit allows.
    #[error(
        "the block would be divided into {parts:.0} blocks; the limit is {max:.0}: take a larger tolerance"
    )]
    TooManyParts {
        /// Number of parts.
        parts: f64,
        /// Largest number accepted.
        max: f64,
    },
    /// The worn cutter cannot keep the contact at the end of this line.
    #[error(transparent)]
    Shift(#[from] ShiftFault),
    /// An arc whose ends would move by different vectors, or whose course differs from the contact's.
    #[error("the motion would no longer be an arc after the move: {why}. Post it as lines")]
    ArcShift {
        /// What differs.
        why: &'static str,
    },
    /// A motion that has to move for the worn cutter, but cannot be followed.
    #[error("the motion has to move, but {}", with_cure(*.0))]
    NotMovable(Unfollowable),
    /// A motion of another tool, of unknown length, on a machine whose words depend on the tool length.
    #[error(
        "a head axis turns the tool, so the linear words of this motion depend on the tool length, which is not known: put the tool with its `length_mm` into the machine's tool table"
    )]
    OtherToolLength,
    /// A tool axis that the machine with its location errors does not reach.
    #[error(
        "the machine with its location errors does not reach this tool axis: it is {tilt_deg}° from the rotary axis next to the workpiece; {min_deg}° to {max_deg}° can be reached. Change the tool axis in the CAM system"
    )]
    OutOfReach {
        /// Angle between the tool axis and the rotary axis next to the workpiece \[deg\].
        tilt_deg: f64,
        /// Smallest angle that can be reached \[deg\].
        min_deg: f64,
        /// Largest angle that can be reached \[deg\].
        max_deg: f64,
    },
    /// A line of cutter location data that cannot be posted.
    #[error(transparent)]
    NotPosted(#[from] NotPosted),
    /// A motion that has to move, under another work offset that is not stated, or under a shifted one.
    #[error(
        "the motion has to move, but its work offset is not stated, or the program shifts it or may have shifted it in a call. State the offset in `work_offsets_mm`, set a shift at the control, or replace the call by the blocks that it runs"
    )]
    OtherWorkOffset,
    /// A motion that has to move while not all five axes are known.
    #[error(
        "the motion has to move, but not all five axis positions are known here: program all five axes before it, or state them in `start`"
    )]
    PositionUnknown,
    /// The same, naming the axes.
    #[error(
        "the motion has to move, but these axis positions are not known: {axes}. Program these axes before it, or state in `start` where they are before the first block (as start.{}=0)", .axes.first()
    )]
    AxesUnknown {
        /// Their letters.
        axes: UnknownAxes,
    },
    /// A purely rotary block would become a linear path. That changes the meaning of its F, and the F is
    /// not known.
    #[error(
        "the feed of this block would change from degrees to millimetres per minute, but its value is not known: give an F word before it"
    )]
    FeedUnknown,
    /// An extruder word whose start value is unknown.
    #[error("the block cannot be divided, because E counts from an unknown value: set E before it")]
    ExtraUnknown,
}

impl LineFaultKind {
    /// Whether both faults have the same cause. One fault then covers all its lines.
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

    /// Takes the worse numbers of two faults with the same cause.
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

    /// The fault of an axis that is commanded outside its travel by more than [`Travel::WORD_SLACK`].
    pub(in crate::process) fn outside(axis: char, commanded: f64, travel: Option<Travel>) -> Option<Self> {
        let Travel { min, max } = travel.filter(|travel| !travel.contains(commanded, Travel::WORD_SLACK))?;
        Some(Self::OutOfTravel { axis, commanded, min, max })
    }
}

/// One cause of faults, with the lines that have it.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("line {line}{}: {kind}", more_lines(*count, *worst_line, *line))]
pub struct LineFault {
    /// 1-based line of the upload: the first with this fault.
    pub line: u64,
    /// The block's text, cut to a readable length.
    pub block: String,
    /// What is wrong with it. If several lines have it, the numbers are the worst.
    pub kind: LineFaultKind,
    /// Number of lines with this fault.
    pub count: u64,
    /// The line that the numbers belong to.
    pub worst_line: u64,
}

fn more_lines(count: u64, worst_line: u64, line: u64) -> String {
    match (count, worst_line == line) {
        (0 | 1, _) => String::new(),
        (count, true) => format!(" and {} more", count - 1),
        (count, false) => format!(" and {} more, the worst is line {worst_line}", count - 1),
    }
}

/// Line faults: one for each line, or one for all lines if a cause has many. The total counts all lines.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LineFaults {
    /// The first faults, in program order.
    pub kept: Vec<LineFault>,
    /// Total number.
    pub total: u64,
}

impl LineFaults {
    /// Largest number kept.
    pub const MAX_KEPT: usize = 100;
    /// Up to this many lines with one cause are listed one by one. More become one fault with a count.
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
    /// Joins all faults of this cause into one.
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
    /// Counts another line with the same fault.
    fn take(&mut self, line: u64, kind: &LineFaultKind) {
        self.count += 1;
        let before = self.kind.clone();
        self.kind.keep_worse(kind);
        if self.kind != before {
            self.worst_line = line;
        }
    }
}
