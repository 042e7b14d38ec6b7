//! Idempotency keys: the first answers to their requests.

use super::error::Doing;
use super::sql::Tx;
use super::{CalibrationRow, JobRow, Revision, Store, StoreError};
use crate::wire::WearEntry;
use sqlx::error::ErrorKind;

/// An idempotency key and its use.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeyUse {
    /// The client's key.
    pub key: String,
    /// Digest of method, path, query and body.
    pub fingerprint: String,
    /// Uses before this time are not remembered.
    pub since: String,
    /// Uses after this time were stored while the clock was ahead; they count as uses at this time.
    pub farthest: String,
    /// The use is stored with this time, or with the time of its answer if that is later: a clock that is corrected
    /// does not make it old.
    pub not_before: String,
}

/// What is remembered of an idempotency key.
#[derive(Debug, Clone, PartialEq)]
pub enum Remembered {
    /// The same request, answered by this job.
    Job(Box<JobRow>),
    /// The same request, answered by this calibration.
    Calibration(Box<CalibrationRow>),
    /// The same request, which made this revision.
    Revision(Box<Revision>),
    /// The same request, which stored these wear entries.
    Wear(Vec<WearEntry>),
    /// Another request.
    Other,
}

row! {
    /// A use of a key, and what it belongs to.
    struct StoredUse {
        fingerprint: String,
        job_id: Option<String>,
        calibration_id: Option<String>,
        calibrated: Option<String>,
        machine_id: Option<String>,
        machine_revision: Option<i64>,
        wear_entry_id: Option<String>,
    }
}

/// The answer that a key belongs to.
#[derive(Debug, Clone, Copy)]
pub(super) enum Answer<'a> {
    Job(&'a str),
    Calibration(&'a str),
    Revision(&'a str, i64),
    /// The first of the entries.
    Wear(&'a str),
}

/// Stores a key inside the transaction that stores its answer, and removes keys that are too old.
pub(super) async fn keep_key(
    tx: &mut Tx<'_>,
    used: Option<&KeyUse>,
    answer: Answer<'_>,
    now: &str,
) -> Result<(), sqlx::Error> {
    let Some(KeyUse { key, fingerprint, since, farthest, not_before }) = used else { return Ok(()) };
    let (job, calibration, machine, revision, wear) = match answer {
        Answer::Job(id) => (Some(id), None, None, None, None),
        Answer::Calibration(id) => (None, Some(id), None, None, None),
        Answer::Revision(machine, revision) => (None, None, Some(machine), Some(revision), None),
        Answer::Wear(first) => (None, None, None, None, Some(first)),
    };
    forget_keys(tx, since, farthest).await?;
    let at = now.max(not_before.as_str());
    sql!(
        tx,
        execute,
        "INSERT INTO idempotency_keys (idempotency_key, fingerprint, job_id, calibration_id, machine_id,
             machine_revision, wear_entry_id, created_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8)",
        key,
        fingerprint,
        job,
        calibration,
        machine,
        revision,
        wear,
        at
    )?;
    Ok(())
}

/// Removes the keys used before `since`; a key stored as used after `farthest` counts as used then.
pub(super) async fn forget_keys(tx: &mut Tx<'_>, since: &str, farthest: &str) -> Result<(), sqlx::Error> {
    sql!(tx, execute, "DELETE FROM idempotency_keys WHERE created_at < $1", since)?;
    sql!(
        tx,
        execute,
        "UPDATE idempotency_keys SET created_at = $1 WHERE created_at > $2",
        farthest,
        farthest
    )?;
    Ok(())
}

/// Whether a row with a new id was stored; `false` if its key was used in the meantime. Ids are new, so only the key
/// can already exist.
pub(super) fn unless_key_taken(stored: Result<(), StoreError>) -> Result<bool, StoreError> {
    match stored {
        Ok(()) => Ok(true),
        Err(StoreError::Statement { source: sqlx::Error::Database(fault), .. })
            if fault.kind() == ErrorKind::UniqueViolation =>
        {
            Ok(false)
        }
        Err(fault) => Err(fault),
    }
}

impl Store {
    /// What is remembered of an idempotency key.
    ///
    /// # Errors
    /// The database failed.
    pub async fn remembered(&self, used: &KeyUse) -> Result<Option<Remembered>, StoreError> {
        let (key, since) = (&used.key, &used.since);
        let row = sql!(
            self.db,
            optional(StoredUse),
            "SELECT fingerprint, job_id, k.calibration_id, c.machine_id AS calibrated, k.machine_id, k.machine_revision,
                 wear_entry_id
             FROM idempotency_keys k LEFT JOIN calibrations c ON c.id = k.calibration_id
             WHERE idempotency_key = $1 AND k.created_at >= $2",
            key,
            since
        )
        .doing("reading an idempotency key")?;
        let Some(row) = row else { return Ok(None) };
        if row.fingerprint != used.fingerprint {
            return Ok(Some(Remembered::Other));
        }
        if let Some(id) = row.job_id {
            return Ok(self.job(&id).await?.map(|job| Remembered::Job(Box::new(job))));
        }
        if let (Some(id), Some(machine_id)) = (row.calibration_id, row.calibrated) {
            let found = self.calibration(&machine_id, &id).await?;
            return Ok(found.map(|calibration| Remembered::Calibration(Box::new(calibration))));
        }
        if let (Some(machine_id), Some(revision)) = (row.machine_id, row.machine_revision) {
            let found = self.machine_revision(&machine_id, revision).await?;
            return Ok(found.map(|revision| Remembered::Revision(Box::new(revision))));
        }
        if let Some(first) = row.wear_entry_id {
            return Ok(Some(Remembered::Wear(self.wear_posted_with(&first).await?)));
        }
        Ok(None)
    }
}

#[cfg(test)]
mod tests {
    use sqlx::Connection;
    use sqlx::sqlite::SqliteConnection;

    use super::*;

    #[tokio::test]
    async fn only_a_key_that_is_there_already_is_a_key_that_is_taken() {
        let mut memory = SqliteConnection::connect(":memory:").await.unwrap();
        let table = "CREATE TABLE used (key TEXT PRIMARY KEY, number INTEGER NOT NULL CHECK (number > 0))";
        sqlx::query(table).execute(&mut memory).await.unwrap();
        let mut stored = Vec::new();
        for row in ["('a', 1)", "('a', 2)", "('b', 0)", "('c', NULL)"] {
            let insert = format!("INSERT INTO used VALUES {row}");
            let done = sqlx::query(sqlx::AssertSqlSafe(insert)).execute(&mut memory).await;
            stored.push(unless_key_taken(done.map(drop).doing("storing a test")));
        }
        assert!(matches!(stored[..], [Ok(true), Ok(false), Err(_), Err(_)]), "{stored:?}");
    }
}
