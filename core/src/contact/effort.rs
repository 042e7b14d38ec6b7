//! How much may be computed for one program, and whether it is still wanted.

use std::ops::ControlFlow;

use crate::surface::Pace;

/// Asked again after so many evaluations of the deviation, or what takes as long: a few milliseconds at most.
const ASK_EVERY: u64 = 2048;

/// Why an effort is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EffortEnd {
    /// Nobody waits for the result any more.
    Unwanted,
    /// It took more evaluations than it may.
    Spent {
        /// Most evaluations.
        most: u64,
    },
    /// Its searches on a surface took more steps than they may.
    Searched {
        /// Most steps.
        most: u64,
    },
}

/// Counts what the work on a program takes, and asks now and then whether to go on.
///
/// Once it is over, everything that works with it gives up as quickly as it can, and what it returns then means nothing:
/// callers look at [`Self::end`] before anything else.
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
    /// An effort of at most `most` evaluations. It ends as well when `stop` breaks.
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

    /// The same effort, whose searches on surfaces may take at most `surface_steps` steps.
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

    /// Other work that takes as long as so many evaluations.
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

    /// Why it is over, if it is.
    #[must_use]
    pub const fn end(&self) -> Option<EffortEnd> {
        self.end
    }

    /// Whether it is over.
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
    /// Without end.
    fn default() -> Self {
        Self::new(&|| ControlFlow::Continue(()), u64::MAX)
    }
}
