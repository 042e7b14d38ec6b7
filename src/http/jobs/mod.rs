//! Jobs: waiting, running and finished computations, with reports and programs.

mod cancel_job;
mod create_job;
mod create_job_batch;
mod deliver_again;
mod get_changes;
mod get_events;
mod get_job;
mod get_path;
mod get_plot;
mod get_program;
mod get_report;
mod get_residuals;
mod list_deliveries;
mod list_jobs;
mod ordered;

use axum::response::Response;
use http::HeaderMap;

use super::AppState;
use super::conditional::unless_known;
use super::described::resource;
use super::negotiate::choose;
use super::problem::Problem;
use super::programs::answer::{self, CSV, Table};
use crate::store::JobRow;
use crate::wire::{JobDocument, JobState};

resource! {
    list_jobs::list_jobs,
    create_job::create_job,
    create_job_batch::create_job_batch,
    get_job::get_job,
    cancel_job::cancel_job,
    get_events::get_job_events,
    list_deliveries::list_job_deliveries,
    deliver_again::deliver_job_again,
    get_program::get_job_program,
    get_report::get_job_report,
    get_residuals::get_job_residuals,
    get_changes::get_job_changes,
    get_plot::get_job_plot,
    get_path::get_job_path,
}

async fn find(app: &AppState, id: &str) -> Result<JobRow, Problem> {
    let job = app.store.job(id).await?.ok_or_else(|| Problem::job_not_found(id))?;
    Ok(with_progress(app, job))
}

/// The job with its present progress, which is not stored.
fn with_progress(app: &AppState, mut job: JobRow) -> JobRow {
    if job.document.state == JobState::Running {
        job.document.progress = app.queue.progress(&job.document.id).unwrap_or(job.document.progress);
    }
    job
}

/// The tag of a job in its present state.
fn job_tag(job: &JobDocument) -> String {
    format!("{}-{}-{}-{}", job.id, job.state.as_str(), job.attempts, job.progress)
}

/// A table of a job, unless the client knows it.
async fn table(app: &AppState, id: &str, headers: &HeaderMap, table: Table) -> Result<Response, Problem> {
    choose(headers, &[CSV])?;
    let job = find(app, id).await?;
    let answer = answer::table(app, &job, table, headers).await?;
    unless_known(headers, table.sha256(&job)?, || answer)
}
