//! A database file, read as a file: for backups, restorations and examinations, whether or not a service has it open.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::Duration;

use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{AssertSqlSafe, ConnectOptions, Connection};

use super::error::Doing;
use super::migrations::{newest, of_sqlite};
use super::{Sha256Hex, StoreError};

/// Columns of jobs that name files; older schemas have fewer of them.
const BLOB_COLUMNS: [&str; 4] = ["input_sha256", "output_sha256", "surface_sha256", "changes_sha256"];

/// Largest number of faults that one check reports.
const MAX_FAULTS: usize = 20;

/// A database file that is open for reading.
#[derive(Debug)]
pub struct DatabaseFile {
    connection: SqliteConnection,
}

impl DatabaseFile {
    /// Opens the file; nothing is created or changed.
    ///
    /// # Errors
    /// There is no file, or it is not a database.
    pub async fn open(file: &Path) -> Result<Self, StoreError> {
        let options =
            SqliteConnectOptions::new().filename(file).read_only(true).busy_timeout(Duration::from_secs(5));
        // A report may be long, so only a few rows wait to be read.
        let options = options.row_buffer_size(1);
        let mut connection = options.connect().await.doing("opening the database")?;
        // The header is read only at this point.
        let _tables: i64 = sqlx::query_scalar("SELECT COUNT(*) FROM sqlite_schema")
            .fetch_one(&mut connection)
            .await
            .doing("reading the database")?;
        Ok(Self { connection })
    }

    /// From now on the database is seen as it is at this moment.
    ///
    /// # Errors
    /// The database failed.
    pub async fn hold(&mut self) -> Result<(), StoreError> {
        sqlx::query("BEGIN").execute(&mut self.connection).await.doing("reading the database")?;
        Ok(())
    }

    /// From now on the database is seen as it is at each query.
    ///
    /// # Errors
    /// The database failed.
    pub async fn let_go(&mut self) -> Result<(), StoreError> {
        sqlx::query("COMMIT").execute(&mut self.connection).await.doing("reading the database")?;
        Ok(())
    }

    /// The connection, for further queries.
    pub(super) fn connection(&mut self) -> &mut SqliteConnection {
        &mut self.connection
    }

    /// The newest schema that a migration has made; `None` if no migration has run.
    ///
    /// # Errors
    /// The database failed.
    pub async fn schema(&mut self) -> Result<Option<i64>, StoreError> {
        newest_migration(&mut self.connection).await
    }

    /// Version of the `SQLite` that reads the file.
    ///
    /// # Errors
    /// The database failed.
    pub async fn sqlite_version(&mut self) -> Result<String, StoreError> {
        let version = sqlx::query_scalar("SELECT sqlite_version()").fetch_one(&mut self.connection);
        version.await.doing("asking for the version")
    }

    /// The faults in the file's structure; empty for a sound file.
    ///
    /// # Errors
    /// The database failed.
    pub async fn structural_faults(&mut self) -> Result<Vec<String>, StoreError> {
        let rows: Vec<String> =
            sqlx::query_scalar(AssertSqlSafe(format!("PRAGMA integrity_check({MAX_FAULTS})")))
                .fetch_all(&mut self.connection)
                .await
                .doing("checking the database's structure")?;
        Ok(rows.into_iter().filter(|row| row != "ok").collect())
    }

    /// Number of rows that refer to missing rows.
    ///
    /// # Errors
    /// The database failed.
    pub async fn broken_references(&mut self) -> Result<u64, StoreError> {
        let count: i64 = sqlx::query_scalar("SELECT COUNT(*) FROM pragma_foreign_key_check")
            .fetch_one(&mut self.connection)
            .await
            .doing("checking the database's references")?;
        Ok(count.unsigned_abs())
    }

    /// Number of rows in each table.
    ///
    /// # Errors
    /// The database failed.
    pub async fn row_counts(&mut self) -> Result<BTreeMap<String, u64>, StoreError> {
        let tables: Vec<String> = sqlx::query_scalar(
            "SELECT name FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE 'sqlite@_%' ESCAPE '@'",
        )
        .fetch_all(&mut self.connection)
        .await
        .doing("listing the tables")?;
        let mut counts = BTreeMap::new();
        for table in tables {
            let count: i64 = sqlx::query_scalar(AssertSqlSafe(format!(
                "SELECT COUNT(*) FROM \"{}\"",
                table.replace('"', "\"\"")
            )))
            .fetch_one(&mut self.connection)
            .await
            .doing("counting rows")?;
            counts.insert(table, count.unsigned_abs());
        }
        Ok(counts)
    }

    /// Digests of every file that a job names, in any schema.
    ///
    /// # Errors
    /// The database failed.
    pub async fn named_blobs(&mut self) -> Result<BTreeSet<Sha256Hex>, StoreError> {
        let columns: Vec<String> = sqlx::query_scalar("SELECT name FROM pragma_table_info('jobs')")
            .fetch_all(&mut self.connection)
            .await
            .doing("asking for the columns of jobs")?;
        let mut named = BTreeSet::new();
        for column in BLOB_COLUMNS.into_iter().filter(|known| columns.iter().any(|column| column == known)) {
            let digests: Vec<String> = sqlx::query_scalar(AssertSqlSafe(format!(
                "SELECT DISTINCT {column} FROM jobs WHERE {column} IS NOT NULL"
            )))
            .fetch_all(&mut self.connection)
            .await
            .doing("listing the files in use")?;
            named.extend(digests);
        }
        Ok(named)
    }

    /// Number of webhooks that are waiting, and of those that were given up; `None` in a schema without them.
    ///
    /// # Errors
    /// The database failed.
    pub async fn deliveries(&mut self) -> Result<Option<(u64, u64)>, StoreError> {
        let there: i64 = sqlx::query_scalar("SELECT COUNT(*) FROM sqlite_schema WHERE name = 'deliveries'")
            .fetch_one(&mut self.connection)
            .await
            .doing("asking for the tables")?;
        if there == 0 {
            return Ok(None);
        }
        let (waiting, given_up): (i64, i64) = sqlx::query_as(
            "SELECT COUNT(*) FILTER (WHERE state = 'waiting'), COUNT(*) FILTER (WHERE state = 'given-up') FROM deliveries",
        )
        .fetch_one(&mut self.connection)
        .await
        .doing("counting webhooks")?;
        Ok(Some((waiting.unsigned_abs(), given_up.unsigned_abs())))
    }

    /// Writes a copy of the present state to a file that must not exist. Writers continue meanwhile.
    ///
    /// # Errors
    /// The copy could not be written.
    pub async fn copy_to(&mut self, file: &Path) -> Result<(), StoreError> {
        let name = file.to_string_lossy().into_owned();
        sqlx::query("VACUUM INTO ?")
            .bind(name)
            .execute(&mut self.connection)
            .await
            .doing("copying the database")?;
        Ok(())
    }

    /// Closes it.
    pub async fn close(self) {
        if let Err(fault) = self.connection.close().await {
            tracing::debug!(error = %fault, "a database file was not closed properly");
        }
    }
}

/// The newest migration that a database has seen.
pub(super) async fn newest_migration(connection: &mut SqliteConnection) -> Result<Option<i64>, StoreError> {
    let ever: i64 = sqlx::query_scalar("SELECT COUNT(*) FROM sqlite_schema WHERE name = '_sqlx_migrations'")
        .fetch_one(&mut *connection)
        .await
        .doing("asking for the schema of the database")?;
    if ever == 0 {
        return Ok(None);
    }
    sqlx::query_scalar("SELECT MAX(version) FROM _sqlx_migrations WHERE success")
        .fetch_one(connection)
        .await
        .doing("asking for the schema of the database")
}

/// The schema that this version makes.
#[must_use]
pub fn own_schema() -> i64 {
    newest(&of_sqlite())
}
