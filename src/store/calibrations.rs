//! Calibration runs: appended, never changed.

use std::collections::BTreeSet;

use super::audit::{Actor, Change, audit};
use super::calibration_errors::error_rows;
use super::error::Doing;
use super::keys::{Answer, keep_key, unless_key_taken};
use super::machines::as_array;
use super::{Cursor, KeyUse, Page, Store, StoreError};
use crate::wire::{AuditAction, CalibrationDocument, CalibrationKind, TrendPoint};

/// A stored run.
#[derive(Debug, Clone, PartialEq)]
pub struct CalibrationRow {
    /// The document, as first answered.
    pub text: String,
    /// The same document, parsed.
    pub document: CalibrationDocument,
    /// Digest of the text.
    pub document_sha256: String,
    /// The posted run, normalised.
    pub run: String,
}

/// A run to store.
#[derive(Debug, Clone, PartialEq)]
pub struct NewCalibration {
    /// The document for clients.
    pub document: CalibrationDocument,
    /// The document as text.
    pub text: String,
    /// Digest of the text.
    pub document_sha256: String,
    /// The posted run, normalised; its digest is in the document.
    pub run: String,
}

/// Filter of the runs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct CalibrationFilter {
    /// Only runs of this kind.
    pub kind: Option<CalibrationKind>,
    /// Only runs measured at this time or later.
    pub measured_from: Option<String>,
    /// Only runs measured at this time or earlier.
    pub measured_to: Option<String>,
}

/// The error and the machine of a trend.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TrendQuery<'a> {
    /// The machine.
    pub machine_id: &'a str,
    /// Letter of the axis.
    pub axis: &'a str,
    /// Name of the error without its unit.
    pub error: &'a str,
    /// Only runs measured at this time or later.
    pub measured_from: Option<&'a str>,
    /// Only runs measured at this time or earlier.
    pub measured_to: Option<&'a str>,
    /// Largest number of runs; the newest are taken.
    pub limit: i64,
}

row! {
    /// One time that a run was applied.
    #[derive(Debug, Clone, PartialEq, Eq)]
    pub struct CalibrationUse {
        /// The revision of the machine that has the errors of the run.
        pub revision: i64,
        /// Time of the revision.
        pub at: String,
        /// The key of the request; `None` if the service needed none.
        pub key_id: Option<String>,
    }
}

row! {
    /// The newest measurement of one machine.
    #[derive(Debug, Clone, PartialEq)]
    pub struct CalibrationAge {
        /// The machine.
        pub machine_id: String,
        /// Time of the newest measurement; `None` if the machine was never calibrated.
        pub measured_at: Option<String>,
        /// The period that the current profile states.
        pub due_days: Option<f64>,
    }
}

row! {
    /// A run in a list, without its readings.
    struct ListedCalibration {
        seq: i64,
        id: String,
        document: String,
        document_sha256: String,
    }
}

row! {
    /// One error of a run.
    struct StoredTrendPoint {
        calibration_id: String,
        measured_at: String,
        machine_revision: i64,
        value: f64,
        standard_uncertainty: Option<f64>,
        identifiable: i64,
    }
}

row! {
    struct StoredCalibration {
        id: String,
        document: String,
        document_sha256: String,
        run: String,
        run_sha256: String,
    }
}

impl StoredCalibration {
    fn read(self, store: &Store) -> Result<CalibrationRow, StoreError> {
        let Self { id, document: text, document_sha256, run, run_sha256 } = self;
        store.verify(|| format!("run of calibration {id}"), &run, &run_sha256)?;
        let document = read(store, id, &text, &document_sha256)?;
        Ok(CalibrationRow { text, document, document_sha256, run })
    }
}

fn read(store: &Store, id: String, text: &str, sha256: &str) -> Result<CalibrationDocument, StoreError> {
    store.verify(|| format!("calibration {id}"), text, sha256)?;
    serde_json::from_str(text).map_err(|source| StoreError::Unreadable {
        what: "calibration",
        key: id,
        source,
    })
}

impl Store {
    /// One run of a machine.
    ///
    /// # Errors
    /// The database failed.
    pub async fn calibration(
        &self,
        machine_id: &str,
        id: &str,
    ) -> Result<Option<CalibrationRow>, StoreError> {
        let row = sql!(
            self.db,
            optional(StoredCalibration),
            "SELECT id, document, document_sha256, run, run_sha256 FROM calibrations WHERE id = $1 AND machine_id = $2",
            id,
            machine_id
        )
        .doing("reading a calibration")?;
        row.map(|row| row.read(self)).transpose()
    }

    /// A page of the results of a machine's runs, newest stored first. Their readings, which may be megabytes each,
    /// are not read.
    ///
    /// # Errors
    /// The database failed.
    pub async fn calibrations(
        &self,
        machine_id: &str,
        filter: &CalibrationFilter,
        limit: u32,
        before: Option<Cursor>,
    ) -> Result<Page<CalibrationDocument>, StoreError> {
        let (before, count) = (before.map_or(i64::MAX, |cursor| cursor.0), i64::from(limit) + 1);
        let kind = filter.kind.map(CalibrationKind::as_str);
        let (from, to) = (filter.measured_from.as_deref(), filter.measured_to.as_deref());
        let rows = sql!(
            self.db,
            all(ListedCalibration),
            "SELECT seq, id, document, document_sha256 FROM calibrations
             WHERE machine_id = $1 AND seq < $2 AND (CAST($3 AS TEXT) IS NULL OR kind = $3)
               AND (CAST($4 AS TEXT) IS NULL OR measured_at >= $4)
               AND (CAST($5 AS TEXT) IS NULL OR measured_at <= $5)
             ORDER BY seq DESC LIMIT $6",
            machine_id,
            before,
            kind,
            from,
            to,
            count
        )
        .doing("listing calibrations")?;
        let read = rows
            .into_iter()
            .map(|row| Ok((row.seq, read(self, row.id, &row.document, &row.document_sha256)?)));
        Ok(Page::cut(read.collect::<Result<_, StoreError>>()?, limit))
    }

    /// The trend of one error, oldest first; if there are more runs than the limit, the newest.
    ///
    /// # Errors
    /// The database failed.
    pub async fn calibration_trend(&self, wanted: &TrendQuery<'_>) -> Result<Vec<TrendPoint>, StoreError> {
        let TrendQuery { machine_id, axis, error, measured_from, measured_to, limit } = wanted;
        let from = measured_from.unwrap_or("");
        // After every possible time.
        let to = measured_to.unwrap_or("~");
        let rows = sql!(
            self.db,
            all(StoredTrendPoint),
            "SELECT calibration_id, measured_at, machine_revision, value, standard_uncertainty, identifiable
             FROM calibration_errors
             WHERE machine_id = $1 AND axis = $2 AND error = $3 AND measured_at >= $4 AND measured_at <= $5
             ORDER BY measured_at DESC, calibration_seq DESC LIMIT $6",
            machine_id,
            axis,
            error,
            from,
            to,
            limit
        )
        .doing("reading a trend")?;
        let oldest_first = rows.into_iter().rev();
        Ok(oldest_first
            .map(|row| TrendPoint {
                calibration_id: row.calibration_id,
                measured_at: row.measured_at,
                machine_revision: row.machine_revision,
                value: row.value,
                standard_uncertainty: row.standard_uncertainty,
                identifiable: row.identifiable != 0,
            })
            .collect())
    }

    /// Ids of the runs whose errors any revision of a machine has.
    ///
    /// # Errors
    /// The database failed.
    pub async fn applied_calibrations(&self, machine_id: &str) -> Result<BTreeSet<String>, StoreError> {
        let rows: Vec<Option<String>> = sql!(
            self.db,
            all(_),
            "SELECT DISTINCT calibration_id FROM machine_revisions
             WHERE machine_id = $1 AND calibration_id IS NOT NULL",
            machine_id
        )
        .doing("listing applied calibrations")?;
        Ok(rows.into_iter().flatten().collect())
    }

    /// The times that a run was applied, oldest first; the first hundred.
    ///
    /// # Errors
    /// The database failed.
    pub async fn calibration_uses(
        &self,
        machine_id: &str,
        id: &str,
    ) -> Result<Vec<CalibrationUse>, StoreError> {
        sql!(
            self.db,
            all(CalibrationUse),
            "SELECT r.revision, r.created_at AS at, a.key_id FROM machine_revisions r
             LEFT JOIN audit a ON a.machine_id = r.machine_id AND a.revision_after = r.revision
                 AND a.action = 'calibration-applied'
             WHERE r.machine_id = $1 AND r.calibration_id = $2 ORDER BY r.revision LIMIT 100",
            machine_id,
            id
        )
        .doing("reading the uses of a calibration")
    }

    /// The newest measurement of each machine, oldest machine first; only of these machines, if there is a list.
    ///
    /// # Errors
    /// The database failed.
    pub async fn calibration_ages(
        &self,
        only: Option<&BTreeSet<String>>,
        limit: u32,
    ) -> Result<Vec<CalibrationAge>, StoreError> {
        let (only, limit) = (as_array(only), i64::from(limit));
        // They differ only in how they read a member of a document.
        sql!(
            self.db,
            all(CalibrationAge),
            sqlite "SELECT m.machine_id,
                 (SELECT MAX(c.measured_at) FROM calibrations c WHERE c.machine_id = m.machine_id) AS \"measured_at?\",
                 CAST(r.profile ->> '$.calibration_due_days' AS REAL) AS \"due_days?: _\"
             FROM machines m
             JOIN machine_revisions r ON r.machine_id = m.machine_id AND r.revision = m.last_revision
             WHERE m.deleted = 0
               AND (CAST($1 AS TEXT) IS NULL OR m.machine_id IN (SELECT value FROM json_each($1)))
             ORDER BY m.seq LIMIT $2",
            postgres "SELECT m.machine_id,
                 (SELECT MAX(c.measured_at) FROM calibrations c WHERE c.machine_id = m.machine_id) AS \"measured_at?\",
                 CAST(CAST(r.profile AS json) ->> 'calibration_due_days' AS DOUBLE PRECISION) AS \"due_days?: _\"
             FROM machines m
             JOIN machine_revisions r ON r.machine_id = m.machine_id AND r.revision = m.last_revision
             WHERE m.deleted = 0
               AND (CAST($1 AS TEXT) IS NULL OR m.machine_id IN (SELECT value FROM json_each($1)))
             ORDER BY m.seq LIMIT $2",
            only,
            limit
        )
        .doing("reading the ages of calibrations")
    }

    /// Stores a run with its errors and the idempotency key of its request. `false` if the key was used in the
    /// meantime; nothing is stored then.
    ///
    /// # Errors
    /// The database failed.
    pub async fn add_calibration(
        &self,
        new: &NewCalibration,
        used: Option<&KeyUse>,
        actor: &Actor,
    ) -> Result<bool, StoreError> {
        let NewCalibration { document, text, document_sha256, run } = new.clone();
        let (used, actor) = (used.cloned(), actor.clone());
        let added = self
            .write("storing a calibration", |tx| {
                Box::pin(async move {
                    let kind = document.kind.as_str();
                    let seq: i64 = sql!(
                        tx,
                        one(_),
                        "INSERT INTO calibrations (id, machine_id, machine_revision, kind, measured_at, created_at,
                             run, run_sha256, document, document_sha256)
                         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10) RETURNING seq AS \"seq!\"",
                        document.id,
                        document.machine_id,
                        document.machine_revision,
                        kind,
                        document.measured_at,
                        document.created_at,
                        run,
                        document.run_sha256,
                        text,
                        document_sha256
                    )?
;
                    for row in error_rows(&document) {
                        let identifiable = i64::from(row.identifiable);
                        sql!(
                            tx,
                            execute,
                            "INSERT INTO calibration_errors (machine_id, axis, error, measured_at, calibration_seq,
                                 calibration_id, machine_revision, value, standard_uncertainty, identifiable)
                             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)",
                            document.machine_id,
                            row.axis,
                            row.error,
                            document.measured_at,
                            seq,
                            document.id,
                            document.machine_revision,
                            row.value,
                            row.standard_uncertainty,
                            identifiable
                        )?;
                    }
                    let machine_id = &document.machine_id;
                    let change = Change {
                        at: &document.created_at,
                        action: AuditAction::CalibrationCreated,
                        machine_id: Some(machine_id),
                        resource: format!("/v1/machines/{machine_id}/calibrations/{}", document.id),
                        revisions: (None, None),
                    };
                    audit(tx, &actor, change).await?;
                    let answer = Answer::Calibration(&document.id);
                    keep_key(tx, used.as_ref(), answer, &document.created_at).await?;
                    Ok(())
                })
            })
            .await;
        unless_key_taken(added)
    }
}
