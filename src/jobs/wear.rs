//! Computations about worn cutters, inside the pool.

use std::ops::ControlFlow;

use thiserror::Error;

use super::{Cost, Limits, TooCostly};
use crate::wire::{Fault, ScallopAnswer, ScallopRequest};

/// Why there is no answer.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WearFault {
    /// Wrong values.
    #[error("{} values are wrong", .0.len())]
    Values(Vec<Fault>),
    /// More elements than one request may have.
    #[error("{count} elements are more than the limit of {limit}; split the request")]
    TooMany {
        /// How many.
        count: usize,
        /// Most accepted.
        limit: usize,
    },
    /// The estimate is over the limit.
    #[error(transparent)]
    TooCostly(#[from] TooCostly),
    /// The request was abandoned.
    #[error("the computation was stopped")]
    Cancelled,
}

/// Scallop heights, and the other requested values.
///
/// # Errors
/// Bad elements, too many of them, or stopped.
pub fn scallop_heights(
    request: &ScallopRequest,
    limits: Limits,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<ScallopAnswer, WearFault> {
    let (count, limit) = (request.count(), limits.max_poses);
    if count > limit {
        return Err(WearFault::TooMany { count, limit });
    }
    Cost::of_scallops(count).within(limits.max_cost_s)?;
    request.solve(stop).map_err(WearFault::Values)?.ok_or(WearFault::Cancelled)
}
