//! What can go wrong beneath a statement.

use std::path::PathBuf;

use thiserror::Error;

use super::{DamagedFile, StorageFault};

/// The database could not do what it was asked.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The `SQLite` linked into the process has a known fault in its write-ahead log.
    #[error("SQLite {found} is older than {needed}")]
    TooOld {
        /// Version linked.
        found: String,
        /// Oldest accepted.
        needed: &'static str,
    },
    /// The service that has the database is of another version.
    #[error(
        "the database is in form {found} and this version makes form {needed}; use the version that serves"
    )]
    OtherForm {
        /// Form of the database.
        found: i64,
        /// Form of this version.
        needed: i64,
    },
    /// A newer version has had the database.
    #[error(
        "the database has schema {found}, which a newer trunnion made; this one knows schemas up to {ours}"
    )]
    Newer {
        /// Schema of the database.
        found: i64,
        /// Newest schema of this version.
        ours: i64,
    },
    /// The database knows nothing, and there are files that only the one before it can name.
    #[error(
        "{} is not there or was never served from, but {files} stored files lie in {}, and without their database they would be \
         removed; none was touched: put the database back, or move the files away to begin with nothing",
        database.display(), folder.display()
    )]
    Lost {
        /// Where the database should be.
        database: PathBuf,
        /// Where the files are.
        folder: PathBuf,
        /// How many they are.
        files: usize,
    },
    /// The database file could not be opened or migrated.
    #[error("migrating the database: {0}")]
    Migrate(#[from] sqlx::migrate::MigrateError),
    /// The disk does not take or give what it should.
    #[error("{fault}")]
    Storage {
        /// What ails it.
        fault: StorageFault,
        /// What the database said.
        source: sqlx::Error,
    },
    /// Every connection is taken, or another writer holds the lock for too long.
    #[error("the database is busy")]
    Busy(#[source] sqlx::Error),
    /// A stored document does not read back.
    #[error("{what} {key} does not read back: {source}")]
    Unreadable {
        /// Kind of document.
        what: &'static str,
        /// Which one.
        key: String,
        /// Why.
        source: serde_json::Error,
    },
    /// A stored document is not what was stored.
    #[error(transparent)]
    Damaged(DamagedFile),
    /// The secret that was made at the first start is gone.
    #[error("there is no secret to sign webhooks with")]
    NoSecret,
    /// A statement failed otherwise.
    #[error("while {doing}: {source}")]
    Statement {
        /// What was being done.
        doing: &'static str,
        /// What the database said.
        source: sqlx::Error,
    },
}

/// Names what was being done when a statement failed.
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
