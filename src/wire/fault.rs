//! One bad value in a request, and where it stands.

use serde::Serialize;
use utoipa::ToSchema;

/// One bad value and where it stands.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct Fault {
    /// JSON pointer into the body; for a query parameter the pointer its dotted name stands for.
    #[schema(example = "/kinematics/rotary_axes/0/direction")]
    pub pointer: String,
    /// What is wrong with it.
    #[schema(example = "direction has length 0; it must be above 0.000000001")]
    pub detail: String,
}

impl Fault {
    /// A fault at `pointer`.
    pub fn new(pointer: impl Into<String>, detail: impl Into<String>) -> Self {
        Self { pointer: pointer.into(), detail: detail.into() }
    }
}

/// Faults as they are found; keeps the first hundred.
#[derive(Debug, Default)]
pub struct FaultList {
    faults: Vec<Fault>,
}

impl FaultList {
    /// How many faults are kept: a document of a million bad numbers does not get a million lines in answer.
    pub const KEPT: usize = 100;

    /// Keeps a fault. The pointer is only built when there is room.
    pub fn push(&mut self, fault: impl FnOnce() -> Fault) {
        if self.faults.len() < Self::KEPT {
            self.faults.push(fault());
        }
    }

    /// Keeps a fault when `value` is not between `min` and `max`, ends included.
    pub fn check_range(&mut self, pointer: impl FnOnce() -> String, value: f64, min: f64, max: f64) {
        // NaN is in no range.
        if !(min..=max).contains(&value) {
            let value = legible(value);
            self.push(|| Fault::new(pointer(), format!("{value} is not between {min} and {max}")));
        }
    }

    /// Whether nothing is wrong.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.faults.is_empty()
    }

    /// What was checked, unless something is wrong with it or with what is in this list.
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

    /// Nothing wrong, or everything that is.
    ///
    /// # Errors
    /// The faults kept.
    pub fn into_result(self) -> Result<(), Vec<Fault>> {
        if self.faults.is_empty() { Ok(()) } else { Err(self.faults) }
    }
}

/// A number as a person would write it: with an exponent where it has very many digits.
fn legible(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-6..1e9).contains(&size) { value.to_string() } else { format!("{value:e}") }
}
