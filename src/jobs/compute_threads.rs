//! The threads that compute. They are few and always the same, because the C library keeps freed memory for the thread that had it:
//! computations on whichever of the runtime's dozens of threads is free leave the memory of the largest with each of them in the end.
//! They give way to the threads that answer and store, which need a core for moments only.

use std::sync::Arc;

use tokio::runtime::{Builder, Runtime};
use tokio::task::JoinHandle;

/// By how much less the system favours a thread that computes: a third of the time of another one that wants the same core.
#[cfg(target_os = "linux")]
const NICENESS: i32 = 5;

/// Threads that a computation starts itself have its niceness.
#[cfg(target_os = "linux")]
fn give_way_to_the_others() {
    // On Linux this is the niceness of the thread. Where it cannot be set, answers take longer beside computations.
    if let Err(fault) = rustix::process::nice(NICENESS) {
        tracing::warn!(error = %fault, "a thread that computes does not give way to the others");
    }
}

/// On other systems niceness is that of the whole process.
#[cfg(not(target_os = "linux"))]
fn give_way_to_the_others() {}

/// So many threads, started when they are needed.
#[derive(Debug, Clone)]
pub(super) struct ComputeThreads(Arc<Pool>);

/// A runtime of which only the blocking threads are used; none, where none can be made.
#[derive(Debug)]
struct Pool(Option<Runtime>);

impl ComputeThreads {
    pub(super) fn new(count: usize) -> Self {
        let runtime = Builder::new_current_thread()
            .max_blocking_threads(count)
            .thread_name("compute")
            .on_thread_start(give_way_to_the_others)
            .build();
        let runtime =
            runtime.inspect_err(|fault| tracing::error!(error = %fault, "no threads to compute on"));
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
    /// What still computes is not waited for: whoever holds the last clone may be a task that must not block.
    fn drop(&mut self) {
        if let Some(runtime) = self.0.take() {
            runtime.shutdown_background();
        }
    }
}
