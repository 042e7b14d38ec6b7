//! The largest deviation so far, recorded at fixed places of the output.

/// The largest deviation left so far, recorded at every [`Milestones::BLOCKS`]th block of the output. It decides
/// which deviations are measured and which are only bounded. That choice must not depend on how far the reading has
/// got.
#[derive(Debug, Clone, Copy)]
pub(in crate::process) struct Milestones {
    next: u64,
    pub(in crate::process) largest_mm: f64,
}

impl Default for Milestones {
    fn default() -> Self {
        Self { next: Self::BLOCKS, largest_mm: 0.0 }
    }
}

impl Milestones {
    const BLOCKS: u64 = 512;

    /// Records that `blocks` blocks are read and that `largest_mm` is the largest deviation they leave \[mm\].
    pub(in crate::process) fn reach(&mut self, blocks: u64, largest_mm: f64) {
        if blocks >= self.next {
            self.next = (blocks / Self::BLOCKS + 1) * Self::BLOCKS;
            self.largest_mm = largest_mm;
        }
    }
}
