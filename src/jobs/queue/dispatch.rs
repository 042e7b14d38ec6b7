//! Takes jobs from the queue, as many as may have begun at a time. Each waits for its turn to compute beside the others and in the
//! name of its caller, so that nobody stands in line behind another's job.

use std::sync::Arc;
use std::time::Duration;

use super::Shared;
use super::running::UnderWay;
use crate::store::{Claimed, StoreError};

/// How long to wait before a store that failed is asked again.
pub(super) const RETRY: Duration = Duration::from_secs(1);

impl Shared {
    /// Takes jobs from the queue until the service stops.
    pub(super) async fn dispatch(self: Arc<Self>) {
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

    /// The next job, which from now on is known to run. None where no job may begin or the service stops.
    async fn begin(&self) -> Result<Option<(Claimed, Arc<UnderWay>)>, StoreError> {
        let most_of_caller = self.compute.most_jobs_of_caller();
        // To look costs less than to write.
        if !self.store.has_claimable(most_of_caller).await? || self.stopping.is_cancelled() {
            return Ok(None);
        }
        let _gate = self.gate.lock().await;
        let (lease, now) = (self.sources.ids.next().to_string(), self.sources.timestamp());
        let claimed = self.store.claim(&lease, &now, env!("CARGO_PKG_VERSION"), most_of_caller).await?;
        let Some(claimed) = claimed else { return Ok(None) };
        let id = &claimed.job.document.id;
        let under_way = self.running.begin(id, &claimed.lease);
        self.changed(id);
        Ok(Some((claimed, under_way)))
    }

    /// Waits before something that failed is tried again, but not for a service that stops.
    pub(super) async fn pause(&self) {
        tokio::select! {
            () = self.stopping.cancelled() => {}
            () = tokio::time::sleep(RETRY) => {}
        }
    }
}
