//! What a queue does because other services have the same database: it keeps the leases of its jobs, takes up those of
//! services that died, and passes on what others change. With a database of its own it does none of this.

use std::sync::Arc;
use std::time::{Duration, Instant};

use tokio::sync::broadcast::Receiver;
use tokio::sync::broadcast::error::RecvError;

use super::Shared;
use super::computing::problem_code;
use crate::jobs::JobFault;
use crate::store::{Recovered, Signal, StoreError};

/// Time between two renewals. A lease lasts 30 s.
const RENEWED_EVERY: Duration = Duration::from_secs(5);
/// Time between two looks at the clock, and between two attempts of a renewal that fails.
const TICK: Duration = Duration::from_secs(1);
/// How long after the last renewal the work on a job stops: it has 10 s to stop before its lease can go to another
/// service.
const STOPS_AFTER: Duration = Duration::from_secs(20);
/// Time between two looks for expired leases.
const LOOKS_EVERY: Duration = Duration::from_secs(1);
/// How long this service must have reached the database before it says that another one is dead: three renewals of that
/// one.
const STEADY_AFTER: Duration = Duration::from_secs(15);
/// Largest time between two renewals of a service that has reached the database all the time.
const UNBROKEN: Duration = Duration::from_secs(10);
/// Time between two removals of files that no job names.
const TIDIED_EVERY: Duration = Duration::from_hours(1);
/// Time between two looks at everything in the bucket.
const SWEPT_EVERY: Duration = Duration::from_hours(24);
/// For how long a copy of a file stays in the data directory.
const COPIES_STAY: Duration = Duration::from_hours(24);

/// Since when this service has reached the database without a break.
#[derive(Debug, Default)]
pub(super) struct Contact(std::sync::Mutex<Option<Reached>>);

#[derive(Debug, Clone, Copy)]
struct Reached {
    since: Instant,
    last: Instant,
}

impl Contact {
    /// The database was reached at this moment.
    fn note(&self, at: Instant) {
        let mut reached = self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let since = match *reached {
            Some(reached) if at.duration_since(reached.last) < UNBROKEN => reached.since,
            _ => at,
        };
        *reached = Some(Reached { since, last: at });
    }

    /// Whether the database was reached at all times for a while.
    fn is_steady(&self, now: Instant) -> bool {
        let reached = *self.0.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        reached.is_some_and(|Reached { since, last }| {
            now.duration_since(last) < UNBROKEN && last.duration_since(since) >= STEADY_AFTER
        })
    }
}

impl Shared {
    /// Begins what other services make necessary. It ends when the service is about to close the database.
    pub(super) fn begin_sharing(self: &Arc<Self>) {
        let Some(signals) = self.store.signals() else { return };
        let tasks = [
            tokio::spawn(Arc::clone(self).keep_leases()),
            tokio::spawn(Arc::clone(self).take_up_expired()),
            tokio::spawn(Arc::clone(self).tidy_copies()),
            tokio::spawn(Arc::clone(self).follow(signals)),
        ];
        // Each ends by itself.
        drop(tasks);
    }

    /// Renews the leases of the running jobs. Jobs that their clients have cancelled stop, and so do those whose lease
    /// may have gone to another service.
    async fn keep_leases(self: Arc<Self>) {
        let mut next = Instant::now();
        loop {
            tokio::select! {
                () = self.halted.cancelled() => return,
                () = tokio::time::sleep(TICK.min(next.saturating_duration_since(Instant::now()))) => {}
                () = self.renew_now.notified() => next = Instant::now(),
            }
            let lost = self.running.lose_after(STOPS_AFTER);
            if lost > 0 {
                tracing::error!(jobs = lost, "jobs stop, because their leases could not be renewed");
            }
            if Instant::now() < next {
                continue;
            }
            next = match self.renew().await {
                Ok(began) => began + RENEWED_EVERY,
                Err(fault) => {
                    tracing::warn!(error = %fault, "the leases of running jobs could not be renewed");
                    Instant::now() + TICK
                }
            };
        }
    }

    /// Renews the leases once; returns when that began.
    async fn renew(&self) -> Result<Instant, StoreError> {
        let (began, held) = (Instant::now(), self.running.held());
        let renewed = self.store.renew(&held).await?;
        self.contact.note(began);
        if let Some((at, time)) = self.store.server_time() {
            self.sources.clock.hear(at, time);
        }
        for lease in &held {
            if renewed.held.contains(&lease.id) {
                self.running.renewed(lease, began);
            } else {
                self.running.lose(lease);
            }
        }
        for id in &renewed.cancelled {
            self.running.stop(id);
        }
        Ok(began)
    }

    /// Takes up the jobs of services that died, or that have lost the database for too long.
    async fn take_up_expired(self: Arc<Self>) {
        loop {
            tokio::select! {
                () = self.halted.cancelled() => return,
                () = tokio::time::sleep(LOOKS_EVERY) => {}
            }
            if self.stopping.is_cancelled() {
                continue;
            }
            match self.take_up_once().await {
                Ok(recovered) => self.took_up(&recovered).await,
                Err(fault) => tracing::debug!(error = %fault, "expired leases cannot be looked for"),
            }
        }
    }

    async fn take_up_once(&self) -> Result<Recovered, StoreError> {
        if !self.store.has_expired_lease().await? {
            return Ok(Recovered::default());
        }
        let steady = self.contact.is_steady(Instant::now());
        let died = (self.describe)(JobFault::ProcessDied);
        self.store.take_up_expired(steady, &died, &self.sources.timestamp()).await
    }

    /// Tells of jobs that were taken up, and computes those that wait again.
    pub(super) async fn took_up(&self, recovered: &Recovered) {
        if recovered.queued > 0 {
            tracing::warn!(jobs = recovered.queued, "jobs of a process that died are queued again");
            self.more.notify_one();
        }
        let died = (self.describe)(JobFault::ProcessDied);
        for id in recovered.parked.iter().chain(&recovered.cancelled) {
            let parked = recovered.parked.contains(id);
            let problem = parked.then(|| problem_code(&died)).flatten();
            tracing::warn!(job_id = id, parked, problem, "a job ended because its process died");
            self.on_finished(id).await;
        }
    }

    /// Removes files that no job names, copies that nobody has needed for long, and services that ended long ago.
    async fn tidy_copies(self: Arc<Self>) {
        let mut swept: Option<Instant> = None;
        loop {
            let blobs = self.spool.blobs().clone();
            if swept.is_none_or(|at| at.elapsed() >= SWEPT_EVERY) {
                match self.store.sweep_bucket().await {
                    Ok(0) => swept = Some(Instant::now()),
                    Ok(files) => {
                        swept = Some(Instant::now());
                        tracing::info!(files, "removed files of the bucket that no row names");
                    }
                    Err(fault) => tracing::warn!(error = %fault, "the bucket is not tidied yet"),
                }
            }
            match self.store.remove_unnamed(None).await {
                Ok(0) => {}
                Ok(files) => tracing::info!(files, "removed files that no job names"),
                Err(fault) => tracing::warn!(error = %fault, "files that no job names are not removed yet"),
            }
            if let Err(fault) = self.store.forget_services().await {
                tracing::warn!(error = %fault, "services that ended long ago are not forgotten yet");
            }
            let removed = tokio::task::spawn_blocking(move || blobs.remove_copies(COPIES_STAY)).await;
            if let Ok(Err(fault)) = removed {
                tracing::warn!(error = %fault, "old copies of files are not removed yet");
            }
            tokio::select! {
                () = self.halted.cancelled() => return,
                () = tokio::time::sleep(TIDIED_EVERY) => {}
            }
        }
    }

    /// Passes on what other services change.
    async fn follow(self: Arc<Self>, mut signals: Receiver<Signal>) {
        loop {
            let signal = tokio::select! {
                () = self.halted.cancelled() => return,
                signal = signals.recv() => signal,
            };
            match signal {
                Ok(Signal::Queued(id)) => {
                    self.changed(&id);
                    self.more.notify_one();
                }
                Ok(Signal::Changed(id)) => self.changed(&id),
                Ok(Signal::Cancelled(id)) if self.running.progress(&id).is_some() => {
                    self.renew_now.notify_one();
                }
                Ok(Signal::Cancelled(_)) => {}
                Err(RecvError::Lagged(_)) => self.more.notify_one(),
                Err(RecvError::Closed) => return,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_service_that_lost_the_database_for_a_moment_calls_nobody_dead() {
        let (contact, began) = (Contact::default(), Instant::now());
        let at = |seconds: u64| began + Duration::from_secs(seconds);
        assert!(!contact.is_steady(began));
        for seconds in [0, 5, 10] {
            contact.note(at(seconds));
            assert!(!contact.is_steady(at(seconds)), "{seconds}");
        }
        contact.note(at(15));
        assert!(contact.is_steady(at(16)) && !contact.is_steady(at(25)), "the last renewal is too long ago");
        // Away from 15 s to 40 s.
        contact.note(at(40));
        contact.note(at(45));
        assert!(!contact.is_steady(at(45)));
        for seconds in [50, 55] {
            contact.note(at(seconds));
        }
        assert!(contact.is_steady(at(55)));
    }
}
