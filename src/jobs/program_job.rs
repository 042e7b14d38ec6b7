//! One program from upload to stored job: the work is done in the pool, its files are kept, then a row names them.
//! After any fault nothing is stored.

use super::part_surface::facets_of;
use super::{
    CompensatorFault, Compute, ComputeFault, Finished, InputFile, JobFault, ProgramWork, Sources, Spool,
    Threads, Workplace,
};
use crate::process::Stop;
use crate::program::Steps;
use crate::store::{Actor, Blobs, Draft, JobRow, KeyUse, NewJob, Remembered, Store, sha256_hex};
use crate::wire::{JobDocument, JobState};

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
    /// Steps of earlier jobs that wrote the program as their output.
    pub steps_done: Steps,
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
        let program =
            InputFile::of(&job.program).map_err(CompensatorFault::Io)?.with_steps_done(job.steps_done);
        let place = Workplace::new(&program, surface.as_ref(), &spool, threads, stop);
        let finished = job.work.run(place)?;
        let Finished { report, output, changes, steps, motions_checked } = finished;
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
pub(super) async fn keep_all(
    blobs: &Blobs,
    drafts: impl IntoIterator<Item = Option<Draft>>,
) -> Result<(), JobFault> {
    let blobs = blobs.clone();
    let drafts: Vec<_> = drafts.into_iter().flatten().collect();
    let keep = move || drafts.into_iter().try_for_each(|draft| blobs.keep(draft).map(drop));
    let kept = tokio::task::spawn_blocking(keep).await.map_err(|_panicked| ComputeFault::Panicked)?;
    Ok(kept?)
}
