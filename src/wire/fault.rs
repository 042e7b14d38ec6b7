//! One bad value in a request, and its location.

use serde::Serialize;

use crate::description::ToSchema;
use crate::units::legible;

/// One bad value and its location.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct Fault {
    /// JSON pointer into the body. For a query parameter: the pointer that its dotted name represents.
    #[schema(example = "/kinematics/rotary_axes/0/direction")]
    pub pointer: String,
    /// Description of the fault.
    #[schema(example = "direction has length 0; it must be above 0.000000001")]
    pub detail: String,
}

impl Fault {
    /// A fault at `pointer`.
    pub fn new(pointer: impl Into<String>, detail: impl Into<String>) -> Self {
        Self { pointer: pointer.into(), detail: detail.into() }
    }
}

/// Collects faults; keeps the first hundred.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct FaultList {
    faults: Vec<Fault>,
}

impl FaultList {
    /// How many faults are kept: the answer to a document with a million bad numbers must not have a million
    /// lines.
    pub const KEPT: usize = 100;

    /// Adds a fault. The pointer is only built if there is room.
    pub fn push(&mut self, fault: impl FnOnce() -> Fault) {
        if self.faults.len() < Self::KEPT {
            self.faults.push(fault());
        }
    }

    /// Adds a fault if `value` is not between `min` and `max`, ends included.
    pub fn check_range(&mut self, pointer: impl FnOnce() -> String, value: f64, min: f64, max: f64) {
        // NaN is in no range.
        if !(min..=max).contains(&value) {
            let value = legible(value);
            self.push(|| Fault::new(pointer(), format!("{value} is not between {min} and {max}")));
        }
    }

    /// Whether there is no fault.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.faults.is_empty()
    }

    /// The checked value, unless `checked` or this list has faults.
    ///
    /// # Errors
    /// Both faults, those of `checked` first.
    pub fn after<T>(self, checked: Result<T, Vec<Fault>>) -> Result<T, Vec<Fault>> {
        match (checked, self.faults) {
            (Ok(value), more) if more.is_empty() => Ok(value),
            (checked, more) => {
                Err(checked.err().into_iter().flatten().chain(more).take(Self::KEPT).collect())
            }
        }
    }

    /// Ok if there is no fault; otherwise all faults that were kept.
    ///
    /// # Errors
    /// The faults kept.
    pub fn into_result(self) -> Result<(), Vec<Fault>> {
        if self.faults.is_empty() { Ok(()) } else { Err(self.faults) }
    }
}
