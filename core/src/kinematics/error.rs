//! Why a pose has no joints, as facts with numbers.

use thiserror::Error;

use crate::machine::Motion;

/// Why poses could not be converted to joints. `pose` is the 0-based index of the first such pose.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum InverseError {
    /// The tool axis is a zero vector, or a number of the pose is not finite or too large.
    #[error("pose {pose}: the tool axis has no direction, or a number is not finite or too large")]
    NoDirection {
        /// Index of the pose.
        pose: usize,
    },
    /// No angles of the rotary axes point the tool in this direction.
    #[error(
        "pose {pose}: the tool axis is {tilt_deg}° from the rotary axis next to the workpiece; the machine reaches {min_deg}° to {max_deg}°"
    )]
    OutOfReach {
        /// Index of the pose.
        pose: usize,
        /// Angle between the tool axis and the rotary axis next to the workpiece \[deg\].
        tilt_deg: f64,
        /// Smallest angle that can be reached \[deg\].
        min_deg: f64,
        /// Largest angle that can be reached \[deg\].
        max_deg: f64,
    },
    /// Every solution leaves a travel. The error names the solution with the smallest excess.
    #[error("pose {pose}: {commanded} is outside the travel of {min} to {max}")]
    OutOfTravel {
        /// Index of the pose.
        pose: usize,
        /// The axis that leaves its travel.
        axis: Motion,
        /// Its word [deg, mm].
        commanded: f64,
        /// Lower end of the travel [deg, mm].
        min: f64,
        /// Upper end of the travel [deg, mm].
        max: f64,
    },
    /// Each pose has joints within travel, but none can follow those of the pose before: the held axis at the
    /// pole cannot stay within travel.
    #[error(
        "pose {pose}: no axis positions within the travel can follow those of the pose before; change the poses or the limits of the axes"
    )]
    NoWay {
        /// Index of the pose.
        pose: usize,
    },
    /// The start is outside a travel.
    #[error("the start word {commanded} is outside the travel of {min} to {max}")]
    StartOutOfTravel {
        /// The axis.
        axis: Motion,
        /// Its word \[deg\].
        commanded: f64,
        /// Lower end of the travel \[deg\].
        min: f64,
        /// Upper end of the travel \[deg\].
        max: f64,
    },
    /// More combinations of pose, branch and turn than the memory limit allows.
    #[error(
        "{poses} poses times {states} combinations of branch and turn are more than the limit of {max_cells}; send fewer poses, or limit the travels to fewer turns"
    )]
    TooManyStates {
        /// Number of poses.
        poses: usize,
        /// Combinations of branch and turns per pose.
        states: usize,
        /// Largest product accepted.
        max_cells: usize,
    },
    /// The caller asked to stop.
    #[error("stopped on request")]
    Stopped,
}

impl InverseError {
    /// The index of the pose that cannot be solved, if the error is that of a pose.
    #[must_use]
    pub const fn pose(&self) -> Option<usize> {
        match *self {
            Self::NoDirection { pose }
            | Self::OutOfReach { pose, .. }
            | Self::OutOfTravel { pose, .. }
            | Self::NoWay { pose } => Some(pose),
            Self::StartOutOfTravel { .. } | Self::TooManyStates { .. } | Self::Stopped => None,
        }
    }
}
