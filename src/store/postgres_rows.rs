//! Reads every row of a database on a server of PostgreSQL, which computes the digests itself.

use std::time::Duration;

use sqlx::{AssertSqlSafe, Connection, Error, Executor, PgConnection};

use super::audit_chain::examine_chain;
use super::calibration_errors::contradictions;
use super::deep::{CONTRADICTIONS, DIGESTED, MAX_FINDINGS};
use super::postgres::PgReaders;
use super::sql::{On, Tx};
use super::{AuditHead, Deep, Pace};

/// Longest time for reading everything.
pub(super) const READ_WITHIN: Duration = Duration::from_hours(6);

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
                let mut transaction = connection.begin_with(AT_ONE_MOMENT).await?;
                transaction.execute(WITHOUT_LIMITS).await?;
                let found = deep(&mut transaction, None).await?;
                transaction.rollback().await?;
                let mut faults = found.faults();
                faults.truncate(MAX_FINDINGS);
                Ok(faults)
            })
            .await
    }
}

/// Begins a transaction that sees everything as it is at one moment.
pub(super) const AT_ONE_MOMENT: &str = "BEGIN ISOLATION LEVEL REPEATABLE READ";
/// Lets the statements of the present transaction take as long as they need.
pub(super) const WITHOUT_LIMITS: &str =
    "SET LOCAL statement_timeout = 0; SET LOCAL idle_in_transaction_session_timeout = 0";

/// Reads every row, and compares the audit log with a recorded entry if there is one. The rows are not counted.
///
/// # Errors
/// The server failed.
pub(super) async fn deep(connection: &mut PgConnection, known: Option<&AuditHead>) -> Result<Deep, Error> {
    let mut deep = Deep::default();
    for digested in &DIGESTED {
        let (table, text, sha256, key) = (digested.table, digested.text, digested.sha256, digested.key);
        let differs = AssertSqlSafe(format!(
            "SELECT '{table} ' || {key} || ': {text} has another SHA-256 than ' || {sha256} FROM {table}
             WHERE encode(sha256(convert_to({text}, 'UTF8')), 'hex') <> {sha256} LIMIT {MAX_FINDINGS}"
        ));
        let found: Vec<String> = sqlx::query_scalar(differs).fetch_all(&mut *connection).await?;
        for finding in found {
            deep.find(finding);
        }
    }
    for contradiction in &CONTRADICTIONS {
        let found: Vec<String> = sqlx::query_scalar(contradiction.query).fetch_all(&mut *connection).await?;
        for finding in found {
            deep.find(finding);
        }
    }
    let mut tx = Tx(On::Postgres(connection));
    let found = contradictions(&mut tx, &Pace::unbounded()).await?;
    for finding in found {
        deep.find(finding);
    }
    deep.audit = Some(examine_chain(&mut tx, known).await?);
    Ok(deep)
}
