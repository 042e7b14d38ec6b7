//! The step that repairs the cutter-contact path between the ends of motions. It divides blocks over tolerance.

mod check;
mod contact_ends;
mod contact_finder;
mod divided_block;
mod division;
mod judge;
mod milestones;
mod parameters;
mod preparation;
mod report;
mod step;
mod untouched;
mod work;
mod write_division;

pub use parameters::{CcParameters, OutputForm};
pub use report::CcReport;
pub use step::{compensate, compensate_side_by_side};

pub(in crate::process) use contact_finder::ContactFinder;
pub(in crate::process) use divided_block::{DividedBlock, LAST_BIT};
pub(in crate::process) use division::{Division, PartFeeds, is_too_fast, part_feeds, resolution};
pub(in crate::process) use judge::Checked;
pub(in crate::process) use step::PathStep;
pub(in crate::process) use write_division::write_division;
