//! All SQL, and the files beside it. Nothing else names the database.

mod blobs;
mod database;
mod error;
mod filesystem;
mod jobs;
mod lock;
mod machines;
mod page;

pub use blobs::{BlobFault, Blobs, Draft, Sha256Hex, sha256_hex};
pub use database::Store;
pub use error::StoreError;
pub use filesystem::{NetworkMount, network_mount};
pub use jobs::{JobFilter, JobRow, JobState, KeyUse, NewJob, Remembered};
pub use lock::{DirectoryLock, LockFault};
pub use machines::{Expected, MachineHead, PutOutcome, Revision, Stale};
pub use page::{Cursor, CursorFault, Page};
