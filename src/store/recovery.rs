//! The jobs that a process left when it died: each waits again, is cancelled, or is parked.

use serde_json::Value;

use super::machines::as_array;
use super::{Died, Store, StoreError};

/// Number of deaths while it was computed alone after which a job counts as the cause. Some deaths may still have
/// come from outside: if a process lives no longer than a job takes, each death affects the job.
const LONE_DEATHS: i64 = 5;

/// The jobs that a dead process left.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Recovered {
    /// Jobs that wait again.
    pub queued: u64,
    /// Jobs that failed because the process died too often while they were computed alone.
    pub parked: Vec<String>,
    /// Jobs that their clients had cancelled.
    pub cancelled: Vec<String>,
}

impl Store {
    /// Takes over the jobs that a process had taken before it died. A job that its client had cancelled is cancelled.
    /// A job with too many deaths while it was computed alone fails with `problem`. All others wait again. A death
    /// counts only for the jobs that were `computed` at that moment. Only for the start.
    ///
    /// # Errors
    /// The database failed.
    pub async fn recover_jobs(
        &self,
        computed: &Died,
        problem: &Value,
        now: &str,
    ) -> Result<Recovered, StoreError> {
        let (problem, now) = (problem.to_string(), now.to_owned());
        let (beside, alone) = (as_array(Some(&computed.beside)), as_array(Some(&computed.alone)));
        self.write("taking up jobs", |tx| {
            Box::pin(async move {
                let cancelled = sql!(
                    tx,
                    all(_),
                    "UPDATE jobs SET state = 'cancelled', finished_at = $1, lease = NULL
                     WHERE state = 'running' AND cancel_requested = 1 RETURNING id",
                    now
                )?;
                sql!(
                    tx,
                    execute,
                    "UPDATE jobs SET
                         deaths = CASE WHEN id IN (SELECT value FROM json_each($1)) THEN deaths + 1 ELSE deaths END,
                         lone_deaths = lone_deaths
                             + CASE WHEN id IN (SELECT value FROM json_each($2)) THEN 1 ELSE 0 END
                     WHERE state = 'running'",
                    beside,
                    alone
                )?;
                let parked = sql!(
                    tx,
                    all(_),
                    "UPDATE jobs SET state = 'failed', problem = $1, finished_at = $2, lease = NULL
                     WHERE state = 'running' AND lone_deaths >= $3 RETURNING id",
                    problem,
                    now,
                    LONE_DEATHS
                )?;
                let queued = sql!(
                    tx,
                    execute,
                    "UPDATE jobs SET state = 'queued', started_at = NULL, lease = NULL WHERE state = 'running'"
                )?;
                Ok(Recovered { queued, parked, cancelled })
            })
        })
        .await
    }
}
