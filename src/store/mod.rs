//! All SQL, and the files beside it. Nothing else names the database.

mod api_keys;
mod audit;
mod blobs;
mod calibrations;
mod database;
mod error;
mod filesystem;
mod jobs;
mod key_mark;
mod keys;
mod lock;
mod machines;
mod page;
mod queue;
mod readers;
mod retention;
mod wear_entries;

pub use api_keys::ApiKeyRow;
pub use audit::{Actor, AuditFilter};
pub use blobs::{BlobFault, Blobs, Draft, DraftTooLong, Sha256Hex, sha256_hex};
pub use calibrations::{CalibrationFilter, CalibrationRow, NewCalibration, TrendQuery};
pub use database::Store;
pub use error::StoreError;
pub use filesystem::{NetworkMount, network_mount};
pub use jobs::{JobFilter, JobRow, JobState, NewJob};
pub use key_mark::{KeyMark, mark_key_change};
pub use keys::{KeyUse, Remembered};
pub use lock::{DirectoryLock, LockFault};
pub use machines::{Expected, MachineHead, NewRevision, PutOutcome, Revision, Stale};
pub use page::{Cursor, CursorFault, Page};
pub use queue::{Cancelling, Claimed, Ending, Enqueued, GivenBack, QueueDepth, Recovered};
pub use wear_entries::{AddedWear, WearConflict};
