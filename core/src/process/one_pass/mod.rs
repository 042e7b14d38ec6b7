//! One pass over a program for everything its parameters name: tool wear, location errors, cutter-contact path.
//!
//! First every end of a motion is moved, for the worn cutter and from the nominal machine to the calibrated one, with one
//! rounding; then the cutter-contact path of the moved program is compensated. What each step did to every block is
//! streamed to the caller, and what is left of every error is summed up.

mod changes;
mod error_budget;
mod parameters;
mod report;
mod run;
mod steps;
mod treat_and_compensate;
mod unmodelled;

pub use changes::{ChangePoint, ChangeSeries, ChangeSink, ChangeTotals};
pub use error_budget::{BlockBudget, BudgetLine, ErrorBudget, NotModelled, NotModelledKind};
pub use parameters::{CcStep, CompensationParameters, ServoStep, WearStep};
pub use report::{CompensationReport, LocationErrorReport};
pub use run::compensate_program;
pub use treat_and_compensate::treat_and_compensate;
