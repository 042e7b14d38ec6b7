//! The limit of the work with one batch.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counted work between two questions: some tenths of a millisecond.
const ASK_EVERY: u64 = 4096;

/// The limit of the cutting work, and whether the caller still waits for it. The parts that cut side by side
/// share it.
pub struct CutLeave<'s> {
    left: AtomicU64,
    stop: &'s (dyn Fn() -> ControlFlow<()> + Sync),
}

impl<'s> CutLeave<'s> {
    /// A limit of `most_work` ([`CutCounts::work`](super::CutCounts::work)), until `stop` breaks.
    #[must_use]
    pub fn new(most_work: u64, stop: &'s (dyn Fn() -> ControlFlow<()> + Sync)) -> Self {
        Self { left: AtomicU64::new(most_work), stop }
    }

    /// Whether the limit is reached. After one refusal all parts are refused.
    fn is_over(&self) -> bool {
        self.left.load(Ordering::Relaxed) == 0
    }

    fn take(&self, work: u64) -> ControlFlow<()> {
        if (self.stop)().is_break() {
            self.left.store(0, Ordering::Relaxed);
        } else {
            // The limit is also over if exactly no work is left: the counts show whether the limit was
            // reached.
            let less = |left: u64| Some(left.saturating_sub(work));
            let _ = self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less);
        }
        if self.is_over() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

/// One part's share of a [`CutLeave`].
pub(super) struct Share<'a, 's> {
    leave: &'a CutLeave<'s>,
    untold: u64,
}

impl<'a, 's> Share<'a, 's> {
    pub(super) fn new(leave: &'a CutLeave<'s>) -> Self {
        Self { leave, untold: 0 }
    }

    /// Counts finished work, and decides whether to continue.
    #[inline]
    pub(super) fn after(&mut self, work: u64) -> ControlFlow<()> {
        self.untold += work;
        if self.untold < ASK_EVERY {
            return ControlFlow::Continue(());
        }
        self.leave.take(std::mem::take(&mut self.untold))
    }
}
