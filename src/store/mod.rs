//! All SQL, and the files beside it. Nothing else names the database.

mod api_keys;
mod audit;
mod backup;
mod blobs;
mod calibrations;
mod database;
mod database_file;
mod deliveries;
mod error;
mod examination;
mod filesystem;
mod jobs;
mod key_mark;
mod keys;
mod lock;
mod machines;
mod marks;
mod page;
mod queue;
mod readers;
mod retention;
mod revisions;
mod storage_fault;
mod tools;
mod wear_entries;
mod webhook_secrets;
mod writable;

pub use api_keys::ApiKeyRow;
pub use audit::{Actor, AuditFilter};
pub use backup::{BackupFault, BackupFile, DATABASE_NAME, Manifest, back_up, restore};
pub use blobs::{BlobFault, Blobs, Draft, DraftTooLong, Sha256Hex, sha256_hex};
pub use calibrations::{CalibrationFilter, CalibrationRow, NewCalibration, TrendQuery};
pub use database::Store;
pub use database_file::{DatabaseFile, own_schema};
pub use deliveries::{AfterAttempt, DeliveriesWaiting, DeliveryRow, DueDelivery, Redelivery, Taken};
pub use error::StoreError;
pub use examination::{Examination, Files, examine, stored_files};
pub use filesystem::{NetworkMount, mount_kind, network_mount};
pub use jobs::{JobFilter, JobRow, JobState, NewJob};
pub use key_mark::{KEY_MARK_TRUSTED, KeyMark, mark_key_change};
pub use keys::{KeyUse, Remembered};
pub use lock::{DirectoryLock, LockFault};
pub use machines::{NewRevision, PutOutcome, Revision};
pub use marks::{Died, Mark, Marks};
pub use page::{Cursor, CursorFault, Page};
pub use queue::{
    Cancelling, Claimed, DEATHS_BESIDE_OTHERS, Ending, Enqueued, GivenBack, QueueDepth, QueueRoom, Recovered,
};
pub use revisions::{Expected, RevisionHead, Stale};
pub use storage_fault::StorageFault;
pub use tools::{NewTool, PutTool, StoredTool, ToolRefusal, ToolRevision};
pub use wear_entries::{AddedWear, WearConflict};
pub use webhook_secrets::WebhookSecretRow;
