//! All SQL, and the files beside the database. No other module uses the database.

#[macro_use]
mod sql;

mod api_keys;
mod audit;
mod audit_chain;
mod backup;
mod blobs;
mod calibration_errors;
mod calibrations;
mod database;
mod database_file;
mod deep;
mod deliveries;
mod digest_beside;
mod draft;
mod error;
mod examination;
mod filesystem;
#[cfg(feature = "scale-out")]
mod instance;
mod jobs;
mod key_mark;
mod keys;
mod leases;
mod lock;
mod machines;
mod marks;
mod migrations;
#[cfg(feature = "scale-out")]
mod moved_tables;
#[cfg(feature = "scale-out")]
mod moving;
mod pace;
mod page;
#[cfg(feature = "scale-out")]
mod postgres;
#[cfg(feature = "scale-out")]
mod postgres_examination;
#[cfg(feature = "scale-out")]
mod postgres_fault;
#[cfg(feature = "scale-out")]
mod postgres_form;
#[cfg(feature = "scale-out")]
mod postgres_opening;
#[cfg(feature = "scale-out")]
mod postgres_rows;
#[cfg(feature = "scale-out")]
mod postgres_schema;
#[cfg(feature = "scale-out")]
mod presence;
mod private;
mod queue;
mod queue_depth;
mod readers;
mod recovery;
mod retention;
mod revisions;
mod rows;
#[cfg(feature = "scale-out")]
mod shared_files;
mod soundness;
mod sqlite;
mod storage_fault;
mod stored_file;
mod tool_changes;
mod tools;
mod unnamed;
mod wear_entries;
mod webhook_secrets;
mod writable;

pub use api_keys::ApiKeyRow;
pub use audit::{Actor, AuditFilter};
pub use audit_chain::{AuditChain, AuditHead, ChainFault, NoHead};
pub use backup::{BackupFault, BackupFile, DATABASE_NAME, Manifest, back_up, content_of, restore};
pub use blobs::{BlobFault, Blobs, Sha256Hex, SoundFile, hex, sha256_hex};
pub use calibrations::{
    CalibrationAge, CalibrationFilter, CalibrationRow, CalibrationUse, NewCalibration, TrendQuery,
};
pub use database::Store;
pub use database_file::{DatabaseFile, own_schema};
pub use deep::Deep;
pub use deliveries::{AfterAttempt, DeliveriesWaiting, DeliveryRow, DueDelivery, Redelivery, Taken};
pub use draft::{Draft, DraftTooLong};
pub use error::StoreError;
pub use examination::{Depth, Examination, Files, ServerState, examine, examine_to, stored_files};
pub use filesystem::{DiskSpace, NetworkMount, disk_space, make_directory, mount_kind, network_mount};
pub use jobs::{JobFilter, JobRow, JobState, NewJob};
pub use key_mark::{KEY_MARK_TRUSTED, KeyMark, mark_key_change};
pub use keys::{KeyUse, Remembered};
pub use leases::{HeldLease, Renewed, Signal};
pub use lock::{DirectoryLock, LockFault};
pub use machines::{NewRevision, PutOutcome, Revision};
pub use marks::{Died, Mark, Marks};
#[cfg(feature = "scale-out")]
pub use moving::{MoveFault, Moved, move_to_server};
pub use pace::Pace;
pub use page::{Cursor, CursorFault, Page};
pub use private::{Tightened, make_private};
pub use queue::{Cancelling, Claimed, DEATHS_BESIDE_OTHERS, Ending, Enqueued, GivenBack, QueueRoom};
pub use queue_depth::QueueDepth;
pub use recovery::Recovered;
pub use revisions::{Expected, RevisionHead, Stale};
pub use soundness::{Soundness, SoundnessReading};
pub use storage_fault::StorageFault;
pub use stored_file::{Damage, DamagedFile, FileState, StoredThing, Verifying, verify_text};
pub use tool_changes::{NewTool, PutTool, ToolRefusal};
pub use tools::{StoredTool, ToolRevision};
pub use wear_entries::{AddedWear, WearConflict};
pub use webhook_secrets::WebhookSecretRow;
