//! Limits on the cost of one program.

use std::ops::ControlFlow;

use crate::contact::Effort;
use crate::process::fault::Fault;

/// Called at intervals to ask whether the work is still wanted.
pub type Stop<'a> = dyn Fn() -> ControlFlow<()> + Sync + 'a;

/// Limits on the cost of one program, checked while it runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// Most evaluations of the deviation.
    pub max_evaluations: u64,
    /// Most blocks written.
    pub max_blocks_out: u64,
    /// Most steps of searches on the part's surface.
    pub max_surface_steps: u64,
}

impl Default for Budget {
    fn default() -> Self {
        Self { max_evaluations: 1_000_000_000, max_blocks_out: 20_000_000, max_surface_steps: 2_000_000_000 }
    }
}

impl Budget {
    /// An effort with the same limits.
    pub(in crate::process) fn effort<'s>(&self, stop: &'s Stop<'s>) -> Effort<'s> {
        Effort::new(stop, self.max_evaluations).searching_at_most(self.max_surface_steps)
    }

    /// Refuses a program that costs more than this.
    ///
    /// # Errors
    /// The limit that it passes.
    pub(in crate::process) fn check(&self, evaluations: u64, blocks_out: u64) -> Result<(), Fault> {
        if evaluations > self.max_evaluations {
            let what = "evaluations of the deviation";
            return Err(Fault::TooCostly { what, limit: self.max_evaluations });
        }
        if blocks_out > self.max_blocks_out {
            return Err(Fault::TooCostly { what: "blocks written", limit: self.max_blocks_out });
        }
        Ok(())
    }
}
