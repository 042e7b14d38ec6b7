//! The compensation of the CC path, as work on a program.

use std::fmt;
use std::io::Write;
use std::sync::Arc;

use thiserror::Error;

use super::cutter_contact::core_parameters;
use super::one_pass::Resting;
use super::part_surface::part_surface;
use super::program_job::{Finished, Workplace, written};
use super::stamping::Leaving;
use super::{Cost, MachineUsed, Means, Prepared, ProgramParameters, Sizes};
use crate::machine::Machine;
use crate::meter;
use crate::process::{self, ProgramReading, ProgramSetup, Stop};
use crate::program::{Dialect, Step, Steps};
use crate::wear::SideBySide;
use crate::wire::{
    CcFindings, CcParameters, CcReport, Contact, Fault, FaultList, JobOperation, SingularityAction,
};

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
        output: &mut dyn Write,
        spool: &dyn process::Spool,
        parts: &dyn SideBySide,
        stop: &Stop<'_>,
    ) -> Result<Compensated, CompensatorFault>;

    /// The figure of a report, as SVG text.
    fn figure(&self, parameters: &CcParameters, report: &CcReport) -> String;
}

/// The result for a program.
#[derive(Debug, Clone, PartialEq)]
pub struct Compensated {
    /// Findings for the report.
    pub findings: CcFindings,
    /// Dialect in which it was read.
    pub dialect: Dialect,
    /// The steps that changed something.
    pub steps: Steps,
    /// The reading of the program.
    pub reading: ProgramReading,
}

/// Class of a refusal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RefusalClass {
    /// Lines that cannot be read, followed or compensated.
    Program,
    /// The tolerance cannot be met with the program's decimals.
    ToleranceOutOfReach,
    /// An axis is commanded outside its travel.
    OutOfTravel,
    /// A parameter does not fit this program.
    Parameter,
    /// More work than one request may cause.
    TooCostly,
    /// The unit of the program is not known.
    UnitUnknown,
    /// A step that was already applied to the program.
    AlreadyCompensated,
}

/// Why a program is refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// The class.
    pub class: RefusalClass,
    /// The reason in a sentence.
    pub detail: String,
    /// First line of the upload that it concerns, 1-based.
    pub line: Option<u64>,
    /// Text of that line.
    pub block: Option<String>,
    /// Every fault kept.
    pub errors: Vec<Fault>,
}

/// Why a compensator returns no program.
#[derive(Debug, Error)]
pub enum CompensatorFault {
    /// The program or its parameters are at fault.
    #[error("{}", .0.detail)]
    Refused(Box<Refusal>),
    /// The caller does not need the answer any more.
    #[error("cancelled")]
    Cancelled,
    /// A file could not be read or written.
    #[error("program text: {0}")]
    Io(#[from] std::io::Error),
    /// The written program is not the intended one: a fault of the service.
    #[error("verification failed at line {line}: {what}")]
    VerificationFailed {
        /// Line of the upload.
        line: u64,
        /// The difference.
        what: &'static str,
    },
}

impl ProgramParameters for CcParameters {
    const OPERATION: JobOperation = JobOperation::CcCompensation;
    const LOOKS_AT_PART: bool = true;

    fn steps(&self) -> Steps {
        let steps = treats(self.singularity).with(Step::Cc);
        if self.allow_repeated { Steps::NONE } else { steps }
    }

    fn prepare(self, on: MachineUsed, sizes: Sizes, means: &Means) -> Result<Prepared, Vec<Fault>> {
        let mut missing = FaultList::default();
        missing_tool(&self, "", &on, &mut missing);
        let tool = missing.after(self.check(sizes.has_part()))?;
        let parameters = serde_json::to_value(&self).unwrap_or_default();
        let program =
            ProgramSetup { allow_repeated: self.allow_repeated, ..on.program(&self.statements(), true)? };
        let mut asked = core_parameters(&self, tool, program);
        asked.max_feed = on.statements.max_feed(self.max_feed_mm_per_min);
        asked.block_time_s = on.statements.block_time_s();
        let singularity = self.singular_regions.to_core(self.singularity);
        let cost = Cost::of_program(sizes.program_length, self.tolerance_um) + sizes.cost_of_part();
        let compensator = Arc::clone(&means.compensator);
        Ok(Prepared::new(cost, move |place| {
            let Workplace { program, surface, spool, threads, stop } = place;
            let mut output = place.output()?;
            asked.part = part_surface(surface, &self.surface_reading(), stop)?;
            let resting = Resting::new(spool.blobs().clone());
            let Compensated { findings, dialect, steps, reading } = compensator.compensate(
                &on.machine,
                &asked,
                &singularity,
                program,
                &mut output,
                &resting,
                threads,
                stop,
            )?;
            meter::PROGRAM_BLOCKS.add(findings.blocks_in);
            let resolved = on
                .resolved(&self.statements(), &reading)?
                .with_max_feed(self.max_feed_mm_per_min, &on.statements);
            let leaving = Leaving {
                on: &on,
                operation: Self::OPERATION,
                parameters: &parameters,
                resolved: &resolved,
                form: self.stamp,
                dialect,
                steps,
            };
            let (output, provenance) = leaving.stamped(program, written(output)?, &place)?;
            let motions_checked = findings.motions_checked;
            let report = CcReport { provenance, resolved: Some(resolved), findings };
            Ok(Finished {
                output: Some(output),
                steps: Some(steps),
                motions_checked: Some(motions_checked),
                ..Finished::of(&report)?
            })
        }))
    }
}

/// The cutter is not stated, so the machine's tool table must give it. A corner radius alone was reported as a fault
/// before.
pub(super) fn missing_tool(
    parameters: &CcParameters,
    pointer: &str,
    on: &MachineUsed,
    faults: &mut FaultList,
) {
    let is_stated = parameters.tool_radius_mm.is_some() || parameters.corner_radius_mm.is_some();
    if !is_stated && parameters.contact != Contact::Tip && on.shelf.is_empty() {
        let detail = "missing: only contact=tip works without a tool, and the machine's tool table is empty; give the tool radius";
        faults.push(|| Fault::new(format!("{pointer}/tool_radius_mm"), detail));
    }
}

/// The step that treats singular regions, if they are not only reported.
pub(super) fn treats(action: SingularityAction) -> Steps {
    if action == SingularityAction::Report { Steps::NONE } else { Steps::of(&[Step::Singularity]) }
}
