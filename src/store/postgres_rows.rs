//! Reads every row of a database on a server of PostgreSQL, which computes the digests itself.

use std::time::Duration;

use sqlx::{AssertSqlSafe, Connection, Error, Executor, PgConnection};

use super::audit_chain::examine_chain;
use super::deep::{CONTRADICTIONS, DIGESTED, MAX_FINDINGS};
use super::postgres::PgReaders;
use super::sql::{On, Tx};

/// Longest time for reading everything.
const READ_WITHIN: Duration = Duration::from_hours(6);

impl PgReaders {
    /// The damage in the rows, in words.
    ///
    /// # Errors
    /// The server failed.
    pub(super) async fn damage(&self) -> Result<Vec<String>, Error> {
        self.presence()
            .within(READ_WITHIN, async {
                let mut connection = self.acquire().await?;
                // Everything is seen as it is at one moment.
                let mut transaction = connection.begin_with("BEGIN ISOLATION LEVEL REPEATABLE READ").await?;
                transaction.execute("SET LOCAL statement_timeout = 0").await?;
                let found = damage(&mut transaction).await?;
                transaction.rollback().await?;
                Ok(found)
            })
            .await
    }
}

async fn damage(connection: &mut PgConnection) -> Result<Vec<String>, Error> {
    let mut found = Vec::new();
    for digested in &DIGESTED {
        let (table, text, sha256, key) = (digested.table, digested.text, digested.sha256, digested.key);
        let differs = AssertSqlSafe(format!(
            "SELECT '{table} ' || {key} || ': {text} has another SHA-256 than ' || {sha256} FROM {table}
             WHERE encode(sha256(convert_to({text}, 'UTF8')), 'hex') <> {sha256} LIMIT {MAX_FINDINGS}"
        ));
        found.extend(sqlx::query_scalar::<_, String>(differs).fetch_all(&mut *connection).await?);
    }
    for contradiction in &CONTRADICTIONS {
        found.extend(sqlx::query_scalar::<_, String>(contradiction.query).fetch_all(&mut *connection).await?);
    }
    let chain = examine_chain(&mut Tx(On::Postgres(connection)), None).await?;
    found.extend(chain.faults.iter().map(ToString::to_string));
    found.truncate(MAX_FINDINGS);
    Ok(found)
}
