//! The queue of jobs: a job is accepted, computed in the pool, and ended once, whatever happens to the process in
//! between. The durable part is in `store::queue`; this module holds the part that lives only as long as the process.

mod computing;
mod dispatch;
mod leases;
mod order;
mod retention;
mod running;

use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use serde_json::Value;
use tokio::sync::{Mutex, Notify, broadcast};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use self::leases::Contact;
pub use self::order::JobOrder;
use self::running::Running;
use super::program_job::{job_of_key, keep_all};
use super::{Accepted, Compute, JobFault, Means, OpenFault, ProgramJob, Sources, Spool, asker};
use crate::meter::JOBS_ENDED;
use crate::shares::{NoShare, Share};
use crate::store::{
    Actor, Cancelling, Draft, Enqueued, JobRow, KeyUse, Marks, QueueDepth, QueueRoom, Sha256Hex, Store,
    StoreError,
};
use crate::wire::{JobDocument, JobState};

/// Turns a fault into the problem document for the client of a job, the same as a request would get.
pub type Describe = fn(JobFault) -> Value;

/// How much the queue may hold, and for how long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QueueLimits {
    /// Jobs that may wait.
    pub max_queued: usize,
    /// The part of them that one caller may have.
    pub share: Share,
    /// How long a job is kept after its end \[s\]; 0 for ever.
    pub job_retention_s: f64,
    /// How long an idempotency key is remembered \[s\].
    pub key_retention_s: f64,
}

/// The number of waiting and running jobs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct QueueReading {
    /// Jobs that are waiting.
    pub queued: i64,
    /// Jobs that run.
    pub running: i64,
    /// How long the oldest waiting job has been waiting \[s\]; 0 if none waits.
    pub oldest_s: f64,
}

/// What a client states about a job in addition to its work.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Besides {
    /// The client's own id.
    pub external_id: Option<String>,
    /// Address of the webhook about its end.
    pub callback_url: Option<String>,
    /// The trace that the job belongs to (W3C Trace Context).
    pub traceparent: Option<String>,
}

/// A job that is about to be accepted, with its files.
#[derive(Debug)]
pub struct DrawnUp {
    row: JobRow,
    used: Option<KeyUse>,
    by: Actor,
    files: [Option<Draft>; 2],
}

impl DrawnUp {
    /// Bytes of its stored texts, which it holds in memory until it is accepted.
    #[must_use]
    pub fn text_bytes(&self) -> u64 {
        self.row.accepted.as_ref().map_or(0, |accepted| accepted.len() as u64)
    }
}

/// The queue; cheap to clone.
#[derive(Debug, Clone)]
pub struct Queue(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    store: Store,
    spool: Spool,
    compute: Compute,
    sources: Sources,
    means: Means,
    limits: QueueLimits,
    describe: Describe,
    /// Shows the next process which jobs were being computed when this one died.
    marks: Marks,
    /// The jobs that are being computed.
    running: Running,
    /// Files to remove unless a job names them.
    given_up: std::sync::Mutex<Vec<Sha256Hex>>,
    /// Held from the database's answer about a job until this process knows it, so that no cancel falls between the
    /// two.
    gate: Mutex<()>,
    /// The id of every job that has changed.
    changes: broadcast::Sender<Arc<str>>,
    /// Notified when the queue may have a new job.
    more: Notify,
    /// Notified when another service may have cancelled a running job.
    renew_now: Notify,
    /// Since when the database was reached without a break.
    contact: Contact,
    /// Notified when a webhook is due.
    told: Notify,
    /// Cancelled when the removal of old jobs at the start has ended.
    begun: CancellationToken,
    /// Cancelled when no new job may begin.
    stopping: CancellationToken,
    /// Cancelled when the database is about to close.
    halted: CancellationToken,
    tasks: TaskTracker,
}

/// Changes that a slow follower may miss before it has to read the job itself.
const CHANGES_KEPT: usize = 1024;
/// How long stopped work may take to end when the service stops.
const GRACE: Duration = Duration::from_millis(300);
/// How long running jobs may take to end when one of several services stops: the others take them then.
const SHARED_DRAIN: Duration = Duration::from_millis(500);

impl Queue {
    /// Takes over the jobs that an earlier process left, and begins to compute.
    ///
    /// # Errors
    /// The database failed, or the marks of what is computed cannot be kept.
    pub async fn open(
        store: Store,
        spool: Spool,
        compute: Compute,
        sources: Sources,
        means: Means,
        limits: QueueLimits,
        describe: Describe,
    ) -> Result<Self, OpenFault> {
        let (marks, computed) = spool.blobs().marks()?;
        let died = describe(JobFault::ProcessDied);
        let recovered = store.recover_jobs(&computed, &died, &sources.timestamp()).await?;
        let shared = Arc::new(Shared {
            store,
            spool,
            compute,
            sources,
            means,
            limits,
            describe,
            marks,
            running: Running::default(),
            given_up: std::sync::Mutex::default(),
            gate: Mutex::new(()),
            changes: broadcast::Sender::new(CHANGES_KEPT),
            more: Notify::new(),
            renew_now: Notify::new(),
            contact: Contact::default(),
            told: Notify::new(),
            begun: CancellationToken::new(),
            stopping: CancellationToken::new(),
            halted: CancellationToken::new(),
            tasks: TaskTracker::new(),
        });
        shared.took_up(&recovered).await;
        shared.begin_sharing();
        shared.tasks.spawn(Arc::clone(&shared).begin_work());
        Ok(Self(shared))
    }

    /// Waits until the removal of old jobs at the start has ended. Jobs are computed from then on.
    pub async fn begun(&self) {
        self.0.begun.cancelled().await;
    }

    /// The present number of waiting and running jobs.
    ///
    /// # Errors
    /// The database failed.
    pub async fn reading(&self) -> Result<QueueReading, StoreError> {
        let QueueDepth { queued, running, oldest } = self.0.store.queue_depth().await?;
        let since = oldest.and_then(|oldest| oldest.parse::<Timestamp>().ok());
        let waited = since.map(|since| self.0.sources.clock.now().duration_since(since).as_secs_f64());
        Ok(QueueReading { queued, running, oldest_s: waited.unwrap_or(0.0).max(0.0) })
    }

    /// The largest number of jobs of one caller that may wait, if nobody else's wait.
    #[must_use]
    pub fn most_of_caller(&self) -> u64 {
        let limits = self.0.limits;
        limits.share.of(limits.max_queued as u64)
    }

    /// Whether `more` jobs may wait; checked before their files are taken.
    ///
    /// # Errors
    /// The queue, or this caller's part of it, has no room for them; or the database failed.
    pub async fn check_room(&self, more: usize) -> Result<(), JobFault> {
        let shared = &*self.0;
        let room = shared.store.queue_room(&shared.room(), more).await?;
        room.map_err(|refused| match refused {
            NoShare::Full { .. } => JobFault::QueueFull { limit: shared.limits.max_queued },
            over @ NoShare::OverShare { .. } => over.into(),
        })
    }

    /// A job as it will be accepted: it has its id, and its machine's revision is fixed.
    ///
    /// # Errors
    /// What it is accepted with cannot be printed.
    pub fn draw_up(&self, job: ProgramJob, besides: Besides) -> Result<DrawnUp, JobFault> {
        let Besides { external_id, callback_url, traceparent } = besides;
        let ProgramJob { machine_id, machine_revision, work, program, surface, file_name, used, by, .. } =
            job;
        let steps_done = (!job.steps_done.is_empty()).then(|| job.steps_done.to_string());
        let accepted = Accepted { shelf: work.shelf.kept(), repeats: job.repeats, steps_done };
        let sources = &self.0.sources;
        let document = JobDocument {
            id: sources.ids.next().to_string(),
            machine_id,
            machine_revision,
            operation: work.operation,
            parameters: work.parameters,
            state: JobState::Queued,
            progress: 0.0,
            input_sha256: program.sha256(),
            surface_sha256: surface.as_ref().map(Draft::sha256),
            output_sha256: None,
            changes_sha256: None,
            external_id,
            callback_url,
            attempts: 0,
            problem: None,
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            created_at: sources.timestamp(),
            started_at: None,
            finished_at: None,
        };
        let row = JobRow {
            document,
            file_name,
            report: None,
            report_sha256: None,
            traceparent,
            motions_checked: None,
            accepted: Some(serde_json::to_string(&accepted)?),
        };
        Ok(DrawnUp { row, used, by, files: [Some(program), surface] })
    }

    /// Accepts jobs of one request, all or none: their files are kept, then one transaction names them, and they will
    /// be computed.
    ///
    /// # Errors
    /// The queue has no room for all of them, a key belongs to another request, or the files cannot be kept.
    pub async fn accept(&self, jobs: Vec<DrawnUp>) -> Result<Vec<JobRow>, JobFault> {
        let shared = &*self.0;
        let Some(by) = jobs.first().map(|job| job.by.clone()) else { return Ok(Vec::new()) };
        let (rows, files): (Vec<_>, Vec<_>) =
            jobs.into_iter().map(|DrawnUp { row, used, files, .. }| ((row, used), files)).unzip();
        let enqueued = shared.enqueue(&rows, files, &by).await;
        if !matches!(enqueued, Ok(Enqueued::Added)) {
            // Refused jobs leave nothing in the store, whatever the reason.
            let documents = rows.iter().map(|(row, _)| &row.document);
            let kept = documents.flat_map(|job| [Some(job.input_sha256.clone()), job.surface_sha256.clone()]);
            shared.give_up(kept.flatten());
            if let Err(fault) = shared.tidy(Duration::ZERO).await {
                tracing::warn!(error = %fault, "the files of refused jobs are not removed yet");
            }
        }
        match enqueued? {
            Enqueued::Added => {
                shared.more.notify_one();
                Ok(rows.into_iter().map(|(row, _)| row).collect())
            }
            Enqueued::Full => Err(JobFault::QueueFull { limit: shared.limits.max_queued }),
            Enqueued::NoShare(over) => Err(over.into()),
            Enqueued::KeyTaken => {
                let mut earlier = Vec::with_capacity(rows.len());
                for (_, used) in rows {
                    earlier.push(job_of_key(&shared.store, used.as_ref()).await?);
                }
                Ok(earlier)
            }
        }
    }

    /// Cancels a waiting job, or stops a running one.
    ///
    /// # Errors
    /// The database failed.
    pub async fn cancel(&self, id: &str, by: &Actor) -> Result<Cancelling, StoreError> {
        let shared = &*self.0;
        let gate = shared.gate.lock().await;
        let done = shared.store.cancel_job(id, by, &shared.sources.timestamp()).await?;
        if done == Cancelling::Requested {
            shared.running.stop(id);
        }
        drop(gate);
        match done {
            Cancelling::Cancelled => shared.on_finished(id).await,
            Cancelling::Requested => shared.changed(id),
            Cancelling::Unknown | Cancelling::Already | Cancelling::Ended(_) => {}
        }
        Ok(done)
    }

    /// The progress of a running job, 0 to 1; it never decreases.
    #[must_use]
    pub fn progress(&self, id: &str) -> Option<f64> {
        self.0.running.progress(id)
    }

    /// The ids of the jobs that change from now on.
    #[must_use]
    pub fn changes(&self) -> broadcast::Receiver<Arc<str>> {
        self.0.changes.subscribe()
    }

    /// Notified when a job with a webhook has ended.
    #[must_use]
    pub fn told(&self) -> &Notify {
        &self.0.told
    }

    /// Cancelled once the service stops.
    #[must_use]
    pub fn stopping(&self) -> &CancellationToken {
        &self.0.stopping
    }

    /// Begins no new job, lets the running jobs end within `drain`, and gives the rest back to the queue, whether
    /// they have stopped or not.
    pub async fn stop(&self, drain: Duration) {
        let shared = &*self.0;
        let drain = if shared.store.is_shared() { drain.min(SHARED_DRAIN) } else { drain };
        shared.stopping.cancel();
        shared.tasks.close();
        if tokio::time::timeout(drain, shared.tasks.wait()).await.is_err() {
            shared.running.stop_all();
            if tokio::time::timeout(GRACE, shared.tasks.wait()).await.is_err() {
                for (id, lease) in shared.running.leases() {
                    let given = shared.store.give_back(&id, &lease, &shared.sources.timestamp()).await;
                    tracing::warn!(job_id = id, ?given, "a job that does not stop is given back");
                }
            }
        }
        shared.halted.cancel();
    }
}

impl Shared {
    /// Keeps the files of jobs, then names them.
    async fn enqueue(
        &self,
        rows: &[(JobRow, Option<KeyUse>)],
        files: Vec<[Option<Draft>; 2]>,
        by: &Actor,
    ) -> Result<Enqueued, JobFault> {
        let blobs = self.spool.blobs();
        let _naming = blobs.naming().await;
        keep_all(blobs, files.into_iter().flatten()).await?;
        Ok(self.store.enqueue(rows, by, &self.room()).await?)
    }

    /// The room for jobs of the present caller.
    fn room(&self) -> QueueRoom {
        QueueRoom { max_queued: self.limits.max_queued, share: self.limits.share, caller: asker() }
    }

    /// Notifies the followers of jobs that one has changed.
    fn changed(&self, id: &str) {
        // There may be no listener.
        let _followers = self.changes.send(id.into());
    }

    /// Called once after every stored end of a job; its webhook is already in the database (`store::deliveries`).
    async fn on_finished(&self, id: &str) {
        self.changed(id);
        match self.store.job(id).await {
            // Somebody else computes it.
            Ok(Some(job)) if !JobState::ENDS.contains(&job.document.state) => {}
            Ok(Some(job)) => {
                let (ended, state) = (job.document.state, job.document.state.as_str());
                for (_, count) in JobState::ENDS.iter().zip(&JOBS_ENDED).filter(|(end, _)| **end == ended) {
                    count.add(1);
                }
                tracing::info!(job_id = id, state, attempts = job.document.attempts, "a job ended");
                if job.document.callback_url.is_some() {
                    self.told.notify_one();
                }
            }
            Ok(None) => {}
            Err(fault) => tracing::error!(job_id = id, error = %fault, "an ended job cannot be read"),
        }
    }
}
