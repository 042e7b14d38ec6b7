//! Faults of the database.

use std::path::PathBuf;

use thiserror::Error;

use super::{DamagedFile, StorageFault};

/// The database could not do its work.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The `SQLite` in this process has a known fault in its write-ahead log.
    #[error("SQLite {found} is older than {needed}, the oldest accepted version")]
    TooOld {
        /// Linked version.
        found: String,
        /// Oldest accepted version.
        needed: &'static str,
    },
    /// The service that has the database has another version.
    #[error(
        "the database has format {found}, but this version makes format {needed}; use the version of the running service"
    )]
    OtherForm {
        /// Form of the database.
        found: i64,
        /// Form of this version.
        needed: i64,
    },
    /// A newer version has migrated the database.
    #[error(
        "the database has schema {found}, made by a newer trunnion; this version knows schemas up to {ours}"
    )]
    Newer {
        /// Schema of the database.
        found: i64,
        /// Newest schema of this version.
        ours: i64,
    },
    /// The database is empty, but there are files that only an earlier database can name.
    #[error(
        "{} is missing or was never in use, but {files} stored files are in {}; without their database they would be \
         removed. No file was touched: restore the database, or move the files away to start with an empty service",
        database.display(), folder.display()
    )]
    Lost {
        /// Path of the database.
        database: PathBuf,
        /// Folder of the files.
        folder: PathBuf,
        /// Number of files.
        files: usize,
    },
    /// A restore into this directory did not end.
    #[error(
        "{} holds {found:?} of a restore that did not end, and no database. No file was touched: remove {found:?}, then \
         restore again, or start with an empty service", directory.display()
    )]
    Unrestored {
        /// The data directory.
        directory: PathBuf,
        /// The incomplete copy in it.
        found: String,
    },
    /// The database file could not be opened or migrated.
    #[error("migrating the database: {0}")]
    Migrate(#[from] sqlx::migrate::MigrateError),
    /// The disk does not read or write as it should.
    #[error("{fault}")]
    Storage {
        /// The fault of the disk.
        fault: StorageFault,
        /// The message of the database.
        source: sqlx::Error,
    },
    /// Every connection is taken, or another writer holds the lock for too long.
    #[error("the database is busy")]
    Busy(#[source] sqlx::Error),
    /// A stored document cannot be read.
    #[error("{what} {key} cannot be read: {source}")]
    Unreadable {
        /// Kind of document.
        what: &'static str,
        /// Key of the document.
        key: String,
        /// The reason.
        source: serde_json::Error,
    },
    /// A stored document is damaged.
    #[error(transparent)]
    Damaged(DamagedFile),
    /// The secret that was created at the first start is missing.
    #[error("there is no secret to sign webhooks with")]
    NoSecret,
    /// A statement failed for another reason.
    #[error("while {doing}: {source}")]
    Statement {
        /// The action that failed.
        doing: &'static str,
        /// The message of the database.
        source: sqlx::Error,
    },
}

/// Adds the name of the action to a failed statement.
pub(super) trait Doing<T> {
    fn doing(self, what: &'static str) -> Result<T, StoreError>;
}

impl<T> Doing<T> for Result<T, sqlx::Error> {
    fn doing(self, what: &'static str) -> Result<T, StoreError> {
        self.map_err(|source| {
            let code = source.as_database_error().and_then(|error| error.code()?.parse::<u32>().ok());
            if let Some(fault) = code.and_then(StorageFault::of_sqlite) {
                return StoreError::Storage { fault, source };
            }
            // Primary result codes: 5 SQLITE_BUSY, 6 SQLITE_LOCKED.
            match (code.map(|code| code & 0xff), &source) {
                (Some(5 | 6), _) | (None, sqlx::Error::PoolTimedOut) => StoreError::Busy(source),
                _ => StoreError::Statement { doing: what, source },
            }
        })
    }
}
