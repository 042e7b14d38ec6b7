//! What several services on one database know of each other. With a database that one service has, there are no others:
//! nothing here does anything then.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Instant;

use jiff::Timestamp;
use serde::Serialize;
use tokio::sync::broadcast;

use super::error::Doing;
use super::{Store, StoreError};

/// A job that this service computes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeldLease {
    /// The job.
    pub id: String,
    /// Its lease.
    pub lease: String,
    /// Its progress, 0 to 1.
    pub progress: f64,
}

/// The jobs whose leases were moved on.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Renewed {
    /// Jobs that are still this service's.
    pub held: BTreeSet<String>,
    /// Those of them that their clients have cancelled.
    pub cancelled: BTreeSet<String>,
}

/// What another service, or this one, has changed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Signal {
    /// The job with this id waits.
    Queued(Arc<str>),
    /// The job with this id has another state.
    Changed(Arc<str>),
    /// The client has cancelled the job with this id.
    Cancelled(Arc<str>),
}

impl Store {
    /// Whether other services may use the database at the same time.
    #[must_use]
    pub fn is_shared(&self) -> bool {
        self.instance.is_some()
    }

    /// The name under which this process takes jobs; empty if nobody has to know it.
    pub(super) fn holder(&self) -> &str {
        self.name.as_deref().unwrap_or_default()
    }

    /// The name of the process that had the data directory before, if its jobs may still be its own.
    pub(super) fn previous_holder(&self) -> Option<&str> {
        let instance = self.instance.as_ref()?;
        #[cfg(feature = "scale-out")]
        return instance.previous();
        #[cfg(not(feature = "scale-out"))]
        match *instance {}
    }

    /// What other services have changed from now on; `None` if there are none. A signal may be lost.
    #[must_use]
    pub fn signals(&self) -> Option<broadcast::Receiver<Signal>> {
        let instance = self.instance.as_ref()?;
        #[cfg(feature = "scale-out")]
        return Some(instance.signals());
        #[cfg(not(feature = "scale-out"))]
        match *instance {}
    }

    /// The number of changes of API keys that other services, or this one, have told: while it stays the same, nothing
    /// was told.
    #[must_use]
    pub fn key_changes(&self) -> u64 {
        match &self.instance {
            None => 0,
            #[cfg(feature = "scale-out")]
            Some(instance) => instance.key_changes(),
            #[cfg(not(feature = "scale-out"))]
            Some(never) => match *never {},
        }
    }

    /// The time of the database's server, and when it was last heard, if several services share the database: its clock
    /// counts for all of them.
    #[must_use]
    pub fn server_time(&self) -> Option<(Instant, Timestamp)> {
        let instance = self.instance.as_ref()?;
        #[cfg(feature = "scale-out")]
        return instance.server_time();
        #[cfg(not(feature = "scale-out"))]
        match *instance {}
    }

    /// Removes what is known of services that ended more than a day ago, and counts them. A service that still has a
    /// lease stays known: whether it has died decides about its jobs.
    ///
    /// # Errors
    /// The database failed.
    pub async fn forget_services(&self) -> Result<u64, StoreError> {
        self.write_apart("forgetting services that ended", |tx| {
            Box::pin(async move {
                sql!(
                    tx,
                    execute,
                    postgres "DELETE FROM instances i
                              WHERE greatest(i.seen_at, i.stopped_at) < clock_timestamp() - INTERVAL '1 day'
                                AND NOT EXISTS (SELECT 1 FROM job_leases l WHERE l.holder = i.id)"
                )
            })
        })
        .await
    }

    /// Says that this service lives, and keeps these jobs for another 30 s.
    ///
    /// # Errors
    /// The database failed, or did not answer within a few seconds.
    #[cfg_attr(not(feature = "scale-out"), expect(unused_variables, reason = "no other service exists"))]
    pub async fn renew(&self, held: &[HeldLease]) -> Result<Renewed, StoreError> {
        match &self.instance {
            None => std::future::ready(Ok(Renewed::default())).await,
            #[cfg(feature = "scale-out")]
            Some(instance) => Box::pin(instance.renew(held)).await.doing("renewing leases"),
            #[cfg(not(feature = "scale-out"))]
            Some(never) => match *never {},
        }
    }

    /// Notes that the computation of a job begins: from now on a death of this service may blame it. `false` if the
    /// lease is no longer valid.
    ///
    /// # Errors
    /// The database failed.
    pub async fn note_computed(&self, id: &str, lease: &str, alone: bool) -> Result<bool, StoreError> {
        if !self.is_shared() {
            return Ok(true);
        }
        let (id, lease) = (id.to_owned(), lease.to_owned());
        let how = if alone { "alone" } else { "beside" };
        let noted: u64 = self
            .write_apart("noting that a job is computed", |tx| {
                Box::pin(async move {
                    sql!(
                        tx,
                        execute,
                        postgres "UPDATE job_leases SET computed = $1 WHERE job_id = $2 AND lease = $3",
                        how,
                        id,
                        lease
                    )
                })
            })
            .await?;
        Ok(noted == 1)
    }

    /// Whether a lease has expired.
    ///
    /// # Errors
    /// The database failed.
    pub async fn has_expired_lease(&self) -> Result<bool, StoreError> {
        let found: Option<Option<String>> = sql!(
            self.db,
            optional(_),
            postgres "SELECT job_id AS \"job_id?\" FROM job_leases WHERE lease_until < clock_timestamp() LIMIT 1"
        )
        .doing("looking for expired leases")?;
        Ok(found.is_some())
    }
}
