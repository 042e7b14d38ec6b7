//! The compensation of the CC path, as work on a program.

use std::fmt;
use std::io::Write;
use std::sync::Arc;

use thiserror::Error;

use super::one_pass::Resting;
use super::part_surface::part_surface;
use super::program_job::{Finished, Workplace, written};
use super::{Cost, MachineUsed, Means, Prepared, ProgramParameters, Sizes};
use crate::contact::PartSurface;
use crate::machine::{Machine, Tool};
use crate::meter;
use crate::process::{self, Stop};
use crate::wear::SideBySide;
use crate::wire::{CcFindings, CcParameters, CcReport, Fault, JobOperation};

/// What the compensation of the CC path is computed by. The service has one; tests may give another.
pub trait Compensator: Send + Sync + fmt::Debug {
    /// Reads the program of `source`, as often as it likes, and writes the compensated one to `output`.
    ///
    /// # Errors
    /// Why there is no program; what was written so far is then dropped.
    #[expect(
        clippy::too_many_arguments,
        reason = "what is compensated, into what, and under which conditions"
    )]
    fn compensate(
        &self,
        machine: &Machine,
        parameters: &CcParameters,
        contact: ToolAndPart,
        source: &dyn process::ProgramSource,
        output: &mut dyn Write,
        spool: &dyn process::Spool,
        parts: &dyn SideBySide,
        stop: &Stop<'_>,
    ) -> Result<CcFindings, CompensatorFault>;

    /// The figure of a report, as SVG text.
    fn figure(&self, parameters: &CcParameters, report: &CcReport) -> String;
}

/// What touches what.
#[derive(Debug, Clone, PartialEq)]
pub struct ToolAndPart {
    /// The tool, if there is one.
    pub tool: Option<Tool>,
    /// The part, if its surface came with the program.
    pub part: Option<PartSurface>,
}

/// What a program is refused for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RefusalClass {
    /// Lines that cannot be read, followed or compensated.
    Program,
    /// The tolerance cannot be met with the program's decimals.
    ToleranceOutOfReach,
    /// An axis is commanded outside its travel.
    OutOfTravel,
    /// A parameter that does not fit this program.
    Parameter,
    /// More work than one request may cause.
    TooCostly,
}

/// Why a program is refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// What for.
    pub class: RefusalClass,
    /// In a sentence.
    pub detail: String,
    /// First line of the upload concerned, 1-based.
    pub line: Option<u64>,
    /// Text of that line.
    pub block: Option<String>,
    /// Every fault kept.
    pub errors: Vec<Fault>,
}

/// Why a compensator gives no program.
#[derive(Debug, Error)]
pub enum CompensatorFault {
    /// The program or its parameters are at fault.
    #[error("{}", .0.detail)]
    Refused(Box<Refusal>),
    /// The caller no longer wants the answer.
    #[error("cancelled")]
    Cancelled,
    /// A file could not be read or written.
    #[error("program text: {0}")]
    Io(#[from] std::io::Error),
    /// The written program is not what was meant: a fault of ours.
    #[error("verification failed at line {line}: {what}")]
    VerificationFailed {
        /// Line of the upload.
        line: u64,
        /// What differs.
        what: &'static str,
    },
}

impl ProgramParameters for CcParameters {
    const OPERATION: JobOperation = JobOperation::CcCompensation;
    const LOOKS_AT_PART: bool = true;

    fn prepare(self, on: MachineUsed, sizes: Sizes, means: &Means) -> Result<Prepared, Vec<Fault>> {
        let tool = self.check(sizes.has_part())?;
        let cost = Cost::of_program(sizes.program_length, self.tolerance_um) + sizes.cost_of_part();
        let compensator = Arc::clone(&means.compensator);
        Ok(Prepared::new(cost, move |place| {
            let Workplace { program, surface, spool, threads, stop } = place;
            let mut output = place.output()?;
            let part = part_surface(surface, &self.surface_reading(), stop)?;
            let contact = ToolAndPart { tool, part };
            let resting = Resting::new(spool.blobs().clone());
            let findings = compensator.compensate(
                &on.machine,
                &self,
                contact,
                program,
                &mut output,
                &resting,
                threads,
                stop,
            )?;
            meter::PROGRAM_BLOCKS.add(findings.blocks_in);
            let output = written(output)?;
            let provenance = on.provenance(program, &output);
            let report = serde_json::to_string(&CcReport { provenance, findings })?;
            Ok(Finished { report, output: Some(output), changes: None })
        }))
    }
}
