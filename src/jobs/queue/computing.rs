//! One job from the queue: it is computed, its results are kept, and it ends under its lease or is given back.

use std::pin::pin;
use std::sync::Arc;
use std::time::Duration;

use serde_json::Value;
use tokio::sync::{OwnedRwLockReadGuard, OwnedSemaphorePermit};
use tracing::Instrument;

use super::Shared;
use super::dispatch::RETRY;
use super::running::UnderWay;
use crate::jobs::acceptance::machine_then;
use crate::jobs::compute::Threads;
use crate::jobs::program_job::{in_rows, keep_all};
use crate::jobs::turns::{Alone, Place};
use crate::jobs::{
    Accepted, CompensatorFault, ComputeFault, Finished, InputFile, JobFault, PartSurfaceFault, ProgramWork,
    Progress, Sizes, Workplace, already_done,
};
use crate::process::Stop;
use crate::shares::Who;
use crate::store::{
    BlobFault, Blobs, Claimed, DEATHS_BESIDE_OTHERS, Ending, GivenBack, StorageFault, StoreError, sha256_hex,
};
use crate::wire::JobDocument;

impl Shared {
    /// Computes a job that was taken, and settles it.
    pub(super) async fn compute_job(
        self: Arc<Self>,
        claimed: Claimed,
        job: Arc<UnderWay>,
        share: OwnedSemaphorePermit,
    ) {
        let row = &claimed.job;
        let span =
            tracing::info_span!("job", job_id = %row.document.id, traceparent = row.traceparent.as_deref());
        async move {
            let result = self.result(&claimed, &job).await;
            self.settle(&claimed, &job, result).await;
            if let Err(fault) = self.tidy(Duration::ZERO).await {
                tracing::warn!(error = %fault, "files that no job names are not removed yet");
            }
            // Held until now, so that a job that fails repeatedly does not empty the queue into waiting tasks.
            drop(share);
            self.more.notify_one();
        }
        .instrument(span)
        .await;
    }

    /// Waits for a place to compute, on behalf of the caller.
    async fn place(&self, claimed: &Claimed, job: &UnderWay) -> Result<Place, ComputeFault> {
        let who = claimed.caller.as_deref().map_or(Who::Others, Who::named);
        tokio::select! {
            biased;
            () = job.stop.cancelled() => Err(ComputeFault::Busy),
            // The job has not begun: the next process does it.
            () = self.stopping.cancelled() => {
                job.stop.cancel();
                Err(ComputeFault::Busy)
            }
            place = self.compute.place(&who) => place,
        }
    }

    /// Waits for a computation that is alone as long as `alone` lives. After a while, a long job lets the others
    /// continue beside it, and is not blamed from then on. After each further death it may be alone for twice as
    /// long, so that a job that kills late is found too.
    async fn at_most_for_a_while_alone<T>(
        &self,
        claimed: &Claimed,
        alone: Option<Alone>,
        computation: impl Future<Output = T>,
    ) -> T {
        let Some(alone) = alone else { return computation.await };
        let id = claimed.job.document.id.as_str();
        let doublings = u32::try_from(claimed.deaths - DEATHS_BESIDE_OTHERS).unwrap_or(0);
        let window = ALONE_FOR.saturating_mul(1_u32.checked_shl(doublings).unwrap_or(u32::MAX));
        tracing::warn!(deaths = claimed.deaths, window_s = window.as_secs_f64(), "a job is computed alone");
        let mut computation = pin!(computation);
        tokio::select! {
            computed = &mut computation => return computed,
            () = tokio::time::sleep(window) => {}
        }
        if let Err(fault) = self.marks.beside(id) {
            tracing::warn!(error = %fault, "the mark of a job cannot be changed");
        }
        if let Err(fault) = self.store.note_computed(id, &claimed.lease, false).await {
            tracing::warn!(error = %fault, "it cannot be noted that a job is not alone any more");
        }
        drop(alone);
        computation.await
    }

    /// The result of a job; its files are kept but not named yet.
    async fn result(
        &self,
        claimed: &Claimed,
        job: &UnderWay,
    ) -> Result<(Ending, OwnedRwLockReadGuard<()>), JobFault> {
        let row = &claimed.job;
        let document = &row.document;
        let blobs = self.spool.blobs();
        let accepted = Accepted::of(row)?;
        if let Some(step) = &accepted.repeats {
            return Err(already_done(step));
        }
        let on = machine_then(&self.store, row, &accepted.shelf).await?;
        let (program, surface) = inputs(blobs, document).await?;
        let program = program.with_steps_done(accepted.steps_done());
        let sizes = Sizes::of(&program, surface.as_ref()).map_err(CompensatorFault::Io)?;
        let parameters = document.parameters.to_string();
        let work = ProgramWork::read(document.operation, parameters.as_bytes(), on, sizes, &self.means)?;
        job.follow(Progress::of(&program, &work));
        let place = self.place(claimed, job).await?;
        let memory = sizes.surface_facets.map(|facets| self.compute.surface_memory(facets)).transpose()?;
        let alone = if claimed.is_suspect() { place.alone(ALONE_WITHIN).await } else { None };
        if !self.store.note_computed(&document.id, &claimed.lease, alone.is_some()).await? {
            // Another service has taken it up.
            job.lose();
            return Err(ComputeFault::Busy.into());
        }
        let (spool, marks, id, is_alone) =
            (self.spool.clone(), self.marks.clone(), document.id.clone(), alone.is_some());
        let worked = move |threads: &Threads, stop: &Stop<'_>| -> Result<_, JobFault> {
            let _memory = memory;
            let _mark = marks.set(&id, is_alone).map_err(CompensatorFault::Io)?;
            let place = Workplace::new(&program, surface.as_ref(), &spool, threads, stop);
            let finished = work.run(place);
            // Whatever the result: bytes that changed during the work are the reason.
            for input in [Some(&program), surface.as_ref()].into_iter().flatten() {
                input.is_unchanged().map_err(|damaged| BlobFault::from(spool.blobs().noted(damaged)))?;
            }
            finished
        };
        let computed = self.compute.run_at(place, job.stop.clone(), worked);
        let finished = self.at_most_for_a_while_alone(claimed, alone, computed).await??;
        let Finished { report, output, changes, steps, motions_checked } = finished;
        let digest = |draft: &Option<crate::store::Draft>| draft.as_ref().map(crate::store::Draft::sha256);
        let ending = Ending::Succeeded {
            report_sha256: sha256_hex(report.as_bytes()),
            output_sha256: digest(&output),
            changes_sha256: digest(&changes),
            steps: steps.map(|steps| steps.to_string()),
            motions_checked: in_rows(motions_checked),
            report,
        };
        let naming = blobs.naming().await;
        keep_all(blobs, [output, changes]).await?;
        Ok((ending, naming))
    }

    /// Stores the result of a job: its end, or its return to the queue.
    async fn settle(
        &self,
        claimed: &Claimed,
        job: &UnderWay,
        result: Result<(Ending, OwnedRwLockReadGuard<()>), JobFault>,
    ) {
        let (id, lease) = (claimed.job.document.id.as_str(), claimed.lease.as_str());
        let end = |ending: Ending| async move {
            self.persistently(|| async {
                self.store.end_job(id, lease, &ending, &self.sources.timestamp()).await
            })
            .await
        };
        let passes = match &result {
            Err(fault) if is_of_the_disk(fault) => self.disk_ails(id).await,
            Err(fault) => is_passing(fault),
            Ok(_) => false,
        };
        let ended = match result {
            Ok((ending, naming)) => {
                let ended = end(ending).await;
                drop(naming);
                ended
            }
            // Stopped by its client, or because the service stops.
            Err(_) if job.stop.is_cancelled() => Some(false),
            Err(fault) if passes => {
                tracing::warn!(error = %fault, "a job will be tried again later");
                tokio::select! {
                    () = job.stop.cancelled() => {}
                    () = self.pause() => {}
                }
                Some(false)
            }
            Err(fault) => {
                let problem = (self.describe)(fault);
                note_failure(&problem);
                end(Ending::Failed { problem }).await
            }
        };
        let given = if ended == Some(false) {
            self.persistently(|| async { self.store.give_back(id, lease, &self.sources.timestamp()).await })
                .await
        } else {
            None
        };
        self.running.end(id, lease);
        if !passes {
            self.running.forget_failures(id);
        }
        // The answer to the commit that ended it may have been lost, and then there is nothing to give back. What another
        // service has taken up, it ends.
        let is_ours = !job.is_lost();
        if ended == Some(true)
            || given == Some(GivenBack::Cancelled)
            || (given == Some(GivenBack::Nothing) && is_ours)
        {
            self.on_finished(id).await;
        } else {
            self.changed(id);
        }
    }

    /// Whether a disk that failed under this job fails for others too, or whether this job has not often failed yet.
    /// A file on one bad place of a sound disk never becomes readable, and its job would be first in the queue for
    /// ever.
    async fn disk_ails(&self, id: &str) -> bool {
        let blobs = self.spool.blobs().clone();
        let sound = tokio::task::spawn_blocking(move || blobs.check().is_ok()).await.unwrap_or(false);
        !sound || self.running.failed(id) < MAX_FAILURES
    }

    /// Repeats a request to the store until it answers; `None` after the service has stopped.
    async fn persistently<T, F>(&self, ask: impl Fn() -> F) -> Option<T>
    where
        F: Future<Output = Result<T, StoreError>>,
    {
        loop {
            match ask().await {
                Ok(answer) => return Some(answer),
                Err(fault) => tracing::error!(error = %fault, "the result of a job cannot be stored"),
            }
            tokio::select! {
                () = self.halted.cancelled() => return None,
                () = tokio::time::sleep(RETRY) => {}
            }
        }
    }
}

/// Writes the reason of a failed job to the log: the code and the details of its problem, and the line of its program.
fn note_failure(problem: &Value) {
    let detail = problem.get("detail").and_then(Value::as_str);
    let line = problem.get("line").and_then(Value::as_u64);
    tracing::warn!(problem = problem_code(problem), detail, line, "the job failed");
}

/// The code of a stored problem.
pub(super) fn problem_code(problem: &Value) -> Option<&str> {
    problem.get("type")?.as_str()?.rsplit('/').next()
}

/// The files of a job, each read to its end and verified.
async fn inputs(blobs: &Blobs, document: &JobDocument) -> Result<(InputFile, Option<InputFile>), JobFault> {
    let (blobs, program) = (blobs.clone(), document.input_sha256.clone());
    let surface = document.surface_sha256.clone();
    let read = move || -> Result<_, BlobFault> {
        let program = InputFile::kept(&blobs, &program)?;
        Ok((program, surface.map(|sha256| InputFile::kept(&blobs, &sha256)).transpose()?))
    };
    Ok(tokio::task::spawn_blocking(read).await.map_err(|_panicked| ComputeFault::Panicked)??)
}

/// How long the other computations may take to pause before a job begins that must be alone.
const ALONE_WITHIN: Duration = Duration::from_secs(2);
/// How long a job is computed alone after the largest number of deaths beside others.
const ALONE_FOR: Duration = Duration::from_secs(10);

/// Attempts for a job under which the disk fails while it accepts other files.
const MAX_FAILURES: u32 = 5;

/// Whether the disk answered with errors when the job's files were read or written.
fn is_of_the_disk(fault: &JobFault) -> bool {
    let fault = match fault {
        JobFault::Blob(fault) => fault.storage(),
        JobFault::Compensator(CompensatorFault::Io(fault)) => StorageFault::of(fault),
        _ => None,
    };
    fault == Some(StorageFault::Failing)
}

/// Whether a fault is temporary, and not a fault of the job.
fn is_passing(fault: &JobFault) -> bool {
    match fault {
        JobFault::Compute(ComputeFault::Busy)
        | JobFault::PartSurface(PartSurfaceFault::NoRoom { .. })
        | JobFault::Store(StoreError::Storage { .. } | StoreError::Busy(_))
        | JobFault::Blob(BlobFault::Rows(StoreError::Busy(_))) => true,
        JobFault::Blob(fault) => fault.storage().is_some(),
        JobFault::Compensator(CompensatorFault::Io(fault)) => StorageFault::of(fault).is_some(),
        _ => false,
    }
}
