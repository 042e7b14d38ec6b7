//! The processor time that a computation really takes: the backstop if both the estimate and the counts are wrong.
//!
//! Refusals are decided by counts, which are the same on every machine. A computation that takes ten times its
//! allowed processor time is stopped as well, and that depends on the machine.

use std::cell::Cell;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

/// How often a thread checks its processor time while the limit passes.
const LOOKS: u32 = 64;

/// The processor time of one computation, on all its threads.
#[derive(Debug)]
pub(super) struct CpuTime {
    started: Instant,
    limit: Duration,
    /// No thread has to check before this time: fewer than this many threads cannot have reached the limit yet.
    first_look: Duration,
    spent_ns: AtomicU64,
}

thread_local! {
    /// The processor time of this thread that is already counted.
    static COUNTED: Cell<Duration> = const { Cell::new(Duration::ZERO) };
    /// Time of this thread's next check, since the computation started.
    static NEXT_LOOK: Cell<Duration> = const { Cell::new(Duration::ZERO) };
}

impl CpuTime {
    /// For a computation that starts now and uses at most this many threads.
    pub(super) fn new(limit: Duration, threads: usize) -> Self {
        let threads = u32::try_from(threads).unwrap_or(u32::MAX).max(1);
        Self { started: Instant::now(), limit, first_look: limit / threads, spent_ns: AtomicU64::new(0) }
    }

    /// Counts this thread from now on, until the returned value is dropped.
    pub(super) fn enter(&self) -> Counted<'_> {
        COUNTED.set(of_this_thread());
        NEXT_LOOK.set(self.first_look);
        Counted(self)
    }

    /// Whether the computation may continue.
    pub(super) fn check(&self) -> ControlFlow<()> {
        let elapsed = self.started.elapsed();
        if elapsed >= NEXT_LOOK.get() {
            NEXT_LOOK.set(elapsed.saturating_add(self.limit / LOOKS));
            self.count();
        }
        if self.over().is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// The measured time, if it is over the limit.
    pub(super) fn over(&self) -> Option<Duration> {
        let spent = Duration::from_nanos(self.spent_ns.load(Ordering::Relaxed));
        (spent > self.limit).then_some(spent)
    }

    fn count(&self) {
        let now = of_this_thread();
        let more = now.saturating_sub(COUNTED.replace(now));
        self.spent_ns.fetch_add(u64::try_from(more.as_nanos()).unwrap_or(u64::MAX), Ordering::Relaxed);
    }
}

/// A thread that works on a computation.
pub(super) struct Counted<'c>(&'c CpuTime);

impl Drop for Counted<'_> {
    fn drop(&mut self) {
        self.0.count();
    }
}

/// The processor time of the calling thread.
fn of_this_thread() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    let seconds = u64::try_from(time.tv_sec).unwrap_or(0);
    Duration::new(seconds, u32::try_from(time.tv_nsec).unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMIT: Duration = Duration::from_millis(20);

    fn work_until_told(time: &CpuTime) {
        let mut sum = 0_u64;
        while time.check().is_continue() {
            sum = std::hint::black_box(sum.wrapping_mul(31).wrapping_add(7));
        }
    }

    #[test]
    fn a_thread_that_works_too_long_is_told_and_one_that_waits_is_not() {
        let time = CpuTime::new(LIMIT, 1);
        let counted = time.enter();
        std::thread::sleep(2 * LIMIT);
        assert!(time.check().is_continue(), "{:?}", time.over());
        work_until_told(&time);
        assert!(time.over().is_some_and(|spent| spent > LIMIT));
        drop(counted);
    }

    #[test]
    fn threads_that_help_count_too() {
        let time = CpuTime::new(LIMIT, 2);
        let _counted = time.enter();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                let _counted = time.enter();
                work_until_told(&time);
            });
        });
        assert!(time.check().is_break());
    }
}
