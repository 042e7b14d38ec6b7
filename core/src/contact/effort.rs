//! Limits on the computation for one program, and whether its result is still wanted.

use std::ops::ControlFlow;

use crate::surface::Pace;

/// Asks whether to stop after this number of evaluations of the deviation, or other work of the same duration: a
/// few milliseconds at most.
const ASK_EVERY: u64 = 2048;

/// Why an effort is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EffortEnd {
    /// The caller no longer waits for the result.
    Unwanted,
    /// The work took more evaluations than allowed.
    Spent {
        /// Most evaluations.
        most: u64,
    },
    /// Its searches on a surface took more steps than allowed.
    Searched {
        /// Most steps.
        most: u64,
    },
}

/// Counts the work on a program, and asks at intervals whether to continue.
///
/// After its end, everything that uses it stops as soon as it can, and returns meaningless values: callers must
/// look at [`Self::end`] first.
pub struct Effort<'s> {
    evaluations: u64,
    most: u64,
    surface_steps: u64,
    most_surface_steps: u64,
    unasked: u64,
    stop: &'s (dyn Fn() -> ControlFlow<()> + Sync),
    end: Option<EffortEnd>,
}

impl<'s> Effort<'s> {
    /// An effort of at most `most` evaluations. It also ends when `stop` breaks.
    #[must_use]
    pub fn new(stop: &'s (dyn Fn() -> ControlFlow<()> + Sync), most: u64) -> Self {
        Self {
            evaluations: 0,
            most,
            surface_steps: 0,
            most_surface_steps: u64::MAX,
            unasked: 0,
            stop,
            end: None,
        }
    }

    /// The same effort, with at most `surface_steps` steps of searches on surfaces.
    #[must_use]
    pub fn searching_at_most(self, surface_steps: u64) -> Self {
        Self { most_surface_steps: surface_steps, ..self }
    }

    /// Counts evaluations of the deviation.
    #[inline]
    pub fn spend(&mut self, evaluations: u64) {
        self.evaluations += evaluations;
        if self.evaluations > self.most {
            self.end.get_or_insert(EffortEnd::Spent { most: self.most });
        }
        self.pass(evaluations);
    }

    /// Counts other work that takes as long as this number of evaluations.
    #[inline]
    pub fn pass(&mut self, evaluations: u64) {
        self.unasked += evaluations;
        if self.unasked >= ASK_EVERY {
            self.unasked = 0;
            if (self.stop)().is_break() {
                self.end.get_or_insert(EffortEnd::Unwanted);
            }
        }
    }

    /// Steps of searches on surfaces so far.
    #[must_use]
    pub const fn surface_steps(&self) -> u64 {
        self.surface_steps
    }

    /// Evaluations so far.
    #[must_use]
    pub const fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// Why the effort has ended, if it has.
    #[must_use]
    pub const fn end(&self) -> Option<EffortEnd> {
        self.end
    }

    /// Whether the effort has ended.
    #[must_use]
    pub const fn is_over(&self) -> bool {
        self.end.is_some()
    }
}

impl Pace for Effort<'_> {
    #[inline]
    fn step(&mut self, steps: u64) -> ControlFlow<()> {
        self.surface_steps = self.surface_steps.saturating_add(steps);
        if self.surface_steps > self.most_surface_steps {
            self.end.get_or_insert(EffortEnd::Searched { most: self.most_surface_steps });
        }
        // A step takes no longer than an evaluation.
        self.pass(steps);
        if self.is_over() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

impl Default for Effort<'_> {
    /// An effort without limits.
    fn default() -> Self {
        Self::new(&|| ControlFlow::Continue(()), u64::MAX)
    }
}
