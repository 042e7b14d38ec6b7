//! The queue of jobs: what is accepted waits here, is taken under a lease, and ends once. Everything that must be
//! true at one moment happens in one transaction, so that another database can take this one's place statement by
//! statement (`docs/architecture.md`).

use serde_json::Value;

use super::audit::{Actor, Change, audit};
use super::error::Doing;
use super::jobs::{StoredJob, created};
use super::keys::{Answer, keep_key, unless_key_taken};
use super::{JobRow, JobState, KeyUse, Store, StoreError};
use crate::wire::AuditAction;

/// What became of a job that was to be queued.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Enqueued {
    /// It waits.
    Added,
    /// Its key was used in the meantime; nothing is stored.
    KeyTaken,
    /// As many wait as may; nothing is stored.
    Full,
}

/// A job taken from the queue.
#[derive(Debug, Clone, PartialEq)]
pub struct Claimed {
    /// The job.
    pub job: JobRow,
    /// What its ending is signed with.
    pub lease: String,
}

/// How a job ends.
#[derive(Debug, Clone, PartialEq)]
pub enum Ending {
    /// With a result, whose files are kept already.
    Succeeded {
        /// The report, as JSON text.
        report: String,
        /// Its digest.
        report_sha256: String,
        /// Digest of the program or the table it made.
        output_sha256: Option<String>,
        /// Digest of the table of changes.
        changes_sha256: Option<String>,
        /// The steps that changed the program, separated by commas; none where the operation has no steps.
        steps: Option<String>,
        /// Motions of a compensated program that were looked at.
        motions_checked: Option<i64>,
    },
    /// Without one.
    Failed {
        /// Why: a problem document.
        problem: Value,
    },
}

/// What became of a job whose holder gave it back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GivenBack {
    /// It waits again, as if it had never been taken.
    Queued,
    /// Its client had cancelled it.
    Cancelled,
    /// The lease was not valid any more.
    Nothing,
}

/// What became of a job that was to be cancelled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cancelling {
    /// There is none.
    Unknown,
    /// It waited, and is cancelled now.
    Cancelled,
    /// It was cancelled before.
    Already,
    /// It runs, and is cancelled as soon as it stops.
    Requested,
    /// It has ended otherwise.
    Ended(JobState),
}

/// What a process that died left behind.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Recovered {
    /// Jobs that wait again.
    pub queued: u64,
    /// Jobs that were running when the process died, and died again: failed.
    pub parked: Vec<String>,
    /// Jobs that their clients had cancelled.
    pub cancelled: Vec<String>,
}

/// How much waits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct QueueDepth {
    /// Jobs that wait.
    pub queued: i64,
    /// Jobs that run.
    pub running: i64,
    /// Since when the oldest of those that wait does.
    pub oldest: Option<String>,
}

/// Computations after which a job is held to be what kills the process.
const MAX_ATTEMPTS: i64 = 2;

impl Store {
    /// Queues a job together with the key it was asked under, unless `max_queued` wait already.
    ///
    /// # Errors
    /// The database failed.
    pub async fn enqueue(
        &self,
        job: &JobRow,
        used: Option<&KeyUse>,
        by: &Actor,
        max_queued: usize,
    ) -> Result<Enqueued, StoreError> {
        let (JobRow { document, file_name, traceparent, accepted, .. }, used, by) =
            (job.clone(), used.cloned(), by.clone());
        let parameters = document.parameters.to_string();
        let max_queued = i64::try_from(max_queued).unwrap_or(i64::MAX);
        let added = self
            .write("queueing a job", |connection| {
                Box::pin(async move {
                    let waiting =
                        sqlx::query_scalar!("SELECT count(*) FROM jobs WHERE state = 'queued'")
                            .fetch_one(&mut *connection)
                            .await?;
                    if waiting >= max_queued {
                        return Ok(false);
                    }
                    let operation = document.operation.as_str();
                    sqlx::query!(
                        "INSERT INTO jobs (id, machine_id, machine_revision, operation, parameters, state, progress,
                             file_name, input_sha256, surface_sha256, external_id, callback_url, attempts,
                             software_version, created_at, traceparent, accepted)
                         VALUES (?, ?, ?, ?, ?, 'queued', 0, ?, ?, ?, ?, ?, 0, ?, ?, ?, ?)",
                        document.id,
                        document.machine_id,
                        document.machine_revision,
                        operation,
                        parameters,
                        file_name,
                        document.input_sha256,
                        document.surface_sha256,
                        document.external_id,
                        document.callback_url,
                        document.software_version,
                        document.created_at,
                        traceparent,
                        accepted,
                    )
                    .execute(&mut *connection)
                    .await?;
                    let answer = Answer::Job(&document.id);
                    keep_key(connection, used.as_ref(), answer, &document.created_at).await?;
                    audit(connection, &by, created(&document)).await?;
                    Ok(true)
                })
            })
            .await;
        match added {
            Ok(false) => Ok(Enqueued::Full),
            added => unless_key_taken(added.map(|_added| ()))
                .map(|added| if added { Enqueued::Added } else { Enqueued::KeyTaken }),
        }
    }

    /// Takes the next job: first what was running when the process died, then of the machine that was served longest
    /// ago the one that waits longest.
    ///
    /// # Errors
    /// The database failed.
    pub async fn claim(&self, lease: &str, now: &str, version: &str) -> Result<Option<Claimed>, StoreError> {
        let (lease, now, version) = (lease.to_owned(), now.to_owned(), version.to_owned());
        let holder = lease.clone();
        let taken = self
            .write("taking a job", |connection| {
                Box::pin(async move {
                    let next = sqlx::query!(
                        "SELECT id, j.machine_id FROM jobs j LEFT JOIN job_turns t ON t.machine_id = j.machine_id
                         WHERE state = 'queued' ORDER BY attempts = 0, coalesce(turn, 0), seq LIMIT 1"
                    )
                    .fetch_optional(&mut *connection)
                    .await?;
                    let Some(next) = next else { return Ok(None) };
                    sqlx::query!(
                        "INSERT INTO job_turns (machine_id, turn)
                         VALUES (?, (SELECT coalesce(max(turn), 0) + 1 FROM job_turns))
                         ON CONFLICT (machine_id) DO UPDATE SET turn = excluded.turn",
                        next.machine_id
                    )
                    .execute(&mut *connection)
                    .await?;
                    sqlx::query!(
                        "UPDATE jobs SET state = 'running', attempts = attempts + 1, lease = ?, started_at = ?,
                             software_version = ?
                         WHERE id = ? AND state = 'queued'",
                        lease,
                        now,
                        version,
                        next.id
                    )
                    .execute(&mut *connection)
                    .await?;
                    sqlx::query_as!(StoredJob, "SELECT * FROM jobs WHERE id = ?", next.id)
                        .fetch_optional(&mut *connection)
                        .await
                })
            })
            .await?;
        taken.map(|row| Ok(Claimed { job: row.read()?, lease: holder })).transpose()
    }

    /// Ends a job. `false` when the lease is not valid any more, or the client has cancelled: give it back then.
    ///
    /// # Errors
    /// The database failed.
    pub async fn end_job(
        &self,
        id: &str,
        lease: &str,
        ending: &Ending,
        now: &str,
    ) -> Result<bool, StoreError> {
        let (id, lease, now) = (id.to_owned(), lease.to_owned(), now.to_owned());
        let ending = ending.clone();
        self.write("ending a job", |connection| {
            Box::pin(async move {
                let done = match ending {
                    Ending::Succeeded {
                        report,
                        report_sha256,
                        output_sha256,
                        changes_sha256,
                        steps,
                        motions_checked,
                    } => {
                        sqlx::query!(
                            "UPDATE jobs SET state = 'succeeded', progress = 1, report = ?, report_sha256 = ?,
                                 output_sha256 = ?, changes_sha256 = ?, steps = ?, motions_checked = ?,
                                 finished_at = ?, lease = NULL
                             WHERE id = ? AND state = 'running' AND lease = ? AND cancel_requested = 0",
                            report,
                            report_sha256,
                            output_sha256,
                            changes_sha256,
                            steps,
                            motions_checked,
                            now,
                            id,
                            lease
                        )
                        .execute(&mut *connection)
                        .await?
                    }
                    Ending::Failed { problem } => {
                        let problem = problem.to_string();
                        sqlx::query!(
                            "UPDATE jobs SET state = 'failed', problem = ?, finished_at = ?, lease = NULL
                             WHERE id = ? AND state = 'running' AND lease = ? AND cancel_requested = 0",
                            problem,
                            now,
                            id,
                            lease
                        )
                        .execute(&mut *connection)
                        .await?
                    }
                };
                Ok(done.rows_affected() == 1)
            })
        })
        .await
    }

    /// Gives a job back that is not computed to its end: it waits again and this attempt does not count, or it is
    /// cancelled where its client wanted that.
    ///
    /// # Errors
    /// The database failed.
    pub async fn give_back(&self, id: &str, lease: &str, now: &str) -> Result<GivenBack, StoreError> {
        let (id, lease, now) = (id.to_owned(), lease.to_owned(), now.to_owned());
        let state = self
            .write("giving a job back", |connection| {
                Box::pin(async move {
                    sqlx::query_scalar!(
                        "UPDATE jobs SET state = iif(cancel_requested, 'cancelled', 'queued'),
                             attempts = iif(cancel_requested, attempts, attempts - 1),
                             started_at = iif(cancel_requested, started_at, NULL),
                             finished_at = iif(cancel_requested, ?, NULL), lease = NULL
                         WHERE id = ? AND state = 'running' AND lease = ?
                         RETURNING state",
                        now,
                        id,
                        lease
                    )
                    .fetch_optional(&mut *connection)
                    .await
                })
            })
            .await?;
        Ok(match state.as_deref() {
            None => GivenBack::Nothing,
            Some("cancelled") => GivenBack::Cancelled,
            Some(_) => GivenBack::Queued,
        })
    }

    /// Cancels a job that waits, or asks for one that runs to be stopped.
    ///
    /// # Errors
    /// The database failed.
    pub async fn cancel_job(&self, id: &str, by: &Actor, now: &str) -> Result<Cancelling, StoreError> {
        let (id, by, now) = (id.to_owned(), by.clone(), now.to_owned());
        self.write("cancelling a job", |connection| {
            Box::pin(async move {
                let job =
                    sqlx::query!("SELECT state, machine_id, cancel_requested FROM jobs WHERE id = ?", id)
                        .fetch_optional(&mut *connection)
                        .await?;
                let Some(job) = job else { return Ok(Cancelling::Unknown) };
                let done = match job.state.as_str() {
                    "queued" => {
                        sqlx::query!(
                            "UPDATE jobs SET state = 'cancelled', cancel_requested = 1, finished_at = ?
                             WHERE id = ?",
                            now,
                            id
                        )
                        .execute(&mut *connection)
                        .await?;
                        Cancelling::Cancelled
                    }
                    "running" => {
                        sqlx::query!("UPDATE jobs SET cancel_requested = 1 WHERE id = ?", id)
                            .execute(&mut *connection)
                            .await?;
                        Cancelling::Requested
                    }
                    "cancelled" => Cancelling::Already,
                    "failed" => Cancelling::Ended(JobState::Failed),
                    _ => Cancelling::Ended(JobState::Succeeded),
                };
                // Asked for once more, nothing changes.
                if matches!(done, Cancelling::Cancelled | Cancelling::Requested) && job.cancel_requested == 0
                {
                    let change = Change {
                        at: &now,
                        action: AuditAction::JobCancelled,
                        machine_id: Some(&job.machine_id),
                        resource: format!("/v1/jobs/{id}"),
                        revisions: (None, None),
                    };
                    audit(connection, &by, change).await?;
                }
                Ok(done)
            })
        })
        .await
    }

    /// Takes up what a process that died was computing: what its client had cancelled is cancelled, what was running
    /// at two deaths is failed with `problem`, all else waits again. Only for the start.
    ///
    /// # Errors
    /// The database failed.
    pub async fn recover_jobs(&self, problem: &Value, now: &str) -> Result<Recovered, StoreError> {
        let (problem, now) = (problem.to_string(), now.to_owned());
        self.write("taking up jobs", |connection| {
            Box::pin(async move {
                let cancelled = sqlx::query_scalar!(
                    "UPDATE jobs SET state = 'cancelled', finished_at = ?, lease = NULL
                     WHERE state = 'running' AND cancel_requested = 1 RETURNING id",
                    now
                )
                .fetch_all(&mut *connection)
                .await?;
                let parked = sqlx::query_scalar!(
                    "UPDATE jobs SET state = 'failed', problem = ?, finished_at = ?, lease = NULL
                     WHERE state = 'running' AND attempts >= ? RETURNING id",
                    problem,
                    now,
                    MAX_ATTEMPTS
                )
                .fetch_all(&mut *connection)
                .await?;
                let queued = sqlx::query!(
                    "UPDATE jobs SET state = 'queued', started_at = NULL, lease = NULL WHERE state = 'running'"
                )
                .execute(&mut *connection)
                .await?;
                Ok(Recovered { queued: queued.rows_affected(), parked, cancelled })
            })
        })
        .await
    }

    /// How much waits and runs.
    ///
    /// # Errors
    /// The database failed.
    pub async fn queue_depth(&self) -> Result<QueueDepth, StoreError> {
        let row = sqlx::query!(
            "SELECT (SELECT count(*) FROM jobs WHERE state = 'queued') AS \"queued!: i64\",
                 (SELECT count(*) FROM jobs WHERE state = 'running') AS \"running!: i64\",
                 (SELECT created_at FROM jobs WHERE state = 'queued' ORDER BY seq LIMIT 1) AS \"oldest: String\""
        )
        .fetch_one(&self.readers)
        .await
        .doing("measuring the queue")?;
        Ok(QueueDepth { queued: row.queued, running: row.running, oldest: row.oldest })
    }
}
