//! The connections that only read. Every query through them is timed, from the wait for a connection to its last row.

use futures::future::BoxFuture;
use futures::stream::{BoxStream, StreamExt};
use sqlx::sqlite::{SqlitePool, SqliteQueryResult, SqliteRow, SqliteStatement, SqliteTypeInfo};
use sqlx::{Either, Error, Execute, Executor, SqlStr, Sqlite};

use crate::meter;

/// A pool that measures the time of its queries.
#[derive(Debug, Clone)]
pub(super) struct Readers(SqlitePool);

impl Readers {
    /// A pool over these connections.
    pub(super) fn new(pool: SqlitePool) -> Self {
        Self(pool)
    }

    /// Closes every connection.
    pub(super) async fn close(&self) {
        self.0.close().await;
    }
}

impl<'p> Executor<'p> for &'_ Readers {
    type Database = Sqlite;

    fn fetch_many<'e, 'q: 'e, E>(
        self,
        query: E,
    ) -> BoxStream<'e, Result<Either<SqliteQueryResult, SqliteRow>, Error>>
    where
        'p: 'e,
        E: 'q + Execute<'q, Sqlite>,
    {
        let timed = meter::STORE_READS.begin();
        let rows = (&self.0).fetch_many(query);
        // The stream measures the time, which ends with it.
        rows.inspect(move |_row| {
            let _held = &timed;
        })
        .boxed()
    }

    fn fetch_optional<'e, 'q: 'e, E>(self, query: E) -> BoxFuture<'e, Result<Option<SqliteRow>, Error>>
    where
        'p: 'e,
        E: 'q + Execute<'q, Sqlite>,
    {
        let timed = meter::STORE_READS.begin();
        let row = (&self.0).fetch_optional(query);
        Box::pin(async move {
            let row = row.await;
            drop(timed);
            row
        })
    }

    fn prepare_with<'e>(
        self,
        sql: SqlStr,
        parameters: &'e [SqliteTypeInfo],
    ) -> BoxFuture<'e, Result<SqliteStatement, Error>>
    where
        'p: 'e,
    {
        (&self.0).prepare_with(sql, parameters)
    }

    #[cfg(feature = "check-statements")]
    fn describe<'e>(self, sql: SqlStr) -> BoxFuture<'e, Result<sqlx::Describe<Sqlite>, Error>>
    where
        'p: 'e,
    {
        (&self.0).describe(sql)
    }
}
