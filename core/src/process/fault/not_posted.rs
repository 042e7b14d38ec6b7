//! Why a line of cutter location data cannot be posted.

use thiserror::Error;

use crate::kinematics::InverseError;
use crate::motion::Unfollowable;

/// What stands in the way.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum NotPosted {
    /// The motion cannot be followed.
    #[error("the motion cannot be posted: {0}")]
    Unfollowable(Unfollowable),
    /// Its end or its tool axis is not known.
    #[error("the motion cannot be posted: its end or its tool axis is not known")]
    Unknown,
    /// Another coordinate system than that of the first point.
    #[error("the motion cannot be posted: it belongs to another set-up than the first point")]
    OtherSetup,
    /// A cut without a feed that is known.
    #[error("the motion cannot be posted: its feed is not known")]
    NoFeed,
    /// A feed per turn in machine coordinates.
    #[error("the motion cannot be posted in machine coordinates: its feed counts by turns of the spindle")]
    FeedPerTurn,
    /// A feed, or the inverse of a time, that is out of every range.
    #[error("the motion cannot be posted: it would take F{per_min:.0}, which no control takes")]
    TooQuick {
        /// F \[mm/min, in inverse time 1/min\].
        per_min: f64,
    },
    /// An arc that is none: without a circle before it, off the circle, or with a tool axis that turns.
    #[error("the arc cannot be posted: {why}")]
    Arc {
        /// What is wrong with it.
        why: &'static str,
    },
    /// The radius that the circle states is not that of its ends.
    #[error(
        "the arc cannot be posted: its circle states the radius {stated_mm} mm, its ends are {start_mm} mm and {end_mm} mm from the centre"
    )]
    ArcRadius {
        /// As stated \[mm\].
        stated_mm: f64,
        /// Of the start \[mm\].
        start_mm: f64,
        /// Of the end \[mm\].
        end_mm: f64,
    },
    /// Another tool behind a cut.
    #[error(
        "another tool behind a cut cannot be posted: one length and one tool hold for the whole program; split the data here"
    )]
    ToolChange,
    /// Another cutter behind a cut.
    #[error("another cutter behind a cut cannot be posted: it is another tool; split the data here")]
    CutterChange,
    /// The rotary axes cannot point the tool that way.
    #[error(
        "the tool axis stands {tilt_deg:.4}° from the rotary axis next to the workpiece; the machine reaches {min_deg:.4}° to {max_deg:.4}°"
    )]
    OutOfReach {
        /// Angle between the tool axis and the rotary axis next to the workpiece \[deg\].
        tilt_deg: f64,
        /// Smallest angle within reach \[deg\].
        min_deg: f64,
        /// Largest angle within reach \[deg\].
        max_deg: f64,
    },
    /// Points within travel, and no way to this one from those before.
    #[error("the machine cannot go on to this point within its travel from those before it")]
    NoWay,
    /// The machine does not get there.
    #[error("the point cannot be posted: {0}")]
    Machine(InverseError),
}
