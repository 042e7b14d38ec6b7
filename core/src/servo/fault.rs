//! Why a path is not simulated.

use thiserror::Error;

use super::{AxisLetter, TooStiff, UnstableLoop};
use crate::kinematics::InverseError;

/// Why a path is not simulated.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ServoFault {
    /// An axis that moves has no drive.
    #[error("axis {axis} moves on this path but has no drive; give it one")]
    NoDrive {
        /// The axis.
        axis: AxisLetter,
    },
    /// An unstable loop.
    #[error("axis {axis}: {fault}")]
    Unstable {
        /// The axis.
        axis: AxisLetter,
        /// Its poles.
        fault: UnstableLoop,
    },
    /// The loops are too fast for the sample period.
    #[error("axis {axis}: {fault}")]
    TooStiff {
        /// The axis.
        axis: AxisLetter,
        /// The excess.
        fault: TooStiff,
    },
    /// The circle passes through, or too near, the line about which C turns.
    #[error(
        "the circle comes within {distance_mm} mm of the C axis, where C would turn by {turn_rad} rad in one sample; the limit is {max_rad} rad. Move the circle, or take a lower feed"
    )]
    ThroughRotaryCenter {
        /// |x0| − r \[mm\].
        distance_mm: f64,
        /// The turn of C \[rad\].
        turn_rad: f64,
        /// Largest turn accepted \[rad\].
        max_rad: f64,
    },
    /// A path without length.
    #[error("the path has no length, so nothing moves; give different points")]
    NoLength,
    /// More samples than one simulation allows.
    #[error(
        "the path takes {samples:.0} samples at this feed and sample period; the limit is {max}; take a higher feed, a longer sample period or a shorter path"
    )]
    TooManySamples {
        /// Number of samples.
        samples: f64,
        /// Largest number accepted.
        max: usize,
    },
    /// Too few samples in a lap to show its course.
    #[error(
        "a lap takes {samples:.1} samples at this feed and sample period; at least {least} are needed; take a lower feed or a shorter sample period"
    )]
    TooFewSamples {
        /// Number of samples.
        samples: f64,
        /// Smallest number accepted.
        least: f64,
    },
    /// The tool is farther behind its command than the search for it.
    #[error(
        "{at_s} s into the path the tool is more than {samples} samples behind its command, the limit of the search: take a longer sample period or more gain"
    )]
    TooFarBehind {
        /// Time from the start \[s\].
        at_s: f64,
        /// Limit of the search \[samples\].
        samples: usize,
    },
    /// No gain keeps the required margins.
    #[error(
        "not even a position gain of {smallest_per_s} 1/s on every axis keeps these margins; request smaller margins"
    )]
    NoGainWithinMargins {
        /// The smallest tried \[1/s\].
        smallest_per_s: f64,
    },
    /// The machine does not reach this tool pose.
    #[error("{at_s} s into the path: {fault}")]
    Unreachable {
        /// Time from the start \[s\].
        at_s: f64,
        /// The reason; its pose number counts the samples.
        fault: InverseError,
    },
    /// An axis leaves its travel.
    #[error(
        "{at_s} s into the path axis {axis} would be at {commanded}, outside its travel of {min} to {max}"
    )]
    OutOfTravel {
        /// Time from the start \[s\].
        at_s: f64,
        /// The axis.
        axis: char,
        /// Its word \[mm or deg\].
        commanded: f64,
        /// Lower end.
        min: f64,
        /// Upper end.
        max: f64,
    },
    /// A rotary axis would have to jump: a rewind, or the pole.
    #[error(
        "{at_s} s into the path axis {axis} would have to turn by {step_deg}° from one sample to the next; take a lower feed, or move the path away from the pole"
    )]
    Jump {
        /// Time from the start \[s\].
        at_s: f64,
        /// The axis.
        axis: char,
        /// The step \[deg\].
        step_deg: f64,
    },
    /// The caller no longer waits for the answer.
    #[error("stopped on request")]
    Stopped,
}
