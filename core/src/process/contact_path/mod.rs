//! The step that repairs the cutter-contact path between the ends of motions. It divides blocks over tolerance.

mod check;
mod contact_finder;
mod judge;
mod milestones;
mod parameters;
mod plan;
mod preparation;
mod report;
mod step;
mod untouched;
mod work;

pub use parameters::{CcParameters, OutputForm};
pub use report::CcReport;
pub use step::{compensate, compensate_side_by_side};

pub(in crate::process) use contact_finder::ContactFinder;
pub(in crate::process) use step::PathStep;
