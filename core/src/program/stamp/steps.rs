//! Steps of a compensation.

use std::fmt;

use crate::listed::listed;

listed! {
    /// A step that changes programs. Stamps name the steps in this order.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
    pub enum StepName {
        /// Moves the ends of motions for a worn cutter.
        Wear,
        /// Moves the ends of motions for the machine as it is.
        LocationErrors,
        /// Corrects the cutter-contact path between the ends.
        Cc,
        /// Treats singular regions.
        Singularity,
    }
}

impl StepName {
    /// The name in the contract.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Wear => "wear",
            Self::LocationErrors => "location_errors",
            Self::Cc => "cc",
            Self::Singularity => "singularity",
        }
    }

    /// Whether the step may be done again to a program that it has already changed. A step that moves ends would move
    /// them twice.
    #[must_use]
    pub const fn may_be_repeated(self) -> bool {
        matches!(self, Self::Cc | Self::Singularity)
    }
}

impl fmt::Display for StepName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A set of steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Steps(u8);

impl Steps {
    /// No steps.
    pub const NONE: Self = Self(0);

    /// The set of these steps.
    #[must_use]
    pub fn of(steps: &[StepName]) -> Self {
        steps.iter().fold(Self::NONE, |all, &step| all.with(step))
    }

    /// These steps and one more.
    #[must_use]
    pub const fn with(self, step: StepName) -> Self {
        Self(self.0 | (1 << step as u8))
    }

    /// The steps of both sets.
    #[must_use]
    pub const fn and(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// Whether the set has the step.
    #[must_use]
    pub const fn has(self, step: StepName) -> bool {
        self.0 & (1 << step as u8) != 0
    }

    /// Whether the set is empty.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// The steps, one after the other.
    pub fn iter(self) -> impl Iterator<Item = StepName> {
        StepName::ALL.into_iter().filter(move |step| self.has(*step))
    }

    /// Those of the steps that must not have been done to a program before. `allow_repeated` is the caller's permission
    /// to repeat the steps that [may be repeated](StepName::may_be_repeated).
    #[must_use]
    pub fn not_done_before(self, allow_repeated: bool) -> Self {
        let counts = |step: &StepName| !(allow_repeated && step.may_be_repeated());
        self.iter().filter(counts).fold(Self::NONE, Self::with)
    }

    /// The first of these steps that the other set also has.
    #[must_use]
    pub fn shared_with(self, others: Self) -> Option<StepName> {
        self.iter().find(|step| others.has(*step))
    }

    /// The steps that a text names, separated by commas with or without blanks, in upper or lower case; `None` if it
    /// names anything else.
    #[must_use]
    pub fn from_names(text: &str) -> Option<Self> {
        text.split(',').map(str::trim_ascii).try_fold(Self::NONE, |steps, name| {
            let step = StepName::ALL.into_iter().find(|step| step.name().eq_ignore_ascii_case(name))?;
            Some(steps.with(step))
        })
    }
}

impl fmt::Display for Steps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, step) in self.iter().enumerate() {
            write!(f, "{}{step}", if index > 0 { "," } else { "" })?;
        }
        Ok(())
    }
}
