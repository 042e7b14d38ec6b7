//! The queue of jobs: what is accepted waits here, is taken under a lease, and ends once. Everything that must be
//! true at one moment happens in one transaction, so that another database can take this one's place statement by
//! statement (`docs/architecture.md`).

use serde_json::Value;

use super::audit::{Actor, Change, audit};
use super::error::Doing;
use super::jobs::{StoredJob, created};
use super::keys::{Answer, keep_key, unless_key_taken};
use super::{JobRow, JobState, KeyUse, Store, StoreError};
use crate::shares::{NoShare, Quota, Share, Who};
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
    /// As many of this caller's wait as may; nothing is stored.
    NoShare(NoShare),
}

/// Who asks for a job, and how many may wait.
#[derive(Debug, Clone, PartialEq)]
pub struct QueueRoom {
    /// Of all callers.
    pub max_queued: usize,
    /// The part of one caller.
    pub share: Share,
    /// The caller.
    pub caller: Who,
}

impl QueueRoom {
    /// Whether one more of the caller's may wait beside so many, of which so many are its own.
    ///
    /// # Errors
    /// It may not.
    pub fn check(&self, waiting: i64, own: i64) -> Result<(), NoShare> {
        let count = |number: i64| u64::try_from(number).unwrap_or(0);
        let (waiting, own) = (count(waiting), count(own));
        let others = waiting.saturating_sub(own);
        self.share.check(Quota::QueuedJobs, self.max_queued as u64, others, own, 1)
    }
}

/// A job taken from the queue.
#[derive(Debug, Clone, PartialEq)]
pub struct Claimed {
    /// The job.
    pub job: JobRow,
    /// What its ending is signed with.
    pub lease: String,
    /// Who asked for it, where that is known.
    pub caller: Option<String>,
    /// Deaths of the process while it was computed beside others.
    pub deaths: i64,
}

impl Claimed {
    /// Whether it is to be computed alone.
    #[must_use]
    pub fn is_suspect(&self) -> bool {
        self.deaths >= DEATHS_BESIDE_OTHERS
    }
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

/// Deaths of the process that a job may meet beside others before it is computed alone: whose fault they were is not known.
pub const DEATHS_BESIDE_OTHERS: i64 = 3;

/// Turns after which a caller's is forgotten, so that the table does not grow with all who ever asked.
const TURNS_REMEMBERED: i64 = 10_000;

impl Store {
    /// Queues a job together with the key it was asked under, unless there is no room for one more of its caller's.
    ///
    /// # Errors
    /// The database failed.
    pub async fn enqueue(
        &self,
        job: &JobRow,
        used: Option<&KeyUse>,
        by: &Actor,
        room: &QueueRoom,
    ) -> Result<Enqueued, StoreError> {
        let (JobRow { document, file_name, traceparent, accepted, .. }, used, by) =
            (job.clone(), used.cloned(), by.clone());
        let parameters = document.parameters.to_string();
        let (room, caller) = (room.clone(), room.caller.to_string());
        let added = self
            .write("queueing a job", |connection| {
                Box::pin(async move {
                    let waiting = sqlx::query!(
                        "SELECT count(*) AS \"all!: i64\", count(*) FILTER (WHERE caller = ?) AS \"own!: i64\"
                         FROM jobs WHERE state = 'queued'",
                        caller
                    )
                    .fetch_one(&mut *connection)
                    .await?;
                    if let Err(refused) = room.check(waiting.all, waiting.own) {
                        return Ok(Some(refused));
                    }
                    let operation = document.operation.as_str();
                    sqlx::query!(
                        "INSERT INTO jobs (id, machine_id, machine_revision, operation, parameters, state, progress,
                             file_name, input_sha256, surface_sha256, external_id, callback_url, attempts,
                             software_version, created_at, traceparent, accepted, caller)
                         VALUES (?, ?, ?, ?, ?, 'queued', 0, ?, ?, ?, ?, ?, 0, ?, ?, ?, ?, ?)",
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
                        caller,
                    )
                    .execute(&mut *connection)
                    .await?;
                    let answer = Answer::Job(&document.id);
                    keep_key(connection, used.as_ref(), answer, &document.created_at).await?;
                    audit(connection, &by, created(&document)).await?;
                    Ok(None)
                })
            })
            .await;
        match added {
            Ok(Some(NoShare::Full { .. })) => Ok(Enqueued::Full),
            Ok(Some(over @ NoShare::OverShare { .. })) => Ok(Enqueued::NoShare(over)),
            added => unless_key_taken(added.map(|_added| ()))
                .map(|added| if added { Enqueued::Added } else { Enqueued::KeyTaken }),
        }
    }

    /// Whether [`Store::claim`] would find a job.
    ///
    /// # Errors
    /// The database failed.
    pub async fn has_claimable(&self, most_of_caller: usize) -> Result<bool, StoreError> {
        let most_of_caller = i64::try_from(most_of_caller).unwrap_or(i64::MAX);
        sqlx::query_scalar!(
            r#"SELECT EXISTS (SELECT 1 FROM jobs WHERE state = 'queued' AND coalesce(caller, '') NOT IN
                   (SELECT coalesce(caller, '') FROM jobs WHERE state = 'running' GROUP BY 1 HAVING count(*) >= ?)
               ) AS "is_there: bool""#,
            most_of_caller
        )
        .fetch_one(&self.readers)
        .await
        .doing("looking for a job")
    }

    /// Takes the next job: first what was computed when the process died, and of that what may be blamed least; then of the caller
    /// that was served longest ago, and of its machines of the one that was, the job that waits longest. A caller of which
    /// `most_of_caller` jobs run is passed over.
    ///
    /// # Errors
    /// The database failed.
    pub async fn claim(
        &self,
        lease: &str,
        now: &str,
        version: &str,
        most_of_caller: usize,
    ) -> Result<Option<Claimed>, StoreError> {
        let most_of_caller = i64::try_from(most_of_caller).unwrap_or(i64::MAX);
        let (lease, now, version) = (lease.to_owned(), now.to_owned(), version.to_owned());
        let holder = lease.clone();
        let taken = self
            .write("taking a job", |connection| {
                Box::pin(async move {
                    let next = sqlx::query!(
                        "SELECT id, j.machine_id, j.caller FROM jobs j
                         LEFT JOIN caller_turns c ON c.caller = j.caller
                         LEFT JOIN job_turns t ON t.machine_id = j.machine_id
                         WHERE state = 'queued' AND coalesce(j.caller, '') NOT IN
                             (SELECT coalesce(caller, '') FROM jobs WHERE state = 'running' GROUP BY 1 HAVING count(*) >= ?)
                         ORDER BY deaths + lone_deaths = 0, lone_deaths, coalesce(c.turn, 0), coalesce(t.turn, 0), seq
                         LIMIT 1",
                        most_of_caller
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
                    if let Some(caller) = &next.caller {
                        sqlx::query!(
                            "INSERT INTO caller_turns (caller, turn)
                             VALUES (?, (SELECT coalesce(max(turn), 0) + 1 FROM caller_turns))
                             ON CONFLICT (caller) DO UPDATE SET turn = excluded.turn",
                            caller
                        )
                        .execute(&mut *connection)
                        .await?;
                        // Whoever was served so long ago is first anyway.
                        sqlx::query!(
                            "DELETE FROM caller_turns WHERE turn <= (SELECT max(turn) FROM caller_turns) - ?",
                            TURNS_REMEMBERED
                        )
                        .execute(&mut *connection)
                        .await?;
                    }
                    sqlx::query_as!(
                        StoredJob,
                        "UPDATE jobs SET state = 'running', attempts = attempts + 1, lease = ?, started_at = ?,
                             software_version = ?
                         WHERE id = ? AND state = 'queued' RETURNING *",
                        lease,
                        now,
                        version,
                        next.id
                    )
                    .fetch_optional(&mut *connection)
                    .await
                })
            })
            .await?;
        let claimed = |row: StoredJob| {
            let (caller, deaths) = (row.caller.clone(), row.deaths);
            Ok(Claimed { job: row.read()?, lease: holder, caller, deaths })
        };
        taken.map(claimed).transpose()
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

    /// Whether one more job of a caller's may wait.
    ///
    /// # Errors
    /// The database failed; within, that it may not.
    pub async fn queue_room(&self, room: &QueueRoom) -> Result<Result<(), NoShare>, StoreError> {
        let caller = room.caller.to_string();
        let waiting = sqlx::query!(
            "SELECT count(*) AS \"all!: i64\", count(*) FILTER (WHERE caller = ?) AS \"own!: i64\"
             FROM jobs WHERE state = 'queued'",
            caller
        )
        .fetch_one(&self.readers)
        .await
        .doing("measuring the queue")?;
        Ok(room.check(waiting.all, waiting.own))
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
