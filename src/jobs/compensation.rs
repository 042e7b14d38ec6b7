//! One compensation from upload to stored job: computed into a file, verified, kept, then named by a row.

use std::fmt;
use std::io::{BufWriter, Write};
use std::path::Path;
use std::sync::Arc;

use thiserror::Error;

use super::one_pass::Resting;
use super::part_surface::{cost_of_part, part_surface};
use super::program_job::{Finished, Workplace, run_program_job};
use super::{Compute, Cost, JobFault, ProgramJob, Sources, Spool};
use crate::contact::PartSurface;
use crate::machine::{Machine, Tool};
use crate::process::{self, Stop};
use crate::store::{JobRow, Store};
use crate::wear::SideBySide;
use crate::wire::{CcFindings, CcParameters, CcReport, Fault, Provenance};

/// What the compensation of the CC path is computed by. The service has one; tests may give another.
pub trait Compensator: Send + Sync + fmt::Debug {
    /// Reads the program at `source`, as often as it likes, and writes the compensated one to `output`.
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
        source: &Path,
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

/// One program to be compensated.
#[derive(Debug)]
pub struct CompensationRequest {
    /// The machine at the job's revision.
    pub machine: Machine,
    /// The parameters, checked.
    pub parameters: CcParameters,
    /// The tool, if there is one.
    pub tool: Option<Tool>,
    /// The dearest computation allowed \[s of one core\].
    pub max_cost_s: f64,
}

/// Compensates and stores; on any fault nothing is stored.
///
/// # Errors
/// Why there is no job.
pub async fn compensate(
    compute: &Compute,
    compensator: &Arc<dyn Compensator>,
    store: &Store,
    spool: &Spool,
    sources: &Sources,
    job: ProgramJob,
    request: CompensationRequest,
) -> Result<JobRow, JobFault> {
    let length = job.program.length();
    let cost = Cost::of_program(length, request.parameters.tolerance_um);
    (cost + cost_of_part(job.surface.as_ref(), length)?).within(request.max_cost_s)?;
    let compensator = Arc::clone(compensator);
    let machine_revision = job.machine_revision;
    run_program_job(
        compute,
        store,
        spool,
        sources,
        job,
        move |Workplace { program, surface, spool, threads, stop }| {
            let mut output = BufWriter::with_capacity(1 << 18, spool.blobs().draft()?);
            let CompensationRequest { machine, parameters, tool, .. } = &request;
            let part = part_surface(surface, &parameters.surface_reading(), stop)?;
            let contact = ToolAndPart { tool: *tool, part };
            let resting = Resting::new(spool.blobs().clone());
            let findings = compensator.compensate(
                machine,
                parameters,
                contact,
                program.path(),
                &mut output,
                &resting,
                threads,
                stop,
            )?;
            let output = output.into_inner().map_err(|fault| CompensatorFault::Io(fault.into_error()))?;
            let provenance = Provenance {
                machine_revision,
                software_version: env!("CARGO_PKG_VERSION").to_owned(),
                input_sha256: program.sha256(),
                output_sha256: output.sha256(),
            };
            let report = serde_json::to_string(&CcReport { provenance, findings })?;
            Ok(Finished { report, output: Some(output), changes: None })
        },
    )
    .await
}
