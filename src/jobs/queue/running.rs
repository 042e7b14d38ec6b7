//! The jobs that are being computed in this process.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use tokio_util::sync::CancellationToken;

use crate::jobs::Progress;
use crate::store::HeldLease;

/// One job that is being computed.
#[derive(Debug)]
pub(super) struct UnderWay {
    /// The lease that its ending must name.
    pub(super) lease: String,
    /// Cancelled to stop it.
    pub(super) stop: CancellationToken,
    /// How far it has come, once it has begun.
    reading: OnceLock<Progress>,
    /// When the last renewal of its lease began that came through.
    renewed: Mutex<Instant>,
    /// Whether its lease may have been given to another service.
    lost: AtomicBool,
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

    /// Whether its lease may have been given to another service.
    pub(super) fn is_lost(&self) -> bool {
        self.lost.load(Ordering::SeqCst)
    }

    /// Its lease was given to another service: its work stops.
    pub(super) fn lose(&self) {
        self.lost.store(true, Ordering::SeqCst);
        self.stop.cancel();
    }

    fn renewed(&self) -> MutexGuard<'_, Instant> {
        self.renewed.lock().unwrap_or_else(PoisonError::into_inner)
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
    /// A job begins. Its lease was asked for at this moment or later.
    pub(super) fn begin(&self, id: &str, lease: &str, asked: Instant) -> Arc<UnderWay> {
        let (stop, reading) = (CancellationToken::new(), OnceLock::new());
        let (renewed, lost) = (Mutex::new(asked), AtomicBool::new(false));
        let under_way = Arc::new(UnderWay { lease: lease.to_owned(), stop, reading, renewed, lost });
        self.jobs().insert(id.to_owned(), Arc::clone(&under_way));
        under_way
    }

    /// A job is settled. It may already run again under another lease.
    pub(super) fn end(&self, id: &str, lease: &str) {
        let mut jobs = self.jobs();
        if jobs.get(id).is_some_and(|job| job.lease == lease) {
            jobs.remove(id);
        }
    }

    /// The leases of all running jobs.
    pub(super) fn held(&self) -> Vec<HeldLease> {
        let held = |(id, job): (&String, &Arc<UnderWay>)| HeldLease {
            id: id.clone(),
            lease: job.lease.clone(),
            progress: job.progress(),
        };
        self.jobs().iter().map(held).collect()
    }

    /// The lease of a job was renewed by a request that began at this moment.
    pub(super) fn renewed(&self, held: &HeldLease, at: Instant) {
        if let Some(job) = self.of_lease(held) {
            *job.renewed() = at;
        }
    }

    /// The lease of a job is not valid any more: its work stops.
    pub(super) fn lose(&self, held: &HeldLease) {
        if let Some(job) = self.of_lease(held) {
            job.lose();
        }
    }

    /// Stops the work on jobs whose leases were not renewed for so long; returns how many that were.
    pub(super) fn lose_after(&self, longest: Duration) -> usize {
        let jobs: Vec<_> = self.jobs().values().cloned().collect();
        let old = |job: &&Arc<UnderWay>| !job.is_lost() && job.renewed().elapsed() >= longest;
        jobs.iter().filter(old).map(|job| job.lose()).count()
    }

    fn of_lease(&self, held: &HeldLease) -> Option<Arc<UnderWay>> {
        self.jobs().get(&held.id).filter(|job| job.lease == held.lease).cloned()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lease_that_is_not_renewed_stops_its_work_and_no_other() {
        let running = Running::default();
        let long_ago = Instant::now().checked_sub(Duration::from_secs(21)).unwrap();
        let (old, new) = (running.begin("old", "1", long_ago), running.begin("new", "2", long_ago));
        let held = running.held();
        running.renewed(held.iter().find(|held| held.id == "new").unwrap(), Instant::now());
        assert_eq!(running.lose_after(Duration::from_secs(20)), 1);
        assert!(old.is_lost() && old.stop.is_cancelled() && !new.is_lost() && !new.stop.is_cancelled());
        assert_eq!(running.lose_after(Duration::from_secs(20)), 0, "once");
    }

    #[test]
    fn a_job_that_runs_again_is_not_touched_by_its_earlier_attempt() {
        let running = Running::default();
        running.begin("job", "first", Instant::now());
        let earlier = running.held().remove(0);
        let again = running.begin("job", "second", Instant::now());
        running.lose(&earlier);
        running.end("job", "first");
        assert!(!again.is_lost() && running.progress("job").is_some());
        running.end("job", "second");
        assert!(running.progress("job").is_none());
    }
}
