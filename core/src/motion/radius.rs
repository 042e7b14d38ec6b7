//! What is known of the compensation of the cutter's radius.

/// How a control leads the tool into a compensated path, around its corners and out of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RadiusRule {
    /// As `LinuxCNC` does.
    Rs274,
    /// It is not known which control runs the program. Only what controls do alike is certain.
    Common,
}

/// What is known of the compensation besides its state, and of arcs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Radius {
    /// How often it was switched on so far.
    pub(super) number: u32,
    /// How far left of the path the tool runs \[mm\], if the program is followed as it runs and it is stated.
    pub(super) beside_mm: Option<f64>,
    pub(super) rule: RadiusRule,
    pub(super) is_clockwise: Option<bool>,
    pub(super) absolute_centres: Option<bool>,
}

impl Radius {
    pub(super) const START: Self = Self {
        number: 0,
        beside_mm: None,
        rule: RadiusRule::Common,
        is_clockwise: None,
        absolute_centres: Some(false),
    };

    /// After a call nothing is known but the number.
    pub(super) fn forget(&mut self) {
        *self = Self { number: self.number, absolute_centres: None, ..Self::START };
    }

    /// What is the same whether a block was executed or skipped.
    pub(super) fn common(self, skipped: Self) -> Self {
        if self == skipped {
            return self;
        }
        Self { number: self.number.max(skipped.number), absolute_centres: None, ..Self::START }
    }
}
