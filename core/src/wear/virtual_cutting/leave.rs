//! How long one batch may be cut with.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

/// What takes time, counted, between two questions: some tenths of a millisecond.
const ASK_EVERY: u64 = 4096;

/// How much work cutting may be, and whether somebody waits for it. The parts that cut side by side share it.
pub struct CutLeave<'s> {
    left: AtomicU64,
    stop: &'s (dyn Fn() -> ControlFlow<()> + Sync),
}

impl<'s> CutLeave<'s> {
    /// For at most so much work ([`CutCounts::work`](super::CutCounts::work)), until `stop` breaks.
    #[must_use]
    pub fn new(most_work: u64, stop: &'s (dyn Fn() -> ControlFlow<()> + Sync)) -> Self {
        Self { left: AtomicU64::new(most_work), stop }
    }

    /// Whether there is work left. What is refused once is refused to all parts.
    fn is_over(&self) -> bool {
        self.left.load(Ordering::Relaxed) == 0
    }

    fn take(&self, work: u64) -> ControlFlow<()> {
        if (self.stop)().is_break() {
            self.left.store(0, Ordering::Relaxed);
        } else {
            // Exactly what is left ends it too: what comes to the limit is told apart by its counts.
            let less = |left: u64| Some(left.saturating_sub(work));
            let _ = self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less);
        }
        if self.is_over() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// The share of one part in a [`CutLeave`].
pub(super) struct Share<'a, 's> {
    leave: &'a CutLeave<'s>,
    untold: u64,
}

impl<'a, 's> Share<'a, 's> {
    pub(super) fn new(leave: &'a CutLeave<'s>) -> Self {
        Self { leave, untold: 0 }
    }

    /// Counts work that was done, and says whether to go on.
    #[inline]
    pub(super) fn after(&mut self, work: u64) -> ControlFlow<()> {
        self.untold += work;
        if self.untold < ASK_EVERY {
            return ControlFlow::Continue(());
        }
        self.leave.take(std::mem::take(&mut self.untold))
    }
}
