//! One compensation from upload to stored job: computed into a file, verified, kept, then named by a row.

use std::fmt;
use std::io::{BufWriter, Write};
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use thiserror::Error;

use super::{Compute, ComputeFault, Cost, Sources, Spool, TooCostly};
use crate::machine::{Machine, Tool};
use crate::store::{BlobFault, Draft, KeyUse, NewJob, Remembered, Store, StoreError};
use crate::wire::{
    CcFindings, CcParameters, CcReport, Fault, JobDocument, JobOperation, JobState, Provenance,
};

/// What the compensation of the CC path is computed by. The service has one; tests may give another.
pub trait Compensator: Send + Sync + fmt::Debug {
    /// Reads the program at `source`, as often as it likes, and writes the compensated one to `output`.
    ///
    /// # Errors
    /// Why there is no program; what was written so far is then dropped.
    fn compensate(
        &self,
        machine: &Machine,
        parameters: &CcParameters,
        tool: Option<Tool>,
        source: &Path,
        output: &mut dyn Write,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<CcFindings, CompensatorFault>;

    /// The figure of a report, as SVG text.
    fn figure(&self, parameters: &CcParameters, report: &CcReport) -> String;
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
    /// Slug of the machine.
    pub machine_id: String,
    /// Revision of the machine.
    pub machine_revision: i64,
    /// The machine at that revision.
    pub machine: Machine,
    /// The parameters, checked.
    pub parameters: CcParameters,
    /// The tool, if there is one.
    pub tool: Option<Tool>,
    /// The upload.
    pub program: Draft,
    /// Its name.
    pub file_name: String,
    /// The key it was asked under.
    pub used: Option<KeyUse>,
    /// The dearest computation allowed \[s of one core\].
    pub max_cost_s: f64,
}

/// Why there is no job.
#[derive(Debug, Error)]
pub enum CompensateFault {
    /// The estimate is over the limit.
    #[error(transparent)]
    TooCostly(#[from] TooCostly),
    /// The pool has no place, or the computation panicked.
    #[error(transparent)]
    Compute(#[from] ComputeFault),
    /// The compensator gave no program.
    #[error(transparent)]
    Compensator(#[from] CompensatorFault),
    /// A file could not be kept.
    #[error(transparent)]
    Blob(#[from] BlobFault),
    /// The row could not be stored.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The key is taken by another request.
    #[error("the idempotency key was used for another request")]
    KeyReused,
    /// The report could not be printed.
    #[error("printing the report: {0}")]
    Report(#[from] serde_json::Error),
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
    request: CompensationRequest,
) -> Result<crate::store::JobRow, CompensateFault> {
    Cost::of_program(request.program.length(), request.parameters.tolerance_um).within(request.max_cost_s)?;
    let created_at = sources.timestamp();
    let (compensator, spool, sources_then) = (Arc::clone(compensator), spool.clone(), sources.clone());
    let (job, used) = compute
        .run(move |stop| -> Result<_, CompensateFault> {
            let used = request.used.clone();
            let job = run(&*compensator, &spool, &sources_then, request, created_at, stop)?;
            Ok((job, used))
        })
        .await??;
    if store.add_job(&job, used.as_ref()).await? {
        let NewJob { document, file_name, report, report_sha256 } = job;
        return Ok(crate::store::JobRow {
            document,
            file_name,
            report: Some(report),
            report_sha256: Some(report_sha256),
        });
    }
    // The same key came twice at once, and the other request was faster.
    let Some(used) = used else { return Err(CompensateFault::KeyReused) };
    match store.remembered(&used).await? {
        Some(Remembered::Same(job)) => Ok(*job),
        Some(Remembered::Other) | None => Err(CompensateFault::KeyReused),
    }
}

fn run(
    compensator: &dyn Compensator,
    spool: &Spool,
    sources: &Sources,
    request: CompensationRequest,
    created_at: String,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<NewJob, CompensateFault> {
    let started_at = sources.timestamp();
    let mut output = BufWriter::with_capacity(1 << 18, spool.blobs().draft()?);
    let CompensationRequest { machine, parameters, tool, program, .. } = &request;
    let findings = compensator.compensate(machine, parameters, *tool, program.path(), &mut output, stop)?;
    let output = output.into_inner().map_err(|fault| CompensatorFault::Io(fault.into_error()))?;
    if stop().is_break() {
        return Err(CompensatorFault::Cancelled.into());
    }
    let provenance = Provenance {
        machine_revision: request.machine_revision,
        software_version: env!("CARGO_PKG_VERSION").to_owned(),
        input_sha256: request.program.sha256(),
        output_sha256: output.sha256(),
    };
    let report = serde_json::to_string(&CcReport { provenance: provenance.clone(), findings })?;
    let report_sha256 = crate::store::sha256_hex(report.as_bytes());
    let parameters = serde_json::to_value(&request.parameters)?;
    spool.blobs().keep(request.program)?;
    spool.blobs().keep(output)?;
    let document = JobDocument {
        id: sources.ids.next().to_string(),
        machine_id: request.machine_id,
        machine_revision: request.machine_revision,
        operation: JobOperation::CcCompensation,
        parameters,
        state: JobState::Succeeded,
        progress: 1.0,
        input_sha256: provenance.input_sha256,
        output_sha256: Some(provenance.output_sha256),
        external_id: None,
        problem: None,
        software_version: provenance.software_version,
        created_at,
        started_at: Some(started_at),
        finished_at: Some(sources.timestamp()),
    };
    Ok(NewJob { document, file_name: request.file_name, report, report_sha256 })
}
