//! Takes jobs from the queue, up to the number that may have begun. Each waits for its turn to compute, beside the
//! others and on behalf of its caller, so that no caller waits in line after another caller's job.

use std::future::pending;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::Shared;
use super::running::UnderWay;
use crate::store::{Claimed, StoreError};

/// Pause before a failed store is asked again.
pub(super) const RETRY: Duration = Duration::from_secs(1);
/// Time between two looks for the jobs of other services.
const BETWEEN_LOOKS: Duration = Duration::from_secs(1);

impl Shared {
    /// Removes old jobs once, and then begins to compute. The first removal ends before the first job begins, so that
    /// two starts from the same files write in the same order.
    pub(super) async fn begin_work(self: Arc<Self>) {
        if self.limits.job_retention_s > 0.0 {
            self.forget_now().await;
            self.tasks.spawn(Arc::clone(&self).forget_old_jobs());
        }
        self.begun.cancel();
        self.dispatch().await;
    }

    /// Takes jobs from the queue until the service stops.
    async fn dispatch(self: Arc<Self>) {
        loop {
            let share = tokio::select! {
                biased;
                () = self.stopping.cancelled() => return,
                share = self.compute.queue_share() => share,
            };
            let Ok(share) = share else { return };
            match self.begin().await {
                Ok(Some((claimed, under_way))) => {
                    self.tasks.spawn(Arc::clone(&self).compute_job(claimed, under_way, share));
                }
                Ok(None) => {
                    drop(share);
                    tokio::select! {
                        () = self.stopping.cancelled() => return,
                        () = self.more.notified() => {}
                        () = self.others_may_have_queued() => {}
                    }
                }
                Err(fault) => {
                    drop(share);
                    tracing::error!(error = %fault, "no job can be taken from the queue");
                    self.pause().await;
                }
            }
        }
    }

    /// The next job, which counts as running from now on. `None` if no job may begin, or if the service stops.
    async fn begin(&self) -> Result<Option<(Claimed, Arc<UnderWay>)>, StoreError> {
        let most_of_caller = self.compute.most_jobs_of_caller();
        // A check costs less than a write.
        if !self.store.has_claimable(most_of_caller).await? || self.stopping.is_cancelled() {
            return Ok(None);
        }
        let _gate = self.gate.lock().await;
        let (lease, now) = (self.sources.ids.next().to_string(), self.sources.timestamp());
        let asked = Instant::now();
        let claimed = self.store.claim(&lease, &now, env!("CARGO_PKG_VERSION"), most_of_caller).await?;
        let Some(claimed) = claimed else { return Ok(None) };
        let id = &claimed.job.document.id;
        let under_way = self.running.begin(id, &claimed.lease, asked);
        self.changed(id);
        Ok(Some((claimed, under_way)))
    }

    /// Waits for a moment if other services may queue jobs, and for ever if there are none.
    async fn others_may_have_queued(&self) {
        if self.store.is_shared() {
            tokio::time::sleep(BETWEEN_LOOKS).await;
        } else {
            pending::<()>().await;
        }
    }

    /// Waits before a failed action is repeated, but ends at once if the service stops.
    pub(super) async fn pause(&self) {
        tokio::select! {
            () = self.stopping.cancelled() => {}
            () = tokio::time::sleep(RETRY) => {}
        }
    }
}
