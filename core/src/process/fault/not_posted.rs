//! Why a line of cutter location data cannot be posted.

use thiserror::Error;

use crate::kinematics::InverseError;
use crate::motion::Unfollowable;
use crate::program::{CycleUnread, Excerpt};

/// The reason.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum NotPosted {
    /// The motion cannot be followed.
    #[error("the motion cannot be posted: {0}")]
    Unfollowable(Unfollowable),
    /// A point under radius compensation, and the caller has not said what it is.
    #[error(
        "the point is under radius compensation; give `cutcom` as centre if such points are places of the cutter's centre"
    )]
    Cutcom,
    /// The end of the motion or its tool axis is not known.
    #[error("the motion cannot be posted: its end or its tool axis is not known")]
    Unknown,
    /// The coordinate system differs from that of the first point.
    #[error(
        "the motion cannot be posted: its set-up differs from that of the first point; post each set-up as a program of its own"
    )]
    OtherSetup,
    /// A cut whose feed is not known.
    #[error("the motion cannot be posted: its feed is not known; give a feed before it")]
    NoFeed,
    /// A feed per turn in machine coordinates.
    #[error(
        "the motion cannot be posted in machine coordinates: its feed is per turn of the spindle; give a feed per minute"
    )]
    FeedPerTurn,
    /// A feed above the machine's.
    #[error(
        "the motion cannot be posted: its feed of {mm_per_min} mm/min is above max_feed_mm_per_min of the machine, {max_mm_per_min}; lower the feed"
    )]
    OverMaxFeed {
        /// The feed \[mm/min\].
        mm_per_min: f64,
        /// The largest of the machine \[mm/min\].
        max_mm_per_min: f64,
    },
    /// A feed, or an inverse time, that no F word with nine decimals states.
    #[error("the motion cannot be posted: it needs F{per_min:e}, which no F word can state; raise the feed")]
    TooSlow {
        /// F \[mm/min, mm per turn, or 1/min in inverse time\].
        per_min: f64,
    },
    /// A feed, or an inverse time, outside every control's range.
    #[error(
        "the motion cannot be posted: it needs F{per_min:.0}, which no control accepts; lower the feed or move the points farther apart"
    )]
    TooQuick {
        /// F \[mm/min, or 1/min in inverse time\].
        per_min: f64,
    },
    /// An invalid arc: no circle before it, an end off the circle, or a tool axis that turns.
    #[error("the arc cannot be posted: {why}")]
    Arc {
        /// What is wrong with the arc.
        why: &'static str,
    },
    /// The radius that the circle states differs from the distance of its ends.
    #[error(
        "the arc cannot be posted: its circle states a radius of {stated_mm} mm, but its ends are {start_mm} mm and {end_mm} mm from the centre"
    )]
    ArcRadius {
        /// The stated radius \[mm\].
        stated_mm: f64,
        /// Distance of the start from the centre \[mm\].
        start_mm: f64,
        /// Distance of the end from the centre \[mm\].
        end_mm: f64,
    },
    /// A point that is farther away than any machine reaches.
    #[error(
        "the point cannot be posted: {axis} {value_mm} mm is more than {max_mm} mm from the origin; correct the value"
    )]
    TooFar {
        /// X, Y or Z.
        axis: char,
        /// Its value \[mm\].
        value_mm: f64,
        /// The largest value \[mm\].
        max_mm: f64,
    },
    /// A cycle that is not followed.
    #[error("the point cannot be posted: {0}")]
    Cycle(CycleUnread),
    /// A cycle whose numbers make no motions.
    #[error("the point cannot be posted: in the cycle {why}; correct the value")]
    CycleValue {
        /// What is wrong with them.
        why: &'static str,
    },
    /// A cycle that is not followed from the place before.
    #[error(
        "the cycle cannot be followed to this point: the tool comes from below RAPTO, from an unknown place or with another tool axis, or the hole needs more than 100 pecks; go to a place above the point with its tool axis first, or use fewer pecks"
    )]
    CycleHere,
    /// A statement by which the control or the machine may do anything.
    #[error(
        "`{text}` may move an axis, change a mode of the control, call a program, or load something else than a tool, and no later statement says what holds after it; remove it if the machine does not need it, and write motions as GOTO"
    )]
    ForTheControl {
        /// The statement.
        text: Excerpt,
    },
    /// A tool statement with an item whose meaning is not certain.
    #[error(
        "the item {item} of the tool statement is not understood, and it may select the tool's length; remove it, state the length register as ADJUST,n, or give `length_offset_number` for data with one tool"
    )]
    LoadItem {
        /// The item.
        item: Excerpt,
    },
    /// A tool statement with a length, where the words depend on the length.
    #[error(
        "the tool statement states a LENGTH, and the words depend on the tool's length on this machine; give it as `tool_length_mm`, and remove it here"
    )]
    LoadLength,
    /// A statement that selects a length register after the tool.
    #[error(
        "the statement selects another length register than the tool's own; state the register in LOADTL as ADJUST,n, or give `length_offset_number` for data with one tool, and remove the statement"
    )]
    LengthRegister,
    /// The tool changes after a cut, and the caller has not asked for tool changes.
    #[error(
        "the tool changes after a cut, and the program has no tool change; give `tool_change`, or split the data here"
    )]
    ToolChange,
    /// A tool that no T word can name.
    #[error(
        "the tool has no number from 1 to 9999 for the T word of its change; number it, or split the data here"
    )]
    ToolWithoutNumber,
    /// A number or a length is stated, but the program has several tools.
    #[error(
        "another tool comes here, but `tool_number`, `tool_length_mm` and `length_offset_number` are for one tool; leave them out, or split the data here"
    )]
    OneTool,
    /// The words depend on the lengths of several tools.
    #[error(
        "another tool comes here, and the words depend on the tool's length on this machine; split the data here"
    )]
    SeveralLengths,
    /// The cutter changes after a cut, and no tool was loaded.
    #[error(
        "the cutter changed after a cut, but no other tool was loaded; state the tool with LOADTL, or split the data here"
    )]
    CutterChange,
    /// A cut after a tool change, with a spindle that nothing has started again.
    #[error(
        "the tool changed, and the spindle was not started again before this cut; state SPINDL/n,CLW (or CCLW) after LOADTL"
    )]
    SpindleStands,
    /// A cut after `SPINDL/OFF`.
    #[error(
        "the spindle was stopped (SPINDL/OFF), and it was not started again before this cut; state SPINDL/n,CLW (or CCLW)"
    )]
    SpindleStopped,
    /// The rotary axes cannot reach this tool axis.
    #[error(
        "the tool axis is {tilt_deg:.4}° from the rotary axis next to the workpiece; the machine reaches {min_deg:.4}° to {max_deg:.4}°"
    )]
    OutOfReach {
        /// Angle between the tool axis and the rotary axis next to the workpiece \[deg\].
        tilt_deg: f64,
        /// Smallest angle that can be reached \[deg\].
        min_deg: f64,
        /// Largest angle that can be reached \[deg\].
        max_deg: f64,
    },
    /// The point is within travel, but no path leads to it from the points before.
    #[error(
        "the point is within travel, but the machine cannot reach it from the points before without leaving its travel"
    )]
    NoWay,
    /// The machine does not reach the point.
    #[error("the point cannot be posted: {0}")]
    Machine(InverseError),
}
