//! The state that the handlers share.

use std::fmt;
use std::ops::Deref;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, LazyLock, OnceLock};
use std::time::Instant;

use super::held_keys::HeldKeys;
use super::held_machines::HeldMachines;
use super::observation::{Exporter, Operations};
use super::problem::Problem;
use super::rates::Rates;
use super::security_log::SecurityLog;
use crate::config::Settings;
use crate::jobs::memory::Memory;
use crate::jobs::{
    Compensator, Compute, Courier, Keeper, Limits, Means, OpenFault, Queue, QueueLimits, ScrubLimits,
    Sources, Spool, open_data_directory,
};
use crate::meter::Counter;
use crate::shares::{Quota, Share, Shares};
use crate::store::Store;

/// The state that the handlers share. A clone increments one counter: every layer of every request has one.
#[derive(Clone)]
pub struct AppState(Arc<Shared>);

/// The shared parts.
pub struct Shared {
    /// Machines, jobs, keys.
    pub store: Store,
    /// The pool that computes.
    pub compute: Compute,
    /// Uploads and results.
    pub spool: Spool,
    /// Clock and ids.
    pub sources: Sources,
    /// The settings.
    pub settings: Arc<Settings>,
    /// The compensator of programs.
    pub compensator: Arc<dyn Compensator>,
    operations: OnceLock<Operations>,
    /// Requests whose client left before the answer.
    pub(super) abandoned: Counter,
    /// The memory that requests share.
    pub memory: Memory,
    /// The rates of the callers, if they are limited.
    pub(super) rates: Option<Rates>,
    exporter: OnceLock<Arc<dyn Exporter>>,
    /// When the service started.
    pub(super) began: Instant,
    /// Jobs that wait and run.
    pub queue: Queue,
    /// Delivers the webhooks about ended jobs.
    pub courier: Courier,
    /// Checks all stored data.
    pub keeper: Keeper,
    /// The turn of an archive of programs, which holds many open files.
    pub(super) archives: tokio::sync::Mutex<()>,
    /// Places for clients that follow the events of jobs.
    pub(super) followers: Shares,
    /// The API keys.
    pub(super) keys: HeldKeys,
    /// Requests that were not admitted.
    pub(super) security: SecurityLog,
    /// The machines that were used last.
    pub(super) machines: HeldMachines,
    draining: AtomicBool,
}

impl fmt::Debug for AppState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AppState").field("settings", &self.settings).finish_non_exhaustive()
    }
}

impl Deref for AppState {
    type Target = Shared;

    fn deref(&self) -> &Shared {
        &self.0
    }
}

impl AppState {
    /// Opens database and files in the data directory of `settings`.
    ///
    /// # Errors
    /// The database cannot be opened or migrated, the files cannot be used.
    pub async fn open(
        settings: Settings,
        sources: Sources,
        compensator: Arc<dyn Compensator>,
    ) -> Result<Self, OpenFault> {
        let (store, blobs) = open_data_directory(&settings, &sources).await?;
        let rates = Rates::new(settings.max_rate_per_s, settings.max_burst_requests);
        let share = Share(settings.max_share_per_caller);
        let memory = Memory::within(
            settings.max_memory_bytes,
            settings.max_connections,
            settings.computations(),
            share,
        );
        let compute = Compute::new(
            settings.computations(),
            settings.max_waiting_computations,
            share,
            settings.max_surface_memory_bytes,
        )
        .costing_at_most(settings.max_cost_s);
        let spool = Spool::new(blobs, settings.max_body_bytes)
            .with_results_within(settings.max_result_bytes)
            .shared(Shares::new(Quota::SpoolBytes, settings.max_spool_bytes, share));
        let means = Means { compensator: Arc::clone(&compensator), max_cost_s: settings.max_cost_s };
        let limits = QueueLimits {
            max_queued: settings.max_queued_jobs,
            share,
            job_retention_s: settings.job_retention_s,
            key_retention_s: settings.idempotency_retention_s,
        };
        let queue = Queue::open(
            store.clone(),
            spool.clone(),
            compute.clone(),
            sources.clone(),
            means,
            limits,
            Problem::of_job,
        )
        .await?;
        let courier = Courier::open(store.clone(), sources.clone(), queue.clone(), &settings)?;
        let scrub = ScrubLimits {
            interval_s: settings.scrub_interval_s,
            bytes_per_s: settings.scrub_bytes_per_s as f64,
        };
        let blobs = spool.blobs().clone();
        let keeper = Keeper::open(store.clone(), blobs, sources.clone(), &settings.data_dir, scrub);
        Ok(Self(Arc::new(Shared {
            courier,
            keeper,
            store,
            compute,
            spool,
            sources,
            archives: tokio::sync::Mutex::default(),
            followers: Shares::new(Quota::EventStreams, settings.max_event_streams as u64, share),
            machines: HeldMachines::default(),
            keys: HeldKeys::new(&settings.data_dir),
            security: SecurityLog::open(&settings.data_dir).map_err(OpenFault::Thread)?,
            settings: Arc::new(settings),
            compensator,
            queue,
            operations: OnceLock::new(),
            abandoned: Counter::new(),
            memory,
            rates,
            exporter: OnceLock::new(),
            began: Instant::now(),
            draining: AtomicBool::new(false),
        })))
    }

    /// The largest cost of one kinematics request.
    #[must_use]
    pub fn limits(&self) -> Limits {
        Limits { max_poses: self.settings.max_poses, max_cost_s: self.settings.max_cost_s }
    }

    /// Exports the spans of requests from now on, in addition to the log. The first exporter stays.
    pub fn export_to(&self, exporter: Arc<dyn Exporter>) {
        self.exporter.get_or_init(|| exporter);
    }

    /// The exporter of request spans, in addition to the log.
    #[must_use]
    pub fn exporter(&self) -> Option<Arc<dyn Exporter>> {
        self.exporter.get().cloned()
    }

    /// Sets the operations that are served and counted. This happens once.
    pub(super) fn serve_operations(&self, operations: impl FnOnce() -> Operations) {
        self.operations.get_or_init(operations);
    }

    /// Counts and times of requests, by operation.
    pub(super) fn operations(&self) -> &Operations {
        // They are missing if routes are served without the whole service.
        static NONE: LazyLock<Operations> = LazyLock::new(|| Operations::new(std::iter::empty()));
        self.operations.get().unwrap_or_else(|| &NONE)
    }

    /// The means that work on programs needs.
    #[must_use]
    pub fn means(&self) -> Means {
        Means { compensator: Arc::clone(&self.compensator), max_cost_s: self.settings.max_cost_s }
    }

    /// The service is not ready from now on.
    pub fn begin_draining(&self) {
        self.draining.store(true, Ordering::SeqCst);
    }

    /// Whether the service is stopping.
    #[must_use]
    pub fn is_draining(&self) -> bool {
        self.draining.load(Ordering::SeqCst)
    }
}
