//! One pass over a program for all steps its parameters name: tool wear, location errors, cutter-contact path.
//!
//! First the ends of all motions move, for the worn cutter and from the nominal to the calibrated machine, with one
//! rounding. Then the cutter-contact path of the moved program is compensated. The changes of every block are
//! streamed to the caller, and the remaining errors are summed up.

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
