//! The queue of jobs: an accepted job waits here, is taken under a lease, and ends once. Everything that must be true
//! at one moment happens in one transaction, so that another database can replace this one statement by statement
//! (`docs/architecture.md`).

use serde_json::Value;

use super::audit::{Actor, Change, audit};
use super::error::Doing;
use super::jobs::{StoredJob, created};
use super::keys::{Answer, keep_key, unless_key_taken};
use super::queue_depth::Waiting;
use super::{JobRow, JobState, KeyUse, Store, StoreError};
use crate::shares::{NoShare, Quota, Share, Who};
use crate::wire::AuditAction;

/// The result of queueing jobs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Enqueued {
    /// The jobs wait.
    Added,
    /// A key was used in the meantime; nothing is stored.
    KeyTaken,
    /// The queue is full; nothing is stored.
    Full,
    /// The caller holds its full share of the queue; nothing is stored.
    NoShare(NoShare),
}

/// The caller of a job, and the limits of the queue.
#[derive(Debug, Clone, PartialEq)]
pub struct QueueRoom {
    /// Largest number for all callers.
    pub max_queued: usize,
    /// The share of one caller.
    pub share: Share,
    /// The caller.
    pub caller: Who,
}

impl QueueRoom {
    /// Whether `more` jobs of the caller may wait, if `waiting` jobs wait and `own` of them are its own.
    ///
    /// # Errors
    /// They may not.
    pub fn check(&self, waiting: i64, own: i64, more: usize) -> Result<(), NoShare> {
        let count = |number: i64| u64::try_from(number).unwrap_or(0);
        let (waiting, own) = (count(waiting), count(own));
        let others = waiting.saturating_sub(own);
        self.share.check(Quota::QueuedJobs, self.max_queued as u64, others, own, more as u64)
    }
}

/// A job taken from the queue.
#[derive(Debug, Clone, PartialEq)]
pub struct Claimed {
    /// The job.
    pub job: JobRow,
    /// The lease that its ending must name.
    pub lease: String,
    /// The caller that requested it, if it is known.
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
    /// With a result; its files are already kept.
    Succeeded {
        /// The report, as JSON text.
        report: String,
        /// Digest of the report.
        report_sha256: String,
        /// Digest of the program or table.
        output_sha256: Option<String>,
        /// Digest of the table of changes.
        changes_sha256: Option<String>,
        /// The steps behind the output, of this job and of earlier ones, separated by commas; `None` if the
        /// operation writes no program.
        steps: Option<String>,
        /// Number of motions that were checked in a compensated program.
        motions_checked: Option<i64>,
    },
    /// Without a result.
    Failed {
        /// The reason: a problem document.
        problem: Value,
    },
}

/// The result of giving back a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GivenBack {
    /// It waits again, as if it had never been taken.
    Queued,
    /// Its client had cancelled it.
    Cancelled,
    /// The lease was no longer valid.
    Nothing,
}

/// The result of cancelling a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cancelling {
    /// There is no such job.
    Unknown,
    /// It was waiting and is now cancelled.
    Cancelled,
    /// It was cancelled before.
    Already,
    /// It is running, and is cancelled as soon as it stops.
    Requested,
    /// It has ended in another way.
    Ended(JobState),
}

row! {
    /// The job whose turn it is.
    struct Next {
        id: String,
        machine_id: String,
        caller: Option<String>,
    }
}

row! {
    /// A job that its client cancels.
    struct Cancelled {
        state: String,
        machine_id: String,
        cancel_requested: i64,
    }
}

/// Number of deaths of the process beside others after which a job is computed alone: it is not known which job
/// caused them.
pub const DEATHS_BESIDE_OTHERS: i64 = 3;

/// Number of turns after which a caller's turn is removed, so that the table does not grow with every caller.
const TURNS_REMEMBERED: i64 = 10_000;

impl Store {
    /// Queues jobs of one caller, each with the idempotency key of its request: all of them, or none if there is no room
    /// for all.
    ///
    /// # Errors
    /// The database failed.
    pub async fn enqueue(
        &self,
        jobs: &[(JobRow, Option<KeyUse>)],
        by: &Actor,
        room: &QueueRoom,
    ) -> Result<Enqueued, StoreError> {
        let (jobs, by) = (jobs.to_vec(), by.clone());
        let (room, caller) = (room.clone(), room.caller.to_string());
        let added = self
            .write("queueing jobs", |tx| {
                Box::pin(async move {
                    let waiting = sql!(
                        tx,
                        one(Waiting),
                        "SELECT count(*) AS \"all!\", count(*) FILTER (WHERE caller = $1) AS \"own!\"
                         FROM jobs WHERE state = 'queued'",
                        caller
                    )?;
                    if let Err(refused) = room.check(waiting.all, waiting.own, jobs.len()) {
                        return Ok(Some(refused));
                    }
                    for (job, used) in &jobs {
                        let JobRow { document, file_name, traceparent, accepted, .. } = job;
                        let (operation, parameters) =
                            (document.operation.as_str(), document.parameters.to_string());
                        sql!(
                            tx,
                            execute,
                            "INSERT INTO jobs (id, machine_id, machine_revision, operation, parameters, state, progress,
                             file_name, input_sha256, surface_sha256, external_id, callback_url, attempts,
                             software_version, created_at, traceparent, accepted, caller)
                         VALUES ($1, $2, $3, $4, $5, 'queued', 0, $6, $7, $8, $9, $10, 0, $11, $12, $13, $14, $15)",
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
                            traceparent.as_deref(),
                            accepted.as_deref(),
                            caller
                        )?;
                        let answer = Answer::Job(&document.id);
                        keep_key(tx, used.as_ref(), answer, &document.created_at).await?;
                        audit(tx, &by, created(document)).await?;
                    }
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
        let holder = self.holder();
        sql!(
            self.db,
            one(_),
            sqlite r#"SELECT EXISTS (SELECT 1 FROM jobs WHERE state = 'queued' AND coalesce(caller, '') NOT IN
                   (SELECT coalesce(caller, '') FROM jobs WHERE state = 'running' GROUP BY 1 HAVING count(*) >= $1)
               ) AS "is_there!: _""# [most_of_caller],
            postgres r#"SELECT EXISTS (SELECT 1 FROM jobs WHERE state = 'queued' AND coalesce(caller, '') NOT IN
                   (SELECT coalesce(r.caller, '') FROM jobs r JOIN job_leases l ON l.job_id = r.id
                    WHERE r.state = 'running' AND l.holder = $2 GROUP BY 1 HAVING count(*) >= $1)
               ) AS "is_there!: _""# [most_of_caller, holder]
        )
        .doing("looking for a job")
    }

    /// Takes the next job. First come jobs that were running when the process died, those with the fewest lone deaths
    /// first. Then comes the caller that was served longest ago, among its machines the one that was served longest
    /// ago, and there the job that has waited longest. A caller with `most_of_caller` jobs that this service runs is
    /// skipped.
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
        let (named, holder) = (lease.clone(), self.holder().to_owned());
        let taken = self
            .write_apart("taking a job", |tx| {
                Box::pin(async move {
                    let next = sql!(
                        tx,
                        optional(Next),
                        sqlite "SELECT id, j.machine_id, j.caller FROM jobs j
                         LEFT JOIN caller_turns c ON c.caller = j.caller
                         LEFT JOIN job_turns t ON t.machine_id = j.machine_id
                         WHERE state = 'queued' AND coalesce(j.caller, '') NOT IN
                             (SELECT coalesce(caller, '') FROM jobs WHERE state = 'running'
                              GROUP BY 1 HAVING count(*) >= $1)
                         ORDER BY deaths + lone_deaths = 0, lone_deaths,
                             coalesce(c.turn, 0), coalesce(t.turn, 0), seq
                         LIMIT 1" [most_of_caller],
                        postgres "SELECT id, j.machine_id, j.caller FROM jobs j
                         LEFT JOIN caller_turns c ON c.caller = j.caller
                         LEFT JOIN job_turns t ON t.machine_id = j.machine_id
                         WHERE state = 'queued' AND coalesce(j.caller, '') NOT IN
                             (SELECT coalesce(r.caller, '') FROM jobs r JOIN job_leases l ON l.job_id = r.id
                              WHERE r.state = 'running' AND l.holder = $2 GROUP BY 1 HAVING count(*) >= $1)
                         ORDER BY deaths + lone_deaths = 0, lone_deaths,
                             coalesce(c.turn, 0), coalesce(t.turn, 0), seq
                         LIMIT 1 FOR UPDATE OF j SKIP LOCKED" [most_of_caller, holder]
                    )?;
                    let Some(next) = next else { return Ok(None) };
                    sql!(
                        tx,
                        execute,
                        "INSERT INTO job_turns (machine_id, turn)
                         VALUES ($1, (SELECT coalesce(max(turn), 0) + 1 FROM job_turns))
                         ON CONFLICT (machine_id) DO UPDATE SET turn = excluded.turn",
                        next.machine_id
                    )?;
                    if let Some(caller) = &next.caller {
                        sql!(
                            tx,
                            execute,
                            "INSERT INTO caller_turns (caller, turn)
                             VALUES ($1, (SELECT coalesce(max(turn), 0) + 1 FROM caller_turns))
                             ON CONFLICT (caller) DO UPDATE SET turn = excluded.turn",
                            caller
                        )?;
                        // A caller that was served so long ago is first anyway.
                        sql!(
                            tx,
                            execute,
                            "DELETE FROM caller_turns WHERE turn <= (SELECT max(turn) FROM caller_turns) - $1",
                            TURNS_REMEMBERED
                        )?;
                    }
                    let taken = sql!(
                        tx,
                        optional(StoredJob),
                        "UPDATE jobs SET state = 'running', attempts = attempts + 1, lease = $1, started_at = $2,
                             software_version = $3
                         WHERE id = $4 AND state = 'queued' RETURNING *",
                        lease,
                        now,
                        version,
                        next.id
                    )?;
                    let _leases: u64 = sql!(
                        tx,
                        execute,
                        postgres "INSERT INTO job_leases (job_id, lease, holder, lease_until)
                                  SELECT id, lease, $1, clock_timestamp() + INTERVAL '30 s' FROM jobs
                                  WHERE id = $2 AND lease = $3",
                        holder,
                        next.id,
                        lease
                    )?;
                    Ok(taken)
                })
            })
            .await?;
        let claimed = |row: StoredJob| {
            let (caller, deaths) = (row.caller.clone(), row.deaths);
            Ok(Claimed { job: row.read()?, lease: named, caller, deaths })
        };
        taken.map(claimed).transpose()
    }

    /// Ends a job. `false` if the lease is no longer valid, or if the client has cancelled the job: give it back
    /// then.
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
        self.write_apart("ending a job", |tx| {
            Box::pin(async move {
                let done = match ending {
                    Ending::Succeeded {
                        report,
                        report_sha256,
                        output_sha256,
                        changes_sha256,
                        steps,
                        motions_checked,
                    } => sql!(
                        tx,
                        execute,
                        "UPDATE jobs SET state = 'succeeded', progress = 1, report = $1, report_sha256 = $2,
                                 output_sha256 = $3, changes_sha256 = $4, steps = $5, motions_checked = $6,
                                 finished_at = $7, lease = NULL
                             WHERE id = $8 AND state = 'running' AND lease = $9 AND cancel_requested = 0",
                        report,
                        report_sha256,
                        output_sha256,
                        changes_sha256,
                        steps,
                        motions_checked,
                        now,
                        id,
                        lease
                    )?,
                    Ending::Failed { problem } => {
                        let problem = problem.to_string();
                        sql!(
                            tx,
                            execute,
                            "UPDATE jobs SET state = 'failed', problem = $1, finished_at = $2, lease = NULL
                             WHERE id = $3 AND state = 'running' AND lease = $4 AND cancel_requested = 0",
                            problem,
                            now,
                            id,
                            lease
                        )?
                    }
                };
                Ok(done == 1)
            })
        })
        .await
    }

    /// Gives back a job that is not computed to its end: it waits again and this attempt does not count, or it is
    /// cancelled if its client wants that.
    ///
    /// # Errors
    /// The database failed.
    pub async fn give_back(&self, id: &str, lease: &str, now: &str) -> Result<GivenBack, StoreError> {
        let (id, lease, now) = (id.to_owned(), lease.to_owned(), now.to_owned());
        let state: Option<String> = self
            .write_apart("giving a job back", |tx| {
                Box::pin(async move {
                    sql!(
                        tx,
                        optional(_),
                        "UPDATE jobs SET state = CASE WHEN cancel_requested = 1 THEN 'cancelled' ELSE 'queued' END,
                             attempts = attempts - CASE WHEN cancel_requested = 1 THEN 0 ELSE 1 END,
                             started_at = CASE WHEN cancel_requested = 1 THEN started_at END,
                             finished_at = CASE WHEN cancel_requested = 1 THEN $1 END, lease = NULL
                         WHERE id = $2 AND state = 'running' AND lease = $3
                         RETURNING state",
                        now,
                        id,
                        lease
                    )
                })
            })
            .await?;
        Ok(match state.as_deref() {
            None => GivenBack::Nothing,
            Some("cancelled") => GivenBack::Cancelled,
            Some(_) => GivenBack::Queued,
        })
    }

    /// Cancels a waiting job, or requests that a running one is stopped.
    ///
    /// # Errors
    /// The database failed.
    pub async fn cancel_job(&self, id: &str, by: &Actor, now: &str) -> Result<Cancelling, StoreError> {
        let (id, by, now) = (id.to_owned(), by.clone(), now.to_owned());
        self.write("cancelling a job", |tx| {
            Box::pin(async move {
                let job = sql!(
                    tx,
                    optional(Cancelled),
                    sqlite "SELECT state, machine_id, cancel_requested FROM jobs WHERE id = $1",
                    // Another service may take it, or end it, at this moment.
                    postgres "SELECT state, machine_id, cancel_requested FROM jobs WHERE id = $1 FOR UPDATE",
                    id
                )?;
                let Some(job) = job else { return Ok(Cancelling::Unknown) };
                let done = match job.state.as_str() {
                    "queued" => {
                        sql!(
                            tx,
                            execute,
                            "UPDATE jobs SET state = 'cancelled', cancel_requested = 1, finished_at = $1
                             WHERE id = $2",
                            now,
                            id
                        )?;
                        Cancelling::Cancelled
                    }
                    "running" => {
                        sql!(tx, execute, "UPDATE jobs SET cancel_requested = 1 WHERE id = $1", id)?;
                        Cancelling::Requested
                    }
                    "cancelled" => Cancelling::Already,
                    "failed" => Cancelling::Ended(JobState::Failed),
                    _ => Cancelling::Ended(JobState::Succeeded),
                };
                // A repeated request changes nothing.
                if matches!(done, Cancelling::Cancelled | Cancelling::Requested) && job.cancel_requested == 0
                {
                    let change = Change {
                        at: &now,
                        action: AuditAction::JobCancelled,
                        machine_id: Some(&job.machine_id),
                        resource: format!("/v1/jobs/{id}"),
                        revisions: (None, None),
                    };
                    audit(tx, &by, change).await?;
                }
                Ok(done)
            })
        })
        .await
    }
}
