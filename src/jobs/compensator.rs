//! The seam between the service and what compensates the CC path.

use std::fmt;
use std::io::Write;

use super::CompensatorFault;
use crate::machine::Machine;
use crate::process::{self, ProgramReading, Stop};
use crate::program::{Dialect, Steps};
use crate::side_by_side::SideBySide;
use crate::wire::{CcFindings, CcParameters, CcReport};

/// The compensator of the CC path. The service has one; tests may provide another.
pub trait Compensator: Send + Sync + fmt::Debug {
    /// Reads the program of `source` as often as it needs, and writes the compensated program to `output`.
    ///
    /// # Errors
    /// The reason why there is no program; the bytes written so far are then discarded.
    #[expect(
        clippy::too_many_arguments,
        reason = "what is compensated, into what, and under which conditions"
    )]
    fn compensate(
        &self,
        machine: &Machine,
        asked: &process::CcParameters,
        singularity: &process::SingularityParameters,
        source: &dyn process::ProgramSource,
        output: &mut (dyn Write + Send),
        spool: &dyn process::StepStore,
        parts: &dyn SideBySide,
        stop: &Stop<'_>,
    ) -> Result<Compensated, CompensatorFault>;

    /// The figure of a report, as SVG text.
    fn figure(&self, parameters: &CcParameters, report: &CcReport) -> String;
}

/// The result for a program.
#[derive(Debug, Clone, PartialEq)]
pub struct Compensated {
    /// For the report.
    pub findings: CcFindings,
    /// Dialect in which it was read.
    pub dialect: Dialect,
    /// The steps that changed something.
    pub steps: Steps,
    /// How it was read.
    pub reading: ProgramReading,
}
