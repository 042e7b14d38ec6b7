//! The result of moving the ends of motions, for a worn cutter and for another machine.

use super::recalibration::Recalibration;
use super::report::WearReport;

/// The result of moving the ends of a program's motions.
#[derive(Debug)]
pub(in crate::process) struct Moved {
    /// The report of the worn cutter. Without a worn cutter, its numbers are those of a cutter of nominal shape.
    pub(in crate::process) wear: WearReport,
    /// The counts of the recalibration.
    pub(in crate::process) recalibration: Recalibration,
}
