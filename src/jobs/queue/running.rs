//! The jobs that are being computed in this process.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use tokio_util::sync::CancellationToken;

use crate::jobs::Progress;

/// One job that is being computed.
#[derive(Debug)]
pub(super) struct UnderWay {
    /// The lease that its ending must name.
    pub(super) lease: String,
    /// Cancelled to stop it.
    pub(super) stop: CancellationToken,
    /// How far it has come, once it has begun.
    reading: OnceLock<Progress>,
}

impl UnderWay {
    /// From now on this shows the progress of the job.
    pub(super) fn follow(&self, progress: Progress) {
        // A job has one program.
        let _first = self.reading.set(progress);
    }

    fn progress(&self) -> f64 {
        self.reading.get().map_or(0.0, Progress::share)
    }
}

/// All running jobs.
#[derive(Debug, Default)]
pub(super) struct Running {
    jobs: Mutex<HashMap<String, Arc<UnderWay>>>,
    /// How often the disk failed under each job.
    failures: Mutex<HashMap<String, u32>>,
}

impl Running {
    /// A job begins.
    pub(super) fn begin(&self, id: &str, lease: &str) -> Arc<UnderWay> {
        let (stop, reading) = (CancellationToken::new(), OnceLock::new());
        let under_way = Arc::new(UnderWay { lease: lease.to_owned(), stop, reading });
        self.jobs().insert(id.to_owned(), Arc::clone(&under_way));
        under_way
    }

    /// A job is settled.
    pub(super) fn end(&self, id: &str) {
        self.jobs().remove(id);
    }

    /// Stops a job.
    pub(super) fn stop(&self, id: &str) {
        if let Some(job) = self.jobs().get(id) {
            job.stop.cancel();
        }
    }

    /// Stops every job.
    pub(super) fn stop_all(&self) {
        self.jobs().values().for_each(|job| job.stop.cancel());
    }

    /// The progress of a job.
    pub(super) fn progress(&self, id: &str) -> Option<f64> {
        self.jobs().get(id).map(|job| job.progress())
    }

    /// Every job with its lease.
    pub(super) fn leases(&self) -> Vec<(String, String)> {
        self.jobs().iter().map(|(id, job)| (id.clone(), job.lease.clone())).collect()
    }

    /// The disk failed under a job; returns how often by now.
    pub(super) fn failed(&self, id: &str) -> u32 {
        let mut failures = self.failures();
        let count = failures.entry(id.to_owned()).or_default();
        *count = count.saturating_add(1);
        *count
    }

    /// The job has ended, or failed for another reason.
    pub(super) fn forget_failures(&self, id: &str) {
        self.failures().remove(id);
    }

    fn failures(&self) -> MutexGuard<'_, HashMap<String, u32>> {
        self.failures.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn jobs(&self) -> MutexGuard<'_, HashMap<String, Arc<UnderWay>>> {
        self.jobs.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
