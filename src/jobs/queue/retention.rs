//! Removes old jobs after their end, and the files that no other job names.

use std::collections::BTreeSet;
use std::sync::{Arc, MutexGuard, PoisonError};
use std::time::Duration;

use super::Shared;
use crate::jobs::JobFault;
use crate::store::Sha256Hex;

/// Time between two searches for old jobs.
const BETWEEN_LOOKS: Duration = Duration::from_hours(1);
/// How long tasks that name files wait at each search, so that files can be removed even if files are named all the
/// time.
const NAMING_WAITS: Duration = Duration::from_secs(1);

impl Shared {
    /// Removes old jobs every hour, until the service stops.
    pub(super) async fn forget_old_jobs(self: Arc<Self>) {
        loop {
            tokio::select! {
                () = self.stopping.cancelled() => return,
                () = tokio::time::sleep(BETWEEN_LOOKS) => {}
            }
            self.forget_now().await;
        }
    }

    /// Removes old jobs once.
    pub(super) async fn forget_now(&self) {
        if let Err(fault) = self.forget_once().await {
            tracing::error!(error = %fault, "old jobs cannot be removed");
        }
    }

    async fn forget_once(&self) -> Result<(), JobFault> {
        let ended_before = self.sources.timestamp_before(self.limits.job_retention_s);
        let keys_since = self.sources.timestamp_before(self.limits.key_retention_s);
        let keys_farthest = self.sources.farthest(self.limits.key_retention_s);
        let mut digests = Vec::new();
        loop {
            let now = self.sources.timestamp();
            let named = self.store.forget_jobs(&ended_before, [&keys_since, &keys_farthest], &now).await?;
            if named.is_empty() || self.stopping.is_cancelled() {
                break;
            }
            digests.extend(named);
        }
        self.give_up(digests);
        let files = self.tidy(NAMING_WAITS).await?;
        let left = self.given_up().len();
        if files > 0 || left > 0 {
            tracing::info!(files, left, "removed the files of old jobs");
        }
        Ok(())
    }

    /// Marks files for removal unless a job names them.
    pub(super) fn give_up(&self, digests: impl IntoIterator<Item = Sha256Hex>) {
        self.given_up().extend(digests);
    }

    /// Removes the marked files that no job names, and counts them. If files are being named during all of `within`,
    /// they are removed the next time.
    pub(super) async fn tidy(&self, within: Duration) -> Result<usize, JobFault> {
        if self.given_up().is_empty() {
            return Ok(0);
        }
        let blobs = self.spool.blobs();
        if blobs.are_copies() {
            let digests: BTreeSet<_> = std::mem::take(&mut *self.given_up()).into_iter().collect();
            for sha256 in &digests {
                blobs.remove(sha256)?;
            }
            // What stays in the database, because it was kept within a day, goes later (`tidy_copies`).
            let removed = self.store.remove_unnamed(Some(&digests)).await?;
            return Ok(usize::try_from(removed).unwrap_or(usize::MAX));
        }
        // Until this is dropped, no file is kept that a row will name later.
        let Some(_alone) = blobs.removing(within).await else { return Ok(0) };
        let named = self.store.named_blobs().await?;
        let digests = std::mem::take(&mut *self.given_up());
        let unnamed: Vec<_> = digests.into_iter().filter(|sha256| !named.contains(sha256)).collect();
        for (at, sha256) in unnamed.iter().enumerate() {
            if let Err(fault) = blobs.remove(sha256) {
                self.give_up(unnamed.get(at..).unwrap_or_default().iter().cloned());
                return Err(fault.into());
            }
        }
        Ok(unnamed.len())
    }

    fn given_up(&self) -> MutexGuard<'_, Vec<Sha256Hex>> {
        self.given_up.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
