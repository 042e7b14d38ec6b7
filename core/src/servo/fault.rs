//! Why a path is not simulated.

use thiserror::Error;

use super::{AxisLetter, TooStiff, UnstableLoop};
use crate::kinematics::InverseError;

/// Why a path is not simulated.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ServoFault {
    /// An axis that moves has no drive.
    #[error("axis {axis} moves on this path but has no drive")]
    NoDrive {
        /// The axis.
        axis: AxisLetter,
    },
    /// A loop that does not settle.
    #[error("axis {axis}: {fault}")]
    Unstable {
        /// The axis.
        axis: AxisLetter,
        /// Its poles.
        fault: UnstableLoop,
    },
    /// Loops too fast for the sample period.
    #[error("axis {axis}: {fault}")]
    TooStiff {
        /// The axis.
        axis: AxisLetter,
        /// By how much.
        fault: TooStiff,
    },
    /// The circle runs through, or too near, the line about which C turns.
    #[error(
        "the circle comes within {distance_mm} mm of the C axis, where C would turn by {turn_rad} rad in one sample; {max_rad} rad are followed"
    )]
    ThroughRotaryCenter {
        /// |x0| − r \[mm\].
        distance_mm: f64,
        /// How far C would turn \[rad\].
        turn_rad: f64,
        /// Largest turn accepted \[rad\].
        max_rad: f64,
    },
    /// A path without length.
    #[error("the path has no length: nothing moves")]
    NoLength,
    /// More samples than one simulation may have.
    #[error("the path takes {samples:.0} samples at this feed and sample period; the limit is {max}")]
    TooManySamples {
        /// How many.
        samples: f64,
        /// Largest accepted.
        max: usize,
    },
    /// So few samples in a lap that they do not tell its course.
    #[error(
        "a lap takes {samples:.1} samples at this feed and sample period; at least {least} tell its course"
    )]
    TooFewSamples {
        /// How many.
        samples: f64,
        /// Fewest accepted.
        least: f64,
    },
    /// The tool is further behind its command than it is looked for.
    #[error(
        "{at_s} s into the path the tool is {samples} samples behind its command, and is looked for no further back: take a longer sample period or more gain"
    )]
    TooFarBehind {
        /// Time from the start \[s\].
        at_s: f64,
        /// How far back it is looked for.
        samples: usize,
    },
    /// No gain keeps the margins asked for.
    #[error("not even a position gain of {smallest_per_s} 1/s on every axis keeps these margins")]
    NoGainWithinMargins {
        /// The smallest tried \[1/s\].
        smallest_per_s: f64,
    },
    /// The machine cannot take the tool there.
    #[error("{at_s} s into the path: {fault}")]
    Unreachable {
        /// Time from the start \[s\].
        at_s: f64,
        /// Why; its pose counts the samples.
        fault: InverseError,
    },
    /// An axis leaves its travel.
    #[error(
        "{at_s} s into the path axis {axis} would stand at {commanded}, outside its travel {min} … {max}"
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
        "{at_s} s into the path axis {axis} would have to turn by {step_deg}° from one sample to the next"
    )]
    Jump {
        /// Time from the start \[s\].
        at_s: f64,
        /// The axis.
        axis: char,
        /// By how much \[deg\].
        step_deg: f64,
    },
    /// The caller no longer wants the answer.
    #[error("stopped on request")]
    Stopped,
}
