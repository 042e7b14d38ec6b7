//! How much may be computed for one program, and whether it is still wanted.

use std::ops::ControlFlow;

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
}

/// Counts what the work on a program takes, and asks now and then whether to go on.
///
/// Once it is over, everything that works with it gives up as quickly as it can, and what it returns then means nothing:
/// callers look at [`Self::end`] before anything else.
pub struct Effort<'s> {
    evaluations: u64,
    most: u64,
    unasked: u64,
    stop: &'s (dyn Fn() -> ControlFlow<()> + Sync),
    end: Option<EffortEnd>,
}

impl<'s> Effort<'s> {
    /// Of at most so many evaluations, until `stop` breaks.
    #[must_use]
    pub fn new(stop: &'s (dyn Fn() -> ControlFlow<()> + Sync), most: u64) -> Self {
        Self { evaluations: 0, most, unasked: 0, stop, end: None }
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

impl Default for Effort<'_> {
    /// Without end.
    fn default() -> Self {
        Self::new(&|| ControlFlow::Continue(()), u64::MAX)
    }
}
