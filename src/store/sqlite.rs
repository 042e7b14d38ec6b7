//! The database as a file of `SQLite`: how it is opened, migrated and written. These statements belong to `SQLite`
//! alone.

use std::io::ErrorKind;
use std::path::Path;
use std::time::Duration;

use futures::future::BoxFuture;
use sqlx::Connection;
use sqlx::sqlite::{
    SqliteConnectOptions, SqliteConnection, SqliteJournalMode, SqlitePool, SqlitePoolOptions,
    SqliteSynchronous,
};

use super::database_file::newest_migration;
use super::error::Doing;
use super::examination::{STAGING, stored_files};
use super::migrations::of_sqlite;
use super::readers::Readers;
use super::sql::{On, Tx};
use super::{StoreError, own_schema};

/// The oldest `SQLite` without the write-ahead log's corruption fault.
const OLDEST_SQLITE: (&str, [u32; 3]) = ("3.51.3", [3, 51, 3]);

/// Rows that a query hands over at a time.
const ROWS_HANDED_OVER: usize = 1024;

/// The connections to one file: a few that only read, and one that writes.
pub(super) struct Opened {
    pub(super) readers: Readers,
    pub(super) writer: SqlitePool,
}

/// Opens the file. `alone` creates it if it is missing, and updates it to the newest form.
///
/// # Errors
/// The file cannot be opened or migrated, or the linked `SQLite` is too old.
pub(super) async fn open(file: &Path, readers: u32, alone: bool) -> Result<Opened, StoreError> {
    let options = SqliteConnectOptions::new()
        .filename(file)
        .create_if_missing(alone)
        .journal_mode(SqliteJournalMode::Wal)
        .synchronous(SqliteSynchronous::Full)
        .foreign_keys(true)
        .busy_timeout(Duration::from_secs(5));
    let writer = SqlitePoolOptions::new()
        .max_connections(1)
        .acquire_timeout(Duration::from_secs(10))
        .idle_timeout(None)
        .max_lifetime(None)
        // A connection that a full disk left inside a transaction never returns to the pool.
        .after_release(|connection, _| Box::pin(async move { Ok(!connection.is_in_transaction()) }))
        .connect_with(options.clone())
        .await
        .doing("opening the database")?;
    let version: String = sqlx::query_scalar("SELECT sqlite_version()")
        .fetch_one(&writer)
        .await
        .doing("asking for the version")?;
    if !new_enough(&version) {
        return Err(StoreError::TooOld { found: version, needed: OLDEST_SQLITE.0 });
    }
    if alone {
        not_newer(&writer).await?;
        migrate(&writer).await?;
    } else {
        same_form(&writer).await?;
    }
    // All connections are opened at the start and stay open: their caches of the file are ready when they are
    // needed, and memory does not depend on how many were needed at once.
    let readers = SqlitePoolOptions::new()
        .min_connections(readers)
        .max_connections(readers)
        .acquire_timeout(Duration::from_secs(10))
        .idle_timeout(None)
        .max_lifetime(None)
        .after_release(|connection, _| Box::pin(async move { Ok(!connection.is_in_transaction()) }))
        // Long answers (a trend of ten thousand runs) are handed over in fewer, larger parts.
        .connect_with(options.pragma("query_only", "ON").row_buffer_size(ROWS_HANDED_OVER))
        .await
        .doing("opening the database for reading")?;
    Ok(Opened { readers: Readers::new(readers), writer })
}

/// Merges the write-ahead log of a file into it. No service has the file.
///
/// # Errors
/// The file failed.
#[cfg(feature = "scale-out")]
pub(super) async fn merged(file: &Path) -> Result<(), StoreError> {
    let doing = "merging the log of the database into it";
    let options = SqliteConnectOptions::new().filename(file).busy_timeout(Duration::from_secs(5));
    let mut connection = SqliteConnection::connect_with(&options).await.doing(doing)?;
    sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)").execute(&mut connection).await.doing(doing)?;
    connection.close().await.doing(doing)
}

/// Runs `work` in one transaction on the connection that writes.
///
/// # Errors
/// The database failed; nothing is stored.
pub(super) async fn write<T, F>(writer: &SqlitePool, doing: &'static str, work: F) -> Result<T, StoreError>
where
    F: for<'a, 'c> FnOnce(&'a mut Tx<'c>) -> BoxFuture<'a, Result<T, sqlx::Error>>,
{
    let mut connection = writer.acquire().await.doing(doing)?;
    let done = transact(&mut connection, doing, work).await;
    if matches!(done, Err(StoreError::Storage { .. })) {
        // A connection that was opened on a read-only disk stays read-only after the disk becomes writable.
        connection.close_on_drop();
    }
    done
}

/// Does all of `work`, or nothing.
async fn transact<T, F>(
    connection: &mut SqliteConnection,
    doing: &'static str,
    work: F,
) -> Result<T, StoreError>
where
    F: for<'a, 'c> FnOnce(&'a mut Tx<'c>) -> BoxFuture<'a, Result<T, sqlx::Error>>,
{
    let mut transaction = connection.begin_with("BEGIN IMMEDIATE").await.doing(doing)?;
    match work(&mut Tx(On::Sqlite(&mut transaction))).await {
        Ok(done) => transaction.commit().await.doing(doing).map(|()| done),
        Err(fault) => {
            if let Err(also) = transaction.rollback().await {
                tracing::error!(error = %also, doing, "a transaction could not be rolled back");
            }
            Err(fault).doing(doing)
        }
    }
}

/// Updates the database to the newest form. The migrations are not written through to the disk one by one: the first
/// transaction after them writes the log through from its beginning. If the power fails before, they run again.
async fn migrate(writer: &SqlitePool) -> Result<(), StoreError> {
    let doing = "setting how the database writes";
    sqlx::query("PRAGMA synchronous = NORMAL").execute(writer).await.doing(doing)?;
    of_sqlite().run(writer).await?;
    sqlx::query("PRAGMA synchronous = FULL").execute(writer).await.doing(doing)?;
    Ok(())
}

/// Whether the database is in the form of this version.
async fn same_form(writer: &SqlitePool) -> Result<(), StoreError> {
    let mut connection = writer.acquire().await.doing("asking for the form of the database")?;
    let found = newest_migration(&mut connection).await?;
    if found == Some(own_schema()) {
        return Ok(());
    }
    Err(StoreError::OtherForm { found: found.unwrap_or_default(), needed: own_schema() })
}

/// Whether a database file is missing or empty.
pub(super) fn is_empty(file: &Path) -> bool {
    std::fs::metadata(file).map_or_else(|fault| fault.kind() == ErrorKind::NotFound, |found| found.len() == 0)
}

/// Refuses an empty database if files are stored beside it, because a service that starts with it would remove them all,
/// or if a restore did not end.
pub(super) fn no_files_beside(directory: &Path, database: &Path) -> Result<(), StoreError> {
    let entries = std::fs::read_dir(directory).into_iter().flatten().flatten();
    let mut names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    if let Some(found) = names.find(|name| name.starts_with(STAGING)) {
        return Err(StoreError::Unrestored { directory: directory.to_owned(), found });
    }
    match stored_files(directory) {
        0 => Ok(()),
        files => {
            Err(StoreError::Lost { database: database.to_owned(), folder: directory.join("blobs"), files })
        }
    }
}

/// Refuses a schema that this version does not know.
async fn not_newer(writer: &SqlitePool) -> Result<(), StoreError> {
    let mut connection = writer.acquire().await.doing("asking for the schema of the database")?;
    match newest_migration(&mut connection).await? {
        Some(found) if found > own_schema() => Err(StoreError::Newer { found, ours: own_schema() }),
        _ => Ok(()),
    }
}

fn new_enough(version: &str) -> bool {
    let mut parts = version.split('.').map(|part| part.parse().unwrap_or(0));
    let found: [u32; 3] = std::array::from_fn(|_| parts.next().unwrap_or(0));
    found >= OLDEST_SQLITE.1
}

#[cfg(test)]
mod tests {
    use super::new_enough;

    #[test]
    fn an_older_sqlite_is_too_old() {
        for version in ["3.51.3", "3.51.10", "3.52.0", "4.0.0"] {
            assert!(new_enough(version), "{version}");
        }
        for version in ["3.51.2", "3.9.9", "2.99.99", "", "unknown"] {
            assert!(!new_enough(version), "{version}");
        }
    }
}
