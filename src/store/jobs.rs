//! Jobs: the computation, its machine and its bytes, and the idempotency keys of their requests.

use std::collections::{BTreeSet, HashSet};

use super::audit::{Actor, Change, audit};
use super::error::Doing;
use super::keys::{Answer, keep_key, unless_key_taken};
use super::machines::as_array;
use super::{Cursor, KeyUse, Page, Store, StoreError};
use crate::wire::{AuditAction, JobDocument, JobOperation};

pub use crate::wire::JobState;

/// A job as it is stored, its report still as text.
#[derive(Debug, Clone, PartialEq)]
pub struct JobRow {
    /// The job for clients.
    pub document: JobDocument,
    /// Name of the uploaded file, or a default name.
    pub file_name: String,
    /// The report as first answered.
    pub report: Option<String>,
    /// Digest of the report.
    pub report_sha256: Option<String>,
    /// The trace that the job belongs to, in the form of `traceparent`.
    pub traceparent: Option<String>,
    /// Number of motions that were checked in a compensated program.
    pub motions_checked: Option<i64>,
    /// Data that it was accepted with beside its parameters, as JSON text.
    pub accepted: Option<String>,
}

/// A successful job that is about to be stored.
#[derive(Debug, Clone, PartialEq)]
pub struct NewJob {
    /// The job for clients.
    pub document: JobDocument,
    /// Name of the uploaded file, or a default name.
    pub file_name: String,
    /// The report.
    pub report: String,
    /// Digest of the report.
    pub report_sha256: String,
    /// The steps behind the output, of this job and of earlier ones, separated by commas; `None` if the operation
    /// writes no program.
    pub steps: Option<String>,
    /// Number of motions that were checked in a compensated program.
    pub motions_checked: Option<i64>,
}

/// Filter of the jobs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct JobFilter {
    /// Only jobs of this machine.
    pub machine_id: Option<String>,
    /// Only jobs in this state.
    pub state: Option<JobState>,
    /// Only jobs with this client id.
    pub external_id: Option<String>,
    /// Only jobs with this operation.
    pub operation: Option<JobOperation>,
    /// Only jobs created at this time or later.
    pub created_after: Option<String>,
    /// Only jobs created before this time.
    pub created_before: Option<String>,
    /// Only jobs that read a program with this digest.
    pub input_sha256: Option<String>,
    /// Only jobs that wrote a program with this digest.
    pub output_sha256: Option<String>,
    /// Only jobs of these machines, if there is a list.
    pub machines: Option<BTreeSet<String>>,
}

row! {
    pub(super) struct StoredJob {
        pub(super) seq: i64,
        pub(super) id: String,
        pub(super) machine_id: String,
        pub(super) machine_revision: i64,
        pub(super) operation: String,
        pub(super) parameters: String,
        pub(super) state: String,
        pub(super) progress: f64,
        pub(super) file_name: String,
        pub(super) input_sha256: String,
        pub(super) output_sha256: Option<String>,
        pub(super) report: Option<String>,
        pub(super) report_sha256: Option<String>,
        pub(super) problem: Option<String>,
        pub(super) external_id: Option<String>,
        pub(super) software_version: String,
        pub(super) created_at: String,
        pub(super) started_at: Option<String>,
        pub(super) finished_at: Option<String>,
        pub(super) surface_sha256: Option<String>,
        pub(super) changes_sha256: Option<String>,
        pub(super) attempts: i64,
        pub(super) callback_url: Option<String>,
        pub(super) traceparent: Option<String>,
        pub(super) motions_checked: Option<i64>,
        pub(super) accepted: Option<String>,
        #[expect(dead_code, reason = "looked for, never shown")]
        pub(super) steps: Option<String>,
        #[expect(dead_code, reason = "read by the queue, where it is")]
        pub(super) cancel_requested: i64,
        #[expect(dead_code, reason = "read by the queue, where it is")]
        pub(super) lease: Option<String>,
        pub(super) deaths: i64,
        #[expect(dead_code, reason = "read by the queue, where it is")]
        pub(super) lone_deaths: i64,
        pub(super) caller: Option<String>,
    }
}

impl StoredJob {
    pub(super) fn read(self) -> Result<JobRow, StoreError> {
        let id = self.id.clone();
        self.parse().map_err(|source| StoreError::Unreadable { what: "job", key: id, source })
    }

    fn parse(self) -> Result<JobRow, serde_json::Error> {
        let word = |text: String| serde_json::Value::String(text);
        let document = JobDocument {
            id: self.id,
            machine_id: self.machine_id,
            machine_revision: self.machine_revision,
            operation: serde_json::from_value::<JobOperation>(word(self.operation))?,
            parameters: serde_json::from_str(&self.parameters)?,
            state: serde_json::from_value::<JobState>(word(self.state))?,
            progress: self.progress,
            input_sha256: self.input_sha256,
            surface_sha256: self.surface_sha256,
            output_sha256: self.output_sha256,
            changes_sha256: self.changes_sha256,
            external_id: self.external_id,
            callback_url: self.callback_url,
            attempts: self.attempts,
            problem: self.problem.as_deref().map(serde_json::from_str).transpose()?,
            software_version: self.software_version,
            created_at: self.created_at,
            started_at: self.started_at,
            finished_at: self.finished_at,
        };
        let (report, report_sha256) = (self.report, self.report_sha256);
        let (file_name, traceparent) = (self.file_name, self.traceparent);
        let (motions_checked, accepted) = (self.motions_checked, self.accepted);
        Ok(JobRow { document, file_name, report, report_sha256, traceparent, motions_checked, accepted })
    }
}

/// The entry of the audit log for a new job.
pub(super) fn created(job: &JobDocument) -> Change<'_> {
    Change {
        at: &job.created_at,
        action: AuditAction::JobCreated,
        machine_id: Some(&job.machine_id),
        resource: format!("/v1/jobs/{}", job.id),
        revisions: (None, None),
    }
}

impl Store {
    /// One job.
    ///
    /// # Errors
    /// The database failed.
    pub async fn job(&self, id: &str) -> Result<Option<JobRow>, StoreError> {
        let row = sql!(self.db, optional(StoredJob), "SELECT * FROM jobs WHERE id = $1", id)
            .doing("reading a job")?;
        row.map(StoredJob::read).transpose()
    }

    /// A page of jobs, newest first.
    ///
    /// # Errors
    /// The database failed.
    pub async fn jobs(
        &self,
        filter: &JobFilter,
        limit: u32,
        before: Option<Cursor>,
    ) -> Result<Page<JobRow>, StoreError> {
        let (before, count) = (before.map_or(i64::MAX, |cursor| cursor.0), i64::from(limit) + 1);
        let (machine_id, external_id) = (filter.machine_id.as_deref(), filter.external_id.as_deref());
        let (state, operation) =
            (filter.state.map(JobState::as_str), filter.operation.map(JobOperation::as_str));
        let (created_after, created_before) =
            (filter.created_after.as_deref(), filter.created_before.as_deref());
        let machines = as_array(filter.machines.as_ref());
        let (input_sha256, output_sha256) = (filter.input_sha256.as_deref(), filter.output_sha256.as_deref());
        /// The statement whose first condition an index answers; the others only look at the rows that this one finds.
        macro_rules! listed {
            ($first:tt) => {
                sql!(
                    self.db,
                    all(StoredJob),
                    "SELECT * FROM jobs WHERE " + $first + " AND seq < $1
                       AND (CAST($2 AS TEXT) IS NULL OR machine_id = $2) AND (CAST($3 AS TEXT) IS NULL OR state = $3)
                       AND (CAST($4 AS TEXT) IS NULL OR external_id = $4)
                       AND (CAST($5 AS TEXT) IS NULL OR operation = $5)
                       AND (CAST($6 AS TEXT) IS NULL OR created_at >= $6)
                       AND (CAST($7 AS TEXT) IS NULL OR created_at < $7)
                       AND (CAST($8 AS TEXT) IS NULL OR machine_id IN (SELECT value FROM json_each($8)))
                       AND (CAST($9 AS TEXT) IS NULL OR input_sha256 = $9)
                       AND (CAST($10 AS TEXT) IS NULL OR output_sha256 = $10)
                     ORDER BY seq DESC LIMIT $11",
                    before,
                    machine_id,
                    state,
                    external_id,
                    operation,
                    created_after,
                    created_before,
                    machines,
                    input_sha256,
                    output_sha256,
                    count
                )
            };
        }
        let rows = match (input_sha256, output_sha256, external_id) {
            (Some(_), _, _) => listed!("input_sha256 = $9"),
            (None, Some(_), _) => listed!("output_sha256 = $10"),
            (None, None, Some(_)) => listed!("external_id = $4"),
            (None, None, None) => listed!("TRUE"),
        }
        .doing("listing jobs")?;
        let read = rows.into_iter().map(|row| Ok((row.seq, row.read()?)));
        Ok(Page::cut(read.collect::<Result<_, StoreError>>()?, limit))
    }

    /// Stores a job together with the idempotency key of its request, and removes keys that are too old. `false` if
    /// the key was used in the meantime; nothing is stored then.
    ///
    /// # Errors
    /// The database failed.
    pub async fn add_job(&self, job: &NewJob, used: Option<&KeyUse>, by: &Actor) -> Result<bool, StoreError> {
        let NewJob { document, file_name, report, report_sha256, steps, motions_checked } = job.clone();
        let (used, by) = (used.cloned(), by.clone());
        let parameters = document.parameters.to_string();
        let added = self
            .write("storing a job", |tx| {
                Box::pin(async move {
                    let (operation, state) = (document.operation.as_str(), document.state.as_str());
                    sql!(
                        tx,
                        execute,
                        "INSERT INTO jobs (id, machine_id, machine_revision, operation, parameters, state, progress,
                             file_name, input_sha256, surface_sha256, output_sha256, changes_sha256, report,
                             report_sha256, external_id, software_version, created_at, started_at, finished_at,
                             steps, motions_checked)
                         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, $16, $17,
                             $18, $19, $20, $21)",
                        document.id,
                        document.machine_id,
                        document.machine_revision,
                        operation,
                        parameters,
                        state,
                        document.progress,
                        file_name,
                        document.input_sha256,
                        document.surface_sha256,
                        document.output_sha256,
                        document.changes_sha256,
                        report,
                        report_sha256,
                        document.external_id,
                        document.software_version,
                        document.created_at,
                        document.started_at,
                        document.finished_at,
                        steps,
                        motions_checked
                    )?;
                    let answer = Answer::Job(&document.id);
                    keep_key(tx, used.as_ref(), answer, &document.created_at).await?;
                    audit(tx, &by, created(&document)).await?;
                    Ok(())
                })
            })
            .await;
        unless_key_taken(added)
    }

    /// The steps behind a program with this digest, if jobs made it from another program, on any of these machines if there is a
    /// list; the steps of each job are separated by commas.
    ///
    /// # Errors
    /// The database failed.
    pub async fn steps_behind(
        &self,
        sha256: &str,
        machines: Option<&BTreeSet<String>>,
    ) -> Result<Vec<String>, StoreError> {
        let machines = as_array(machines);
        let rows = sql!(
            self.db,
            all(_),
            "SELECT DISTINCT steps AS \"steps!\" FROM jobs
             WHERE output_sha256 = $1 AND steps <> '' AND input_sha256 <> $1
               AND (CAST($2 AS TEXT) IS NULL OR machine_id IN (SELECT value FROM json_each($2)))",
            sha256,
            machines
        )
        .doing("looking for what a program was made from")?;
        Ok(rows)
    }

    /// Digests of every file that a job names.
    ///
    /// # Errors
    /// The database failed.
    pub async fn named_blobs(&self) -> Result<HashSet<String>, StoreError> {
        let rows = sql!(
            self.db,
            all(_),
            "SELECT input_sha256 AS \"sha256!\" FROM jobs
             UNION SELECT output_sha256 FROM jobs WHERE output_sha256 IS NOT NULL
             UNION SELECT surface_sha256 FROM jobs WHERE surface_sha256 IS NOT NULL
             UNION SELECT changes_sha256 FROM jobs WHERE changes_sha256 IS NOT NULL"
        )
        .doing("listing the files in use")?;
        Ok(rows.into_iter().collect())
    }
}
