//! The jobs that a process left when it died: each waits again, is cancelled, or is parked.

use serde_json::Value;

use super::machines::as_array;
use super::sql::Tx;
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

impl Recovered {
    /// Whether there was nothing to take up.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

row! {
    /// A job whose lease has expired.
    struct Expired {
        id: String,
        /// How it was computed, if its holder is dead.
        computed: Option<String>,
    }
}

impl Store {
    /// Takes over the jobs that a process had taken before it died. A job that its client had cancelled is cancelled.
    /// A job with too many deaths while it was computed alone fails with `problem`. All others wait again. A death
    /// counts only for the jobs that were `computed` at that moment. Only for the start. Of several services, each takes
    /// over the jobs of the process that had its data directory before.
    ///
    /// # Errors
    /// The database failed.
    pub async fn recover_jobs(
        &self,
        computed: &Died,
        problem: &Value,
        now: &str,
    ) -> Result<Recovered, StoreError> {
        let (problem, now, died) = (problem.to_string(), now.to_owned(), computed.clone());
        let previous = self.previous_holder().map(str::to_owned);
        let is_shared = self.is_shared();
        self.write("taking up jobs", |tx| {
            Box::pin(async move {
                let only = if is_shared {
                    let ids: Vec<String> = sql!(
                        tx,
                        all(_),
                        postgres "SELECT j.id FROM jobs j JOIN job_leases l ON l.job_id = j.id
                                  WHERE j.state = 'running' AND l.holder = $1 ORDER BY j.id FOR UPDATE OF j",
                        previous
                    )?;
                    Some(ids)
                } else {
                    None
                };
                take_up(tx, only, &died, &problem, &now).await
            })
        })
        .await
    }

    /// Takes over the jobs whose leases have expired. If the holder of a lease is dead, its death counts, but only if
    /// this service is `steady`: if it could not reach the database itself a moment ago, neither could the others, and
    /// the jobs of those that seem to be dead are left until that is known.
    ///
    /// # Errors
    /// The database failed.
    pub async fn take_up_expired(
        &self,
        steady: bool,
        problem: &Value,
        now: &str,
    ) -> Result<Recovered, StoreError> {
        let (problem, now) = (problem.to_string(), now.to_owned());
        self.write("taking up expired jobs", |tx| {
            Box::pin(async move {
                let expired: Vec<Expired> = sql!(
                    tx,
                    all(Expired),
                    postgres "SELECT j.id, CASE WHEN i.stopped_at IS NULL
                                  AND i.seen_at < clock_timestamp() - INTERVAL '30 s' THEN l.computed END AS computed
                              FROM jobs j JOIN job_leases l ON l.job_id = j.id
                              LEFT JOIN instances i ON i.id = l.holder
                              WHERE j.state = 'running' AND l.lease_until < clock_timestamp()
                              ORDER BY j.id FOR UPDATE OF j SKIP LOCKED"
                )?;
                let (mut ids, mut died) = (Vec::new(), Died::default());
                for Expired { id, computed } in expired {
                    match computed.as_deref() {
                        Some(_) if !steady => continue,
                        Some("alone") => died.alone.insert(id.clone()),
                        Some(_) => died.beside.insert(id.clone()),
                        None => false,
                    };
                    ids.push(id);
                }
                take_up(tx, Some(ids), &died, &problem, &now).await
            })
        })
        .await
    }
}

/// Takes over running jobs: all of them, or only these.
async fn take_up(
    tx: &mut Tx<'_>,
    only: Option<Vec<String>>,
    died: &Died,
    problem: &str,
    now: &str,
) -> Result<Recovered, sqlx::Error> {
    if only.as_ref().is_some_and(Vec::is_empty) {
        return Ok(Recovered::default());
    }
    let only = only.map(|ids| Value::from(ids).to_string());
    let (beside, alone) = (as_array(Some(&died.beside)), as_array(Some(&died.alone)));
    let cancelled = sql!(
        tx,
        all(_),
        "UPDATE jobs SET state = 'cancelled', finished_at = $1, lease = NULL
         WHERE state = 'running' AND cancel_requested = 1
             AND (CAST($2 AS TEXT) IS NULL OR id IN (SELECT value FROM json_each($2))) RETURNING id",
        now,
        only
    )?;
    sql!(
        tx,
        execute,
        "UPDATE jobs SET
             deaths = CASE WHEN id IN (SELECT value FROM json_each($1)) THEN deaths + 1 ELSE deaths END,
             lone_deaths = lone_deaths
                 + CASE WHEN id IN (SELECT value FROM json_each($2)) THEN 1 ELSE 0 END
         WHERE state = 'running' AND (CAST($3 AS TEXT) IS NULL OR id IN (SELECT value FROM json_each($3)))",
        beside,
        alone,
        only
    )?;
    let parked = sql!(
        tx,
        all(_),
        "UPDATE jobs SET state = 'failed', problem = $1, finished_at = $2, lease = NULL
         WHERE state = 'running' AND lone_deaths >= $3
             AND (CAST($4 AS TEXT) IS NULL OR id IN (SELECT value FROM json_each($4))) RETURNING id",
        problem,
        now,
        LONE_DEATHS,
        only
    )?;
    let queued = sql!(
        tx,
        execute,
        "UPDATE jobs SET state = 'queued', started_at = NULL, lease = NULL
         WHERE state = 'running' AND (CAST($1 AS TEXT) IS NULL OR id IN (SELECT value FROM json_each($1)))",
        only
    )?;
    Ok(Recovered { queued, parked, cancelled })
}
