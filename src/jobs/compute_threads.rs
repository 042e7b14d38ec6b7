//! The computing threads. They are few and always the same, because the C library keeps freed memory for the thread
//! that used it. If computations ran on any of the runtime's dozens of threads, each of them would keep the memory of
//! the largest one in the end. They have a lower priority than the threads that answer and store, which need a core
//! only for moments.

use std::sync::{Arc, OnceLock};

use rayon_core::{Scope, ThreadPool, ThreadPoolBuilder};
use tokio::runtime::{Builder, Runtime};
use tokio::task::JoinHandle;

/// Niceness of a computing thread: it gets a third of the time of another thread that wants the same core.
#[cfg(target_os = "linux")]
const NICENESS: i32 = 5;

#[cfg(target_os = "linux")]
fn give_way_to_the_others() {
    // On Linux this is the niceness of the thread. If it cannot be set, answers take longer while computations run.
    if let Err(fault) = rustix::process::nice(NICENESS) {
        tracing::warn!(error = %fault, "the niceness of a computing thread cannot be set");
    }
}

/// On other systems the niceness applies to the whole process.
#[cfg(not(target_os = "linux"))]
fn give_way_to_the_others() {}

/// The threads that are lent to computations for short parts of their work. The first computation with parts starts
/// them. They stay, because starting a thread takes as long as some of these parts.
#[derive(Debug, Clone)]
pub(super) struct LentThreads {
    count: usize,
    /// `None` if they cannot be started.
    pool: Arc<OnceLock<Option<ThreadPool>>>,
}

impl LentThreads {
    pub(super) fn new(count: usize) -> Self {
        Self { count, pool: Arc::default() }
    }

    /// Runs `work` on the calling thread. It may spawn parts on the lent threads, and returns when all have ended.
    pub(super) fn scope<'s>(&self, work: impl FnOnce(Option<&Scope<'s>>)) {
        let pool =
            if self.count == 0 { None } else { self.pool.get_or_init(|| started(self.count)).as_ref() };
        match pool {
            Some(pool) => pool.in_place_scope(|scope| work(Some(scope))),
            None => work(None),
        }
    }
}

fn started(count: usize) -> Option<ThreadPool> {
    let pool = ThreadPoolBuilder::new()
        .num_threads(count)
        .thread_name(|_| "lent".to_owned())
        .start_handler(|_| give_way_to_the_others())
        .build();
    pool.inspect_err(|fault| tracing::error!(error = %fault, "the lent threads cannot be created")).ok()
}

/// A number of threads, started when they are needed.
#[derive(Debug, Clone)]
pub(super) struct ComputeThreads(Arc<Pool>);

/// A runtime of which only the blocking threads are used; `None` if it cannot be created.
#[derive(Debug)]
struct Pool(Option<Runtime>);

impl ComputeThreads {
    pub(super) fn new(count: usize) -> Self {
        let runtime = Builder::new_current_thread()
            .max_blocking_threads(count)
            .thread_name("compute")
            .on_thread_start(give_way_to_the_others)
            .build();
        let runtime = runtime
            .inspect_err(|fault| tracing::error!(error = %fault, "the computing threads cannot be created"));
        Self(Arc::new(Pool(runtime.ok())))
    }

    /// Runs `work` on one of them.
    pub(super) fn run<T, F>(&self, work: F) -> JoinHandle<T>
    where
        T: Send + 'static,
        F: FnOnce() -> T + Send + 'static,
    {
        match &self.0.0 {
            Some(runtime) => runtime.spawn_blocking(work),
            None => tokio::task::spawn_blocking(work),
        }
    }
}

impl Drop for Pool {
    /// Does not wait for running computations: a task that must not block may hold the last clone.
    fn drop(&mut self) {
        if let Some(runtime) = self.0.take() {
            runtime.shutdown_background();
        }
    }
}
