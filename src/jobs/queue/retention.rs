//! Jobs that ended long ago go, with the files that no other job names.

use std::sync::Arc;
use std::time::Duration;

use super::Shared;
use crate::jobs::JobFault;
use crate::store::Sha256Hex;

/// Time between two looks for jobs that are too old.
const BETWEEN_LOOKS: Duration = Duration::from_hours(1);

impl Shared {
    /// Removes what is too old, now and every hour, until the service stops.
    pub(super) async fn forget_old_jobs(self: Arc<Self>) {
        loop {
            if let Err(fault) = self.forget_once().await {
                tracing::error!(error = %fault, "old jobs cannot be removed");
            }
            tokio::select! {
                () = self.stopping.cancelled() => return,
                () = tokio::time::sleep(BETWEEN_LOOKS) => {}
            }
        }
    }

    async fn forget_once(&self) -> Result<(), JobFault> {
        let ended_before = self.sources.timestamp_before(self.limits.job_retention_s);
        let keys_since = self.sources.timestamp_before(self.limits.key_retention_s);
        let mut digests = Vec::new();
        loop {
            let named = self.store.forget_jobs(&ended_before, &keys_since).await?;
            if named.is_empty() || self.stopping.is_cancelled() {
                break;
            }
            digests.extend(named);
        }
        let removed = self.remove_unnamed(digests).await?;
        if removed > 0 {
            tracing::info!(files = removed, "removed the files of jobs that ended long ago");
        }
        Ok(())
    }

    /// Removes those of these files that no job names; gives how many.
    pub(super) async fn remove_unnamed(&self, mut digests: Vec<Sha256Hex>) -> Result<usize, JobFault> {
        if digests.is_empty() {
            return Ok(0);
        }
        let blobs = self.spool.blobs();
        // Until this goes, nothing is kept that a row is yet to name.
        let _alone = blobs.removing().await;
        let named = self.store.named_blobs().await?;
        digests.retain(|sha256| !named.contains(sha256));
        for sha256 in &digests {
            blobs.remove(sha256)?;
        }
        Ok(digests.len())
    }
}
