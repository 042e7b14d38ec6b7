//! Why there is no job.

use thiserror::Error;

use super::{CompensatorFault, ComputeFault, PartSurfaceFault, TooCostly};
use crate::shares::NoShare;
use crate::store::{BlobFault, StoreError};
use crate::wire::{Fault, Unreadable};

/// Why there is no job.
#[derive(Debug, Error)]
pub enum JobFault {
    /// The parameters are not a document of this operation.
    #[error(transparent)]
    Unreadable(#[from] Unreadable),
    /// Parameters do not fit, each with its pointer.
    #[error("{}", .0.first().map_or("a parameter is wrong", |fault| fault.detail.as_str()))]
    Parameters(Vec<Fault>),
    /// The estimate is over the limit.
    #[error(transparent)]
    TooCostly(#[from] TooCostly),
    /// The pool has no place, or the computation panicked.
    #[error(transparent)]
    Compute(#[from] ComputeFault),
    /// The work has no result.
    #[error(transparent)]
    Compensator(#[from] CompensatorFault),
    /// The drives cannot run the program.
    #[error(transparent)]
    Servo(#[from] crate::servo::ServoFault),
    /// The part's surface is not valid, or too large.
    #[error(transparent)]
    PartSurface(#[from] PartSurfaceFault),
    /// A file could not be kept.
    #[error(transparent)]
    Blob(#[from] BlobFault),
    /// The row could not be stored.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The caller holds its full share.
    #[error(transparent)]
    NoShare(#[from] NoShare),
    /// More jobs would wait than may.
    #[error(
        "the queue has no room: at most {limit} jobs may wait (max_queued_jobs). Retry later, or post fewer programs at once"
    )]
    QueueFull {
        /// Jobs that may wait.
        limit: usize,
    },
    /// The machine's revision cannot be read: a fault of the service.
    #[error("the machine's revision cannot be used any more")]
    MachineLost,
    /// The process died while it computed this job.
    #[error(
        "the process ended unexpectedly while it computed this job and nothing else, five times; three deaths beside other work \
         came before"
    )]
    ProcessDied,
    /// The key was used for another request.
    #[error("the idempotency key was used for another request")]
    KeyReused,
    /// The report could not be printed.
    #[error("printing the report: {0}")]
    Report(#[from] serde_json::Error),
}
