//! Many poses or joints at a time, inside the pool.

use std::ops::ControlFlow;

use thiserror::Error;

use super::{Cost, TooCostly};
use crate::kinematics::{Kinematics, Setup};
use crate::machine::Machine;
use crate::wire::{Fault, FaultList, JointWords, Pose};

/// How many poses are computed between two looks at the stop.
const BETWEEN_STOPS: usize = 4096;

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum KinematicsFault {
    /// Bad values, each with its pointer.
    #[error("{} values are wrong", .0.len())]
    Values(Vec<Fault>),
    /// More poses than the limit.
    #[error("{count} poses are more than the limit of {limit}")]
    TooMany {
        /// Given.
        count: usize,
        /// Limit.
        limit: usize,
    },
    /// The estimate is over the limit.
    #[error(transparent)]
    TooCostly(#[from] TooCostly),
    /// The client has left.
    #[error("cancelled")]
    Cancelled,
}

/// What a computation may cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Most poses.
    pub max_poses: usize,
    /// Largest estimate [s of one core].
    pub max_cost_s: f64,
}

impl Limits {
    fn check(&self, count: usize, candidates: usize) -> Result<(), KinematicsFault> {
        if count > self.max_poses {
            return Err(KinematicsFault::TooMany { count, limit: self.max_poses });
        }
        Ok(Cost::of_poses(count, candidates).within(self.max_cost_s)?)
    }
}

/// The poses of `joints`.
///
/// # Errors
/// Every bad value, too many joints, or the client has left.
pub fn forward(
    machine: &Machine,
    setup: &Setup,
    joints: &[JointWords],
    limits: Limits,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<Vec<Pose>, KinematicsFault> {
    limits.check(joints.len(), 0)?;
    let kinematics = Kinematics::new(machine, setup);
    let mut faults = FaultList::default();
    let mut poses = Vec::with_capacity(joints.len());
    for (chunk_index, chunk) in joints.chunks(BETWEEN_STOPS).enumerate() {
        if stop().is_break() {
            return Err(KinematicsFault::Cancelled);
        }
        for (offset, words) in chunk.iter().enumerate() {
            let index = chunk_index * BETWEEN_STOPS + offset;
            if let Some(joints) = words.to_core(machine, index, &mut faults) {
                poses.push(Pose::from(kinematics.forward(&joints)));
            }
        }
    }
    faults.into_result().map_err(KinematicsFault::Values)?;
    Ok(poses)
}
