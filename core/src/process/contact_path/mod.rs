//! The step that repairs the cutter-contact path between the ends of motions. It divides blocks over tolerance.

mod check;
mod contact_ends;
mod contact_finder;
mod division;
mod judge;
mod milestones;
mod parameters;
mod preparation;
mod repair;
mod report;
mod untouched;
mod write_division;

pub use parameters::{CcParameters, OutputForm};
pub use repair::{compensate, compensate_side_by_side};
pub use report::CcReport;

pub(in crate::process) use check::{DividedBlock, Meaning, PathCheck, same_words};
pub(in crate::process) use contact_finder::ContactFinder;
pub(in crate::process) use division::{Division, MIN_FEED, PartFeeds, is_too_fast, part_feeds, resolution};
pub(in crate::process) use judge::{Checked, may_roll_over};
pub(in crate::process) use repair::PathStep;
pub(in crate::process) use write_division::write_division;
