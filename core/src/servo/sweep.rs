//! One path under many feeds and gains.

use std::ops::ControlFlow;

use super::{
    Circle, CircleCommand, Detail, DriveSet, PathExtent, Run, ServoFault, Simulation, ToolCommand, ToolPath,
    letters_of, simulate_circle, simulate_tool_path,
};
use crate::geometry::Vec3;
use crate::kinematics::Kinematics;
use crate::machine::Machine;

/// A path with everything needed to run it.
#[derive(Debug, Clone, Copy)]
pub enum ServoPath<'a> {
    /// Made by two axes alone.
    Circle(Circle),
    /// Made by the whole machine.
    Tool {
        /// The machine.
        machine: &'a Machine,
        /// The machine with its set-up.
        kinematics: &'a Kinematics,
        /// The path.
        path: &'a ToolPath,
        /// Normal of the plane in which the contour error has a sign.
        plane_normal: Option<Vec3>,
    },
}

/// A path sampled at one feed, to be run with many drives.
#[derive(Debug, Clone)]
pub enum SampledPath<'a> {
    /// For two axes.
    Circle(CircleCommand),
    /// For the whole machine.
    Tool {
        /// The commands.
        command: ToolCommand,
        /// The machine with its set-up.
        kinematics: &'a Kinematics,
        /// Normal of the plane in which the contour error has a sign.
        plane_normal: Option<Vec3>,
    },
}

impl<'a> ServoPath<'a> {
    /// The extent of a run at any feed; with [`Run::samples`] for estimates before the work starts.
    #[must_use]
    pub fn extent(&self, run: &Run) -> PathExtent {
        match self {
            Self::Circle(circle) => PathExtent::of_circle(circle, run.laps),
            Self::Tool { path, .. } => path.extent(run),
        }
    }

    /// Whether the path does not end at its start, so that the tool has to come to rest there.
    #[must_use]
    pub fn is_open(&self) -> bool {
        matches!(self, Self::Tool { path, .. } if !path.is_closed())
    }

    /// Largest number of further samples that these drives need to come to rest at the end of an open path.
    #[must_use]
    pub fn settling_samples(&self, run: &Run, drives: &DriveSet) -> f64 {
        match self {
            Self::Tool { machine, .. } if self.is_open() => {
                drives.settling_s(&letters_of(machine)) / run.period_s
            }
            _ => 0.0,
        }
    }

    /// Samples the path.
    ///
    /// # Errors
    /// As for [`CircleCommand::new`] and [`ToolCommand::new`].
    pub fn sample(
        &self,
        run: &Run,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<SampledPath<'a>, ServoFault> {
        match *self {
            Self::Circle(circle) => CircleCommand::new(circle, run).map(SampledPath::Circle),
            Self::Tool { machine, kinematics, path, plane_normal } => {
                let command = ToolCommand::new(machine, kinematics, path, run, stop)?;
                Ok(SampledPath::Tool { command, kinematics, plane_normal })
            }
        }
    }
}

impl SampledPath<'_> {
    /// Runs these drives along the path.
    ///
    /// # Errors
    /// As for [`simulate_circle`].
    pub fn simulate(
        &self,
        drives: &DriveSet,
        detail: Detail,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Simulation, ServoFault> {
        match self {
            Self::Circle(command) => simulate_circle(command, drives, detail, stop),
            Self::Tool { command, kinematics, plane_normal } => {
                simulate_tool_path(command, kinematics, drives, *plane_normal, stop)
            }
        }
    }
}

/// Runs drives along a path.
///
/// # Errors
/// As for [`ServoPath::sample`] and [`simulate_circle`].
pub fn simulate(
    path: &ServoPath<'_>,
    run: &Run,
    drives: &DriveSet,
    detail: Detail,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<Simulation, ServoFault> {
    path.sample(run, stop)?.simulate(drives, detail, stop)
}

/// Runs all sets of drives along the path at one feed: one column of a sweep. Columns are independent of each
/// other, so they may run side by side.
///
/// # Errors
/// The path cannot be sampled, or the caller stopped. A set of drives that cannot be run has its fault as its
/// result.
pub fn sweep_at_feed(
    path: &ServoPath<'_>,
    run: &Run,
    sets: &[DriveSet],
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<Vec<Result<Simulation, ServoFault>>, ServoFault> {
    let sampled = path.sample(run, stop)?;
    sets.iter()
        .map(|drives| match sampled.simulate(drives, Detail::Summary, stop) {
            Err(ServoFault::Stopped) => Err(ServoFault::Stopped),
            cell => Ok(cell),
        })
        .collect()
}
