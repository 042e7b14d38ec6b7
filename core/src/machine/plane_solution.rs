//! The rule by which a control chooses the rotary positions for a tilted plane.

use super::RotaryLetter;

/// Which of two rotary positions that point the tool alike the control takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaneRule {
    /// The position in which an axis is positive.
    PositiveFirst,
    /// The position in which an axis is negative.
    NegativeFirst,
    /// The position with the shorter way from the present one.
    Shortest,
}

/// The rule of one machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PlaneSolution {
    /// The rule.
    pub rule: PlaneRule,
    /// The axis that the rule looks at. Without it, the rule decides only what is the same for both axes.
    pub axis: Option<RotaryLetter>,
}
