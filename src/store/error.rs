//! Faults of the database.

use std::path::PathBuf;

use sqlx::error::DatabaseError;
use sqlx::sqlite::SqliteError;
use thiserror::Error;

#[cfg(feature = "scale-out")]
use super::postgres_fault::{PgFault, cure};
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
    /// A newer version has changed the database so that this one cannot use it.
    #[error(
        "the database has schema {found}, which only a trunnion that knows schema {usable_from} or later may use; this \
         version knows schemas up to {ours}. Start the newer version, or restore a backup from before it"
    )]
    NotUsable {
        /// Schema of the database.
        found: i64,
        /// The oldest schema that a service must know.
        usable_from: i64,
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
    /// The settings name a server, but this binary knows only files.
    #[error(
        "database is set, but this binary was built without the feature scale-out; build with --features scale-out, or \
         leave database empty to keep the data in the data directory"
    )]
    NoServers,
    /// The address of the server cannot be used.
    #[error("the address of the database cannot be used: {why}")]
    Address {
        /// What is wrong, without a word of the address.
        why: &'static str,
    },
    /// The file with the password, or the note of the database, cannot be used.
    #[error("{} cannot be used: {source}", path.display())]
    Note {
        /// Path of the file.
        path: PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
    /// Others can read or change a file with a secret.
    #[error(
        "{file} has the mode {mode:03o}, so others can read or change what is secret in it: chmod 640 {file}",
        file = path.display()
    )]
    Exposed {
        /// Path of the file.
        path: PathBuf,
        /// Its mode.
        mode: u32,
    },
    /// The server does not answer, or does not let this service in.
    #[error("{database} cannot be opened: {source}. {}", cure(source))]
    Unreachable {
        /// The address without a password.
        database: String,
        /// The message of the server.
        source: sqlx::Error,
    },
    /// The server is too old.
    #[error("the server is PostgreSQL {found}, but {needed} or later is needed; update the server")]
    ServerTooOld {
        /// Version of the server.
        found: String,
        /// Oldest accepted version.
        needed: i32,
    },
    /// The server keeps texts in another encoding.
    #[error(
        "the database has the encoding {found}, but UTF8 is needed: createdb --encoding=UTF8 --template=template0"
    )]
    NotUtf8 {
        /// Encoding of the database.
        found: String,
    },
    /// The address names no schema that can be used.
    #[error(
        "{database} has no schema that this user may use: make it with CREATE SCHEMA NAME AUTHORIZATION USER, or correct          ?options[search_path]=NAME"
    )]
    NoSchema {
        /// The address without a password.
        database: String,
    },
    /// Another service has the database.
    #[error(
        "{database} is in use by trunnion {version} on {host} (process {process}) since {since}. Stop that service \
         first, or give this one a database of its own. Several services can share a database if each of them has the \
         setting files = postgres, or the same bucket (docs/scale-out.md)"
    )]
    InUse {
        /// The address without a password.
        database: String,
        /// Computer of the other service.
        host: String,
        /// Number of its process there.
        process: i64,
        /// Its version.
        version: String,
        /// Since when, by the clock of the server.
        since: String,
    },
    /// The files of the database are not where the settings say.
    #[error(
        "the database has its files in {found:?}, but the setting files is {asked:?}: set files = {found}. Files cannot \
         be moved in this version"
    )]
    FilesElsewhere {
        /// The place that the first service has chosen.
        found: String,
        /// The setting.
        asked: String,
    },
    /// The file with the keys to the bucket has something else in it.
    #[error("{} cannot be used: {why}", path.display())]
    Credentials {
        /// Path of the file.
        path: PathBuf,
        /// What is wrong, without a word of the file.
        why: String,
    },
    /// The bucket does not have the files of this database.
    #[error(
        "{bucket} does not have the files of this database: there is no {mark} in it. Name the bucket that has them with \
         files and files_endpoint, or copy them to this one. Nothing was changed"
    )]
    NoObjects {
        /// The bucket.
        bucket: String,
        /// The object that is missing.
        mark: String,
    },
    /// The server of the bucket does not do what it should.
    #[error(
        "while {doing}: {reason}. The files are in a bucket: look at its server, at files_endpoint, and at the keys to it"
    )]
    Objects {
        /// The action that failed.
        doing: &'static str,
        /// Why, in words that every caller may read.
        reason: String,
    },
    /// A data directory was being moved to the database.
    #[error(
        "moving a data directory to {database} did not end: run trunnion migrate --to once more, or drop the schema to \
         begin with an empty database"
    )]
    HalfMoved {
        /// The address without a password.
        database: String,
    },
    /// The files in the data directory belong to another database.
    #[error(
        "the files in {} belong to another database (noted in {}). No file was touched: name the directory of this \
         database with --data-dir, or an empty one for a new database", directory.display(), note.display()
    )]
    OtherDatabase {
        /// The data directory.
        directory: PathBuf,
        /// The file that names its database.
        note: PathBuf,
    },
    /// The data directory has a database of its own.
    #[error(
        "{} has a database file of its own, and its files belong to that; name another directory with --data-dir for \
         the service on PostgreSQL, or move this one there with trunnion migrate --to", directory.display()
    )]
    FileHere {
        /// The data directory.
        directory: PathBuf,
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
    /// PostgreSQL stores no text with the character U+0000.
    #[error("a text contains the character U+0000, which this database cannot store; leave it out")]
    Nul,
    /// A statement failed for another reason.
    #[error("while {doing}: {source}")]
    Statement {
        /// The action that failed.
        doing: &'static str,
        /// The message of the database.
        source: sqlx::Error,
    },
}

impl StoreError {
    /// The fault of the disk or of a server, if that is the fault.
    #[must_use]
    pub fn storage(&self) -> Option<StorageFault> {
        match self {
            Self::Storage { fault, .. } => Some(*fault),
            Self::Objects { .. } => Some(StorageFault::NoBucket),
            _ => None,
        }
    }

    /// Why the server of the database or that of the files does not answer, if that is the fault: in words that every
    /// caller may read.
    #[must_use]
    pub fn of_the_server(&self) -> Option<String> {
        match self {
            Self::Objects { reason, .. } => Some(reason.clone()),
            #[cfg(feature = "scale-out")]
            Self::Storage { fault: StorageFault::Away, source } => {
                Some(super::postgres_fault::reason(source))
            }
            _ => None,
        }
    }
}

/// What helps if the server cannot be reached.
#[cfg(not(feature = "scale-out"))]
fn cure(_source: &sqlx::Error) -> &'static str {
    "Change database in the settings"
}

/// Adds the name of the action to a failed statement.
pub(super) trait Doing<T> {
    fn doing(self, what: &'static str) -> Result<T, StoreError>;
}

impl<T> Doing<T> for Result<T, sqlx::Error> {
    fn doing(self, what: &'static str) -> Result<T, StoreError> {
        self.map_err(|source| {
            #[cfg(feature = "scale-out")]
            match PgFault::of(&source) {
                Some(PgFault::Storage(fault)) => return StoreError::Storage { fault, source },
                Some(PgFault::Busy) => return StoreError::Busy(source),
                Some(PgFault::Nul) => return StoreError::Nul,
                Some(PgFault::Statement) => return StoreError::Statement { doing: what, source },
                None => {}
            }
            let sqlite = source.as_database_error().and_then(|error| error.try_downcast_ref::<SqliteError>());
            let code = sqlite.and_then(|error| error.code()?.parse::<u32>().ok());
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
