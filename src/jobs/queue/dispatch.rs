//! Whose turn it is: a place in the pool first, then a job for it, so that what is said to run is really computed.

use std::sync::Arc;
use std::time::Duration;

use super::Shared;
use super::running::UnderWay;
use crate::jobs::turns::Place;
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
                Ok(Some((place, claimed, under_way))) => {
                    self.tasks.spawn(Arc::clone(&self).compute_job(claimed, under_way, (share, place)));
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

    /// A place, and the next job for it, which from now on is known to run. None where no job may begin or the service stops.
    async fn begin(&self) -> Result<Option<(Place, Claimed, Arc<UnderWay>)>, StoreError> {
        let most_of_caller = self.compute.most_jobs_of_caller();
        // Nobody gives way to a job that is not there.
        if !self.store.has_claimable(most_of_caller).await? {
            return Ok(None);
        }
        let place = tokio::select! {
            biased;
            () = self.stopping.cancelled() => return Ok(None),
            place = self.compute.queue_place() => place,
        };
        let Ok(place) = place else { return Ok(None) };
        let _gate = self.gate.lock().await;
        let (lease, now) = (self.sources.ids.next().to_string(), self.sources.timestamp());
        let claimed = self.store.claim(&lease, &now, env!("CARGO_PKG_VERSION"), most_of_caller).await?;
        let Some(claimed) = claimed else { return Ok(None) };
        let id = &claimed.job.document.id;
        let under_way = self.running.begin(id, &claimed.lease);
        self.changed(id);
        Ok(Some((place, claimed, under_way)))
    }

    /// Waits before something that failed is tried again, but not for a service that stops.
    pub(super) async fn pause(&self) {
        tokio::select! {
            () = self.stopping.cancelled() => {}
            () = tokio::time::sleep(RETRY) => {}
        }
    }
}
