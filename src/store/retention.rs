//! Removes old jobs after their end, and the files that only they named.

use super::audit::{Actor, Change, audit};
use super::keys::forget_keys;
use super::{Sha256Hex, Store, StoreError};
use crate::wire::{AuditAction, AuditOrigin};

/// Jobs removed in one transaction: other transactions write in between.
const REMOVED_AT_ONCE: i64 = 200;

row! {
    /// A job that was removed, and the files that it named.
    struct RemovedJob {
        id: String,
        machine_id: String,
        input_sha256: String,
        surface_sha256: Option<String>,
        output_sha256: Option<String>,
        changes_sha256: Option<String>,
    }
}

impl Store {
    /// Removes some of the jobs that ended before `ended_before` and whose idempotency key, if any, was used before
    /// `keys_since`. A key stored as used after `keys_farthest` counts as used then. A job whose webhook still waits
    /// stays. The audit log records each removal, at `now`. Returns the digests that the removed jobs named; `None`
    /// when there is nothing left to remove.
    ///
    /// # Errors
    /// The database failed.
    pub async fn forget_jobs(
        &self,
        ended_before: &str,
        [keys_since, keys_farthest]: [&str; 2],
        now: &str,
    ) -> Result<Vec<Sha256Hex>, StoreError> {
        let [ended_before, keys_since, keys_farthest, now] =
            [ended_before, keys_since, keys_farthest, now].map(str::to_owned);
        self.write("forgetting jobs", |tx| {
            Box::pin(async move {
                forget_keys(tx, &keys_since, &keys_farthest).await?;
                let removed = sql!(
                    tx,
                    all(RemovedJob),
                    "DELETE FROM jobs WHERE seq IN (
                         SELECT seq FROM jobs j WHERE finished_at < $1
                             AND NOT EXISTS (SELECT 1 FROM idempotency_keys k WHERE k.job_id = j.id)
                             AND NOT EXISTS
                                 (SELECT 1 FROM deliveries d WHERE d.job_id = j.id AND d.state = 'waiting')
                         ORDER BY finished_at LIMIT $2)
                     RETURNING id, machine_id, input_sha256, surface_sha256, output_sha256, changes_sha256",
                    ended_before,
                    REMOVED_AT_ONCE
                )?;
                let service = Actor::without_request(AuditOrigin::Service);
                for job in &removed {
                    let change = Change {
                        at: &now,
                        action: AuditAction::JobRemoved,
                        machine_id: Some(&job.machine_id),
                        resource: format!("/v1/jobs/{}", job.id),
                        revisions: (None, None),
                    };
                    audit(tx, &service, change).await?;
                }
                let named = removed.into_iter().flat_map(|row| {
                    [Some(row.input_sha256), row.surface_sha256, row.output_sha256, row.changes_sha256]
                });
                Ok(named.flatten().collect())
            })
        })
        .await
    }
}
