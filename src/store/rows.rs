//! Reads the rows of a database whatever it is: how many there are, and which of them are damaged.

use std::path::Path;

use sqlx::AssertSqlSafe;

use super::error::Doing;
use super::sql::On;
use super::{DATABASE_NAME, DatabaseFile, Pace, Store, StoreError};

impl Store {
    /// The number of rows in a table of this name.
    ///
    /// # Errors
    /// The database failed, or has no such table.
    pub async fn row_count(&self, table: &'static str) -> Result<u64, StoreError> {
        let text = AssertSqlSafe(format!("SELECT COUNT(*) FROM {table}"));
        let count: i64 = match self.db.on() {
            On::Sqlite(readers) => sqlx::query_scalar(text).fetch_one(readers).await,
            #[cfg(feature = "scale-out")]
            On::Postgres(readers) => sqlx::query_scalar(text).fetch_one(readers).await,
            #[cfg(not(feature = "scale-out"))]
            On::Postgres(never) => match *never {},
        }
        .doing("counting rows")?;
        Ok(count.unsigned_abs())
    }

    /// Reads every row of the database of a data directory, and describes the damage in words. A file is read at this
    /// pace; a server reads its rows itself.
    ///
    /// # Errors
    /// The database failed.
    pub async fn damage_in_rows(&self, data_dir: &Path, pace: &Pace) -> Result<Vec<String>, StoreError> {
        match self.db.on() {
            On::Sqlite(_) => {
                let mut file = DatabaseFile::open(&data_dir.join(DATABASE_NAME)).await?;
                let deep = file.deep(pace, None).await;
                file.close().await;
                Ok(deep?.faults())
            }
            #[cfg(feature = "scale-out")]
            On::Postgres(readers) => readers.damage().await.doing("reading every row"),
            #[cfg(not(feature = "scale-out"))]
            On::Postgres(never) => match *never {},
        }
    }
}
