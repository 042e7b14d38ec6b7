//! Why a pose has no joints, as facts with numbers.

use thiserror::Error;

use crate::machine::Motion;

/// Why poses could not be turned into joints. `pose` is the 0-based index of the first such pose.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum InverseError {
    /// The tool axis is a zero vector or a number of the pose is not finite or absurd.
    #[error("pose {pose}: the tool axis has no direction, or a number is not finite or too large")]
    NoDirection {
        /// Index of the pose.
        pose: usize,
    },
    /// The rotary axes cannot point the tool there, at any angle.
    #[error(
        "pose {pose}: the tool axis stands {tilt_deg}° from the rotary axis next to the workpiece; the machine reaches {min_deg}° to {max_deg}°"
    )]
    OutOfReach {
        /// Index of the pose.
        pose: usize,
        /// Angle between the tool axis and the rotary axis next to the workpiece \[deg\].
        tilt_deg: f64,
        /// Smallest angle within reach \[deg\].
        min_deg: f64,
        /// Largest angle within reach \[deg\].
        max_deg: f64,
    },
    /// Every solution leaves a travel; the one that leaves it least is told.
    #[error("pose {pose}: {commanded} is outside the travel {min} to {max}")]
    OutOfTravel {
        /// Index of the pose.
        pose: usize,
        /// The axis whose travel is left.
        axis: Motion,
        /// Its word [deg, mm].
        commanded: f64,
        /// Lower end of the travel [deg, mm].
        min: f64,
        /// Upper end of the travel [deg, mm].
        max: f64,
    },
    /// Each pose has joints within travel, yet none can follow those of the pose before: the held axis at the
    /// pole has nowhere to go.
    #[error("pose {pose}: no joints within travel can follow those of the pose before")]
    NoWay {
        /// Index of the pose.
        pose: usize,
    },
    /// The start stands outside a travel.
    #[error("the start word {commanded} is outside the travel {min} to {max}")]
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
    /// More combinations of pose, branch and turn than are kept.
    #[error("{poses} poses times {states} combinations of branch and turn are more than {max_cells}")]
    TooManyStates {
        /// Number of poses.
        poses: usize,
        /// Combinations of branch and turns per pose.
        states: usize,
        /// Largest product accepted.
        max_cells: usize,
    },
    /// The caller's stop signal.
    #[error("stopped on request")]
    Stopped,
}
