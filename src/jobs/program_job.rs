//! One program from upload to stored job: the work is done in the pool, its files are kept, then a row names them.
//! After any fault nothing is stored.

use std::io::BufWriter;

use thiserror::Error;

use super::part_surface::facets_of;
use super::{
    CompensatorFault, Compute, ComputeFault, InputFile, PartSurfaceFault, ProgramWork, Sources, Spool,
    Threads, TooCostly,
};
use crate::process::Stop;
use crate::program::Steps;
use crate::shares::NoShare;
use crate::store::{
    Actor, BlobFault, Blobs, Draft, JobRow, KeyUse, NewJob, Remembered, Store, StoreError, sha256_hex,
};
use crate::wire::{Fault, JobDocument, JobState, Unreadable};

/// A program to work on.
#[derive(Debug)]
pub struct ProgramJob {
    /// Slug of the machine.
    pub machine_id: String,
    /// Revision of the machine.
    pub machine_revision: i64,
    /// The operation and its parameters.
    pub work: ProgramWork,
    /// A requested step that was already applied to the program: a posted job fails with this step.
    pub repeats: Option<String>,
    /// The upload.
    pub program: Draft,
    /// The part's surface, if one was uploaded.
    pub surface: Option<Draft>,
    /// File name of the program.
    pub file_name: String,
    /// The idempotency key of the request.
    pub used: Option<KeyUse>,
    /// The author of the request.
    pub by: Actor,
}

/// The inputs and means of the work.
#[derive(Clone, Copy)]
pub struct Workplace<'a> {
    /// The program.
    pub program: &'a InputFile,
    /// The part's surface, if one was uploaded.
    pub surface: Option<&'a InputFile>,
    /// The place of the results.
    pub spool: &'a Spool,
    /// Threads for work in parts.
    pub threads: &'a Threads,
    /// Breaks when nobody needs the result any more.
    pub stop: &'a Stop<'a>,
}

impl std::fmt::Debug for Workplace<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Workplace").field("program", &self.program).finish_non_exhaustive()
    }
}

/// Bytes that are collected before a result is written.
const GATHERED: usize = 1 << 18;

impl Workplace<'_> {
    /// A new result.
    pub(super) fn output(&self) -> Result<BufWriter<Draft>, JobFault> {
        Ok(BufWriter::with_capacity(GATHERED, self.spool.result()?))
    }
}

/// A result after its last bytes.
pub(super) fn written(output: BufWriter<Draft>) -> Result<Draft, JobFault> {
    output.into_inner().map_err(|fault| CompensatorFault::Io(fault.into_error()).into())
}

/// The result of the work.
#[derive(Debug)]
pub struct Finished {
    /// The report, as JSON text.
    pub report: String,
    /// A program or a table, if the operation makes one.
    pub output: Option<Draft>,
    /// The table of changes, if the operation makes one.
    pub changes: Option<Draft>,
    /// The steps that changed the program, if the operation has steps.
    pub steps: Option<Steps>,
    /// Number of motions that were checked in a compensated program.
    pub motions_checked: Option<u64>,
}

impl Finished {
    /// A report without files.
    pub(super) fn of(report: &impl serde::Serialize) -> Result<Self, JobFault> {
        let report = serde_json::to_string(report)?;
        Ok(Self { report, output: None, changes: None, steps: None, motions_checked: None })
    }
}

/// Why there is no job.
#[derive(Debug, Error)]
pub enum JobFault {
    /// The parameters are not a document of this operation.
    #[error(transparent)]
    Unreadable(#[from] Unreadable),
    /// Parameters do not fit, each with its pointer.
    #[error("{}", .0.first().map_or("a parameter is wrong", |fault| fault.detail.as_str()))]
    Parameters(Vec<Fault>),
    /// The estimate is over the limit.
    #[error(transparent)]
    TooCostly(#[from] TooCostly),
    /// The pool has no place, or the computation panicked.
    #[error(transparent)]
    Compute(#[from] ComputeFault),
    /// The work has no result.
    #[error(transparent)]
    Compensator(#[from] CompensatorFault),
    /// The drives cannot run the program.
    #[error(transparent)]
    Servo(#[from] crate::servo::ServoFault),
    /// The part's surface is not valid, or too large.
    #[error(transparent)]
    PartSurface(#[from] PartSurfaceFault),
    /// A file could not be kept.
    #[error(transparent)]
    Blob(#[from] BlobFault),
    /// The row could not be stored.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The caller holds its full share.
    #[error(transparent)]
    NoShare(#[from] NoShare),
    /// The queue is full.
    #[error("{waiting} jobs are already waiting, which is the limit; retry later")]
    QueueFull {
        /// Number of waiting jobs.
        waiting: usize,
    },
    /// The machine's revision cannot be read: a fault of the service.
    #[error("the machine's revision cannot be used any more")]
    MachineLost,
    /// The process died while it computed this job.
    #[error(
        "the process ended unexpectedly five times while it computed only this job, after it had ended three times beside other \
         work"
    )]
    ProcessDied,
    /// The key was used for another request.
    #[error("the idempotency key was used for another request")]
    KeyReused,
    /// The report could not be printed.
    #[error("printing the report: {0}")]
    Report(#[from] serde_json::Error),
}

/// Does the work in the pool and stores the result.
///
/// # Errors
/// The reason why there is no job.
pub async fn run_program_job(
    compute: &Compute,
    store: &Store,
    spool: &Spool,
    sources: &Sources,
    job: ProgramJob,
) -> Result<JobRow, JobFault> {
    let (created_at, by) = (sources.timestamp(), job.by.clone());
    let (spool, sources, blobs) = (spool.of_asker(), sources.clone(), spool.blobs().clone());
    let memory = match &job.surface {
        Some(surface) => {
            let facets = InputFile::of(surface).and_then(|surface| facets_of(&surface));
            let facets = facets.map_err(CompensatorFault::Io)?;
            Some(compute.surface_memory(facets)?)
        }
        None => None,
    };
    let worked = move |threads: &Threads, stop: &Stop<'_>| -> Result<_, JobFault> {
        // The work holds it, not the request: it is free when nothing reads the surface any more.
        let _memory = memory;
        let started_at = sources.timestamp();
        let (operation, parameters) = (job.work.operation, job.work.parameters.clone());
        let surface = job.surface.as_ref().map(InputFile::of).transpose().map_err(CompensatorFault::Io)?;
        let program = InputFile::of(&job.program).map_err(CompensatorFault::Io)?;
        let place = Workplace { program: &program, surface: surface.as_ref(), spool: &spool, threads, stop };
        let Finished { report, output, changes, steps, motions_checked } = job.work.run(place)?;
        if stop().is_break() {
            return Err(CompensatorFault::Cancelled.into());
        }
        let document = JobDocument {
            id: sources.ids.next().to_string(),
            machine_id: job.machine_id,
            machine_revision: job.machine_revision,
            operation,
            parameters,
            state: JobState::Succeeded,
            progress: 1.0,
            input_sha256: program.sha256,
            surface_sha256: surface.map(|surface| surface.sha256),
            output_sha256: output.as_ref().map(Draft::sha256),
            changes_sha256: changes.as_ref().map(Draft::sha256),
            external_id: None,
            callback_url: None,
            attempts: 1,
            problem: None,
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            created_at,
            started_at: Some(started_at),
            finished_at: Some(sources.timestamp()),
        };
        let drafts = [Some(job.program), job.surface, output, changes];
        let report_sha256 = sha256_hex(report.as_bytes());
        let new = NewJob {
            document,
            file_name: job.file_name,
            report,
            report_sha256,
            steps: steps.map(|steps| steps.to_string()),
            motions_checked: in_rows(motions_checked),
        };
        Ok((drafts, new, job.used))
    };
    let (drafts, job, used) = compute.run_in_parts(worked).await??;
    let naming = blobs.naming().await;
    keep_all(&blobs, drafts).await?;
    let added = store.add_job(&job, used.as_ref(), &by).await?;
    drop(naming);
    if added {
        let NewJob { document, file_name, report, report_sha256, motions_checked, .. } = job;
        let (report, report_sha256) = (Some(report), Some(report_sha256));
        let (traceparent, accepted) = (None, None);
        return Ok(JobRow {
            document,
            file_name,
            report,
            report_sha256,
            traceparent,
            motions_checked,
            accepted,
        });
    }
    job_of_key(store, used.as_ref()).await
}

/// A count in the type of the database.
pub(super) fn in_rows(count: Option<u64>) -> Option<i64> {
    count.map(|count| i64::try_from(count).unwrap_or(i64::MAX))
}

/// The job of a key that arrived twice at the same time, if the other request was faster.
pub(super) async fn job_of_key(store: &Store, used: Option<&KeyUse>) -> Result<JobRow, JobFault> {
    let Some(used) = used else { return Err(JobFault::KeyReused) };
    match store.remembered(used).await? {
        Some(Remembered::Job(job)) => Ok(*job),
        Some(_) | None => Err(JobFault::KeyReused),
    }
}

/// Keeps files before anything names them.
pub(super) async fn keep_all<const N: usize>(
    blobs: &Blobs,
    drafts: [Option<Draft>; N],
) -> Result<(), JobFault> {
    let blobs = blobs.clone();
    let keep = move || drafts.into_iter().flatten().try_for_each(|draft| blobs.keep(draft).map(drop));
    let kept = tokio::task::spawn_blocking(keep).await.map_err(|_panicked| ComputeFault::Panicked)?;
    Ok(kept?)
}
