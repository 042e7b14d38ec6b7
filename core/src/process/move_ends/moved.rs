//! What moving the ends of motions comes to, for a worn cutter and for another machine.

use super::posting::Posting;
use super::report::WearReport;

/// What moving the ends of a program's motions comes to.
#[derive(Debug)]
pub(in crate::process) struct Moved {
    /// The report of the worn cutter; without one its numbers are those of a cutter of nominal shape.
    pub(in crate::process) wear: WearReport,
    /// Of posting for another machine.
    pub(in crate::process) posting: Posting,
}
