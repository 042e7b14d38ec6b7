//! Whose turn it is: a place in the pool first, then a job for it, so that what is said to run is really computed.

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
            let turn = tokio::select! {
                biased;
                () = self.stopping.cancelled() => return,
                turn = self.compute.queue_turn() => turn,
            };
            let Ok(turn) = turn else { return };
            match self.begin().await {
                Ok(Some((claimed, under_way))) => {
                    self.tasks.spawn(Arc::clone(&self).compute_job(claimed, under_way, turn));
                }
                Ok(None) => {
                    drop(turn);
                    tokio::select! {
                        () = self.stopping.cancelled() => return,
                        () = self.more.notified() => {}
                    }
                }
                Err(fault) => {
                    drop(turn);
                    tracing::error!(error = %fault, "no job can be taken from the queue");
                    self.pause().await;
                }
            }
        }
    }

    /// The next job, which from now on is known to run.
    async fn begin(&self) -> Result<Option<(Claimed, Arc<UnderWay>)>, StoreError> {
        let _gate = self.gate.lock().await;
        let (lease, now) = (self.sources.ids.next().to_string(), self.sources.timestamp());
        let Some(claimed) = self.store.claim(&lease, &now, env!("CARGO_PKG_VERSION")).await? else {
            return Ok(None);
        };
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
