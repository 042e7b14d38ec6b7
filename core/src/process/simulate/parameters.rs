//! What a servo simulation of a program is asked to do.

use crate::geometry::Vec3;
use crate::process::set_up::ProgramSetup;
use crate::servo::{DriveSet, FeedProfile};

/// The parameters of a program's servo simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulationParameters {
    /// Drives of the axes that move.
    pub drives: DriveSet,
    /// The caller's statements that the text does not have.
    pub program: ProgramSetup,
    /// Sample period of the command \[s\].
    pub period_s: f64,
    /// Jerk-limited feed. Without it every block runs at its feed, and the feed changes in steps.
    pub profile: Option<FeedProfile>,
    /// With a profile: the machine stops exactly at corners of the tip's path that are sharper than this \[rad\].
    pub stop_at_corners_above_rad: f64,
    /// Normal of the plane in which the contour error gets a sign.
    pub plane_normal: Option<Vec3>,
    /// Most samples the program may take.
    pub max_samples: u64,
}

impl SimulationParameters {
    /// The defaults of the contract: 1 ms, no profile.
    #[must_use]
    pub fn new(drives: DriveSet, program: ProgramSetup) -> Self {
        Self {
            drives,
            program,
            period_s: 0.001,
            profile: None,
            stop_at_corners_above_rad: 10_f64.to_radians(),
            plane_normal: None,
            max_samples: 50_000_000,
        }
    }
}
