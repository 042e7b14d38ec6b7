//! Steps of a compensation.

use std::fmt;

/// A step that changes programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum StepName {
    /// Ends of motions are moved for a worn cutter.
    Wear,
    /// They are moved for the machine as it is.
    LocationErrors,
    /// The cutter-contact path between the ends is corrected.
    Cc,
    /// Singular regions are treated.
    Singularity,
}

impl StepName {
    /// All of them, in the order in which stamps name them.
    pub const ALL: [Self; 4] = [Self::Wear, Self::LocationErrors, Self::Cc, Self::Singularity];

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

    /// Whether it may be done to a program that it was done to before: a step that moves ends would move them twice.
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

/// Some steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Steps(u8);

impl Steps {
    /// None of them.
    pub const NONE: Self = Self(0);

    /// These steps.
    #[must_use]
    pub fn of(steps: &[StepName]) -> Self {
        steps.iter().fold(Self::NONE, |all, &step| all.with(step))
    }

    /// These and one more.
    #[must_use]
    pub const fn with(self, step: StepName) -> Self {
        Self(self.0 | (1 << step as u8))
    }

    /// These and those.
    #[must_use]
    pub const fn and(self, others: Self) -> Self {
        Self(self.0 | others.0)
    }

    /// Whether the step is one of them.
    #[must_use]
    pub const fn has(self, step: StepName) -> bool {
        self.0 & (1 << step as u8) != 0
    }

    /// Whether there is none.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// One after the other.
    pub fn iter(self) -> impl Iterator<Item = StepName> {
        StepName::ALL.into_iter().filter(move |step| self.has(*step))
    }

    /// The first of these that is one of those too.
    #[must_use]
    pub fn shared_with(self, others: Self) -> Option<StepName> {
        self.iter().find(|step| others.has(*step))
    }

    /// The steps that a text names, separated by commas and blanks beside them, in letters of any size; `None` where it names anything else.
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
