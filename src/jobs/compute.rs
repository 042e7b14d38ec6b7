//! The one pool that computes: a fixed number of computations at the same time, a fixed number waiting. No
//! computation continues for a client that has left.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use thiserror::Error;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio_util::sync::CancellationToken;

use super::compute_threads::{ComputeThreads, LentThreads};
use super::cpu_time::CpuTime;
use super::memory::{self, MemoryFault};
use super::turns::{Place, Turns};
use super::{PartSurfaceFault, asker};
use crate::meter;
use crate::process::Stop;
use crate::shares::{NoShare, Quota, Share, Shares, Who};
use crate::side_by_side::SideBySide;
use crate::surface::Mesh;

/// Why there is no result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ComputeFault {
    /// All places are taken, including the waiting places.
    #[error("all computation places are taken; retry later")]
    Busy,
    /// There is no memory for the computation.
    #[error(transparent)]
    Memory(#[from] MemoryFault),
    /// The caller holds its full share of the places.
    #[error(transparent)]
    NoShare(NoShare),
    /// The computation panicked: a fault of the service.
    #[error("the computation panicked")]
    Panicked,
    /// It took ten times the processor time that it may take: the estimate was wrong.
    #[error(
        "the computation was stopped after {:.3} s of processor time; its limit of {:.3} s is ten times `max_cost_s`. Divide the program, reduce the surface, or raise `max_cost_s`",
        spent.as_secs_f64(), limit.as_secs_f64()
    )]
    TooCostly {
        /// Processor time of all its threads.
        spent: Duration,
        /// Largest allowed processor time.
        limit: Duration,
    },
}

/// The pool.
#[derive(Debug, Clone)]
pub struct Compute {
    /// Places of requests, running and waiting.
    places: Shares,
    /// The turns of the callers.
    turns: Turns,
    /// Places that jobs from the queue may take.
    queued: Arc<Semaphore>,
    threads: ComputeThreads,
    lent: LentThreads,
    width: usize,
    /// Memory that uploaded surfaces may take together \[MiB\].
    surface_mib: Arc<Semaphore>,
    surface_bytes: u64,
    /// Processor time after which a computation is stopped.
    cpu_limit: Duration,
}

/// A computation is stopped at this multiple of the largest allowed cost, but not before a minimum time: below that
/// time, the cost is mostly that of the first pages of memory.
const BACKSTOP: f64 = 10.0;
const LEAST_BACKSTOP: Duration = Duration::from_secs(1);
const MIB: u64 = 1 << 20;

/// The threads that one computation may use: its own, and those of idle places for as long as a stretch of work in
/// parts takes.
#[derive(Debug, Clone)]
pub struct Threads {
    turns: Turns,
    who: Who,
    lent: LentThreads,
    width: usize,
    cpu_time: Arc<CpuTime>,
}

impl SideBySide for Threads {
    fn parts(&self) -> usize {
        self.width
    }

    fn run<'a>(&self, parts: Vec<Box<dyn FnOnce() + Send + 'a>>) {
        let helpers = parts.len().saturating_sub(1);
        let waiting = Mutex::new(parts.into_iter());
        let next = || waiting.lock().unwrap_or_else(PoisonError::into_inner).next();
        // Each takes the next part after it has finished one.
        let work = || {
            while let Some(part) = next() {
                part();
            }
        };
        self.lent.scope(|scope| {
            let lend = || scope.zip(self.turns.lend(&self.who));
            // A place that another computation waits for is not free.
            for (scope, place) in std::iter::from_fn(lend).take(helpers) {
                let work = &work;
                scope.spawn(move |_| {
                    let counted = self.cpu_time.enter();
                    work();
                    drop((counted, place));
                });
            }
            work();
        });
    }
}

/// How many jobs of one caller may run at the same time.
fn most_jobs_of_caller(places: usize) -> usize {
    (places - 1).max(1)
}

/// How many jobs of all callers may have begun without having ended. It is several times the number for one caller: a
/// short job of one caller begins while long jobs of others rest. The remaining computations are left to requests.
fn most_jobs_begun(places: usize) -> usize {
    Turns::most_begun(most_jobs_of_caller(places)).min(Turns::most_begun(places) - places)
}

impl Compute {
    /// A pool that runs `running` computations at the same time and lets `waiting` more wait, with this much memory
    /// for uploaded surfaces. One caller may have a share of the running and waiting ones.
    #[must_use]
    pub fn new(running: usize, waiting: usize, share: Share, surface_bytes: u64) -> Self {
        let running = running.max(1);
        let mib = usize::try_from(surface_bytes.div_ceil(MIB)).unwrap_or(usize::MAX);
        Self {
            places: Shares::new(Quota::Computations, (running + waiting) as u64, share),
            turns: Turns::new(running),
            queued: Arc::new(Semaphore::new(most_jobs_begun(running))),
            threads: ComputeThreads::new(Turns::most_begun(running)),
            // One place computes on a thread of its own.
            lent: LentThreads::new(running - 1),
            width: running,
            surface_mib: Arc::new(Semaphore::new(mib.min(Semaphore::MAX_PERMITS))),
            surface_bytes,
            cpu_limit: Duration::MAX,
        }
    }

    /// The same pool with a limit on the cost of one computation \[s of one core\]. A computation is stopped at ten
    /// times this processor time, but not before one second.
    #[must_use]
    pub fn costing_at_most(self, max_cost_s: f64) -> Self {
        let cpu_limit = Duration::try_from_secs_f64(BACKSTOP * max_cost_s).unwrap_or(Duration::MAX);
        Self { cpu_limit: cpu_limit.max(LEAST_BACKSTOP), ..self }
    }

    /// Reserves the memory for a surface with this many facets; it is released when the returned value is dropped.
    ///
    /// # Errors
    /// The surface needs more than all surfaces together may have, or more than the others leave at present.
    pub fn surface_memory(&self, facets: u64) -> Result<OwnedSemaphorePermit, PartSurfaceFault> {
        let estimated_bytes = Mesh::memory_estimate_bytes(facets);
        let limit_bytes = self.surface_bytes;
        let too_large = PartSurfaceFault::TooLarge { facets, estimated_bytes, limit_bytes };
        let mib = u32::try_from(estimated_bytes.div_ceil(MIB)).ok();
        let Some(mib) = mib.filter(|_| estimated_bytes <= limit_bytes) else { return Err(too_large) };
        Arc::clone(&self.surface_mib)
            .try_acquire_many_owned(mib)
            .map_err(|_none_free| PartSurfaceFault::NoRoom { estimated_bytes })
    }

    /// How many computations run at the same time.
    #[must_use]
    pub fn side_by_side(&self) -> usize {
        self.width
    }

    /// Runs `work` on a computing thread. `work` polls the given stop, which breaks after this future is dropped.
    ///
    /// # Errors
    /// No place is free, or `work` panicked.
    pub async fn run<T, F>(&self, work: F) -> Result<T, ComputeFault>
    where
        T: Send + 'static,
        F: FnOnce(&Stop<'_>) -> T + Send + 'static,
    {
        self.run_with(|_threads, stop| work(stop)).await
    }

    /// The same for work in parts. The parts run at the same time as long as no other computation needs the places.
    ///
    /// # Errors
    /// No place is free, or `work` panicked.
    pub async fn run_in_parts<T, F>(&self, work: F) -> Result<T, ComputeFault>
    where
        T: Send + 'static,
        F: FnOnce(&Threads, &Stop<'_>) -> T + Send + 'static,
    {
        self.run_with(work).await
    }

    /// How many jobs of one caller may have begun: one fewer than there are places, so that one place is left to
    /// requests.
    pub(super) fn most_jobs_of_caller(&self) -> usize {
        most_jobs_of_caller(self.width)
    }

    /// Waits until one more job from the queue may begin.
    pub(super) async fn queue_share(&self) -> Result<OwnedSemaphorePermit, ComputeFault> {
        Arc::clone(&self.queued).acquire_owned().await.map_err(|_closed| ComputeFault::Busy)
    }

    /// Waits for a place on behalf of this caller.
    pub(super) async fn place(&self, who: &Who) -> Result<Place, ComputeFault> {
        self.turns.take(who).await.ok_or(ComputeFault::Busy)
    }

    /// Runs `work` in a place that was waited for. Its stop breaks after `token` is cancelled or this future is
    /// dropped.
    pub(super) async fn run_at<T, F>(
        &self,
        place: Place,
        token: CancellationToken,
        work: F,
    ) -> Result<T, ComputeFault>
    where
        T: Send + 'static,
        F: FnOnce(&Threads, &Stop<'_>) -> T + Send + 'static,
    {
        let limit = self.cpu_limit;
        let cpu_time = Arc::new(CpuTime::new(limit, self.width));
        let threads = Threads {
            turns: self.turns.clone(),
            who: place.who().clone(),
            lent: self.lent.clone(),
            width: self.width,
            cpu_time: Arc::clone(&cpu_time),
        };
        let computing = meter::COMPUTING.enter();
        let stop_when_dropped = token.clone().drop_guard();
        let span = tracing::Span::current();
        let computed = self.threads.run(move || {
            // The thread holds the place, not the waiting task: a place is free only when its work has really ended.
            let (place, _computing) = (place, computing);
            let _entered = span.entered();
            let counted = threads.cpu_time.enter();
            let home = std::thread::current().id();
            let done = work(&threads, &|| {
                // Threads that were lent continue: their parts are short.
                if place.is_crowded() && !token.is_cancelled() && std::thread::current().id() == home {
                    place.give_way(|| token.is_cancelled());
                }
                if token.is_cancelled() { ControlFlow::Break(()) } else { threads.cpu_time.check() }
            });
            drop(counted);
            done
        });
        let computed = computed.await;
        stop_when_dropped.disarm();
        let done = computed.map_err(|fault| {
            tracing::error!(error = %fault, "a computation panicked");
            ComputeFault::Panicked
        })?;
        match cpu_time.over() {
            Some(spent) => Err(ComputeFault::TooCostly { spent, limit }),
            None => Ok(done),
        }
    }

    async fn run_with<T, F>(&self, work: F) -> Result<T, ComputeFault>
    where
        T: Send + 'static,
        F: FnOnce(&Threads, &Stop<'_>) -> T + Send + 'static,
    {
        let who = asker();
        let counted = self.places.take(&who, 1).map_err(|refused| match refused {
            NoShare::Full { .. } => ComputeFault::Busy,
            over @ NoShare::OverShare { .. } => ComputeFault::NoShare(over),
        })?;
        let waiting = meter::WAITING.enter();
        let place = self.place(&who).await?;
        drop(waiting);
        let account = memory::account();
        if let Some(account) = &account {
            account.begin_work()?;
        }
        let counted_work = move |threads: &Threads, stop: &Stop<'_>| {
            // The thread holds it, like its place: it continues to compute for a moment after the client has left.
            let _held = (counted, account);
            work(threads, stop)
        };
        self.run_at(place, CancellationToken::new(), counted_work).await
    }
}
