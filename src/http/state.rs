//! What the handlers share.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use metrics_exporter_prometheus::{PrometheusBuilder, PrometheusRecorder};

use tokio::sync::Semaphore;

use super::problem::Problem;
use crate::config::Settings;
use crate::jobs::{
    Compensator, Compute, Limits, Means, OpenFault, Queue, QueueLimits, Sources, Spool, open_data_directory,
};
use crate::store::Store;

/// What the handlers share; cheap to clone.
#[derive(Clone)]
pub struct AppState {
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
    /// What compensates programs.
    pub compensator: Arc<dyn Compensator>,
    /// Jobs that wait and run.
    pub queue: Queue,
    /// Room for those who follow events of jobs.
    pub(super) followers: Arc<Semaphore>,
    /// Where counts and times of requests are kept.
    pub(super) recorder: Arc<PrometheusRecorder>,
    draining: Arc<AtomicBool>,
}

impl fmt::Debug for AppState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AppState").field("settings", &self.settings).finish_non_exhaustive()
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
        let compute = Compute::new(
            settings.computations(),
            settings.max_waiting_computations,
            settings.max_surface_memory_bytes,
        );
        let spool = Spool::new(blobs, settings.max_body_bytes);
        let means = Means { compensator: Arc::clone(&compensator), max_cost_s: settings.max_cost_s };
        let limits = QueueLimits {
            max_queued: settings.max_queued_jobs,
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
        Ok(Self {
            store,
            compute,
            spool,
            sources,
            followers: Arc::new(Semaphore::new(settings.max_event_streams.min(Semaphore::MAX_PERMITS))),
            settings: Arc::new(settings),
            compensator,
            queue,
            recorder: Arc::new(PrometheusBuilder::new().build_recorder()),
            draining: Arc::new(AtomicBool::new(false)),
        })
    }

    /// What one kinematics request may cost.
    #[must_use]
    pub fn limits(&self) -> Limits {
        Limits { max_poses: self.settings.max_poses, max_cost_s: self.settings.max_cost_s }
    }

    /// What programs are worked on with.
    #[must_use]
    pub fn means(&self) -> Means {
        Means { compensator: Arc::clone(&self.compensator), max_cost_s: self.settings.max_cost_s }
    }

    /// From now on the service is not ready.
    pub fn begin_draining(&self) {
        self.draining.store(true, Ordering::SeqCst);
    }

    /// Whether the service is stopping.
    #[must_use]
    pub fn is_draining(&self) -> bool {
        self.draining.load(Ordering::SeqCst)
    }
}
