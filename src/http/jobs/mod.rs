//! Jobs: everything that was computed, with its report and its program.

mod get_changes;
mod get_job;
mod get_plot;
mod get_program;
mod get_report;
mod get_residuals;
mod list_jobs;

use axum::response::Response;
use http::HeaderMap;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::AppState;
use super::conditional::unless_known;
use super::negotiate::choose;
use super::problem::{Problem, ProblemType};
use super::programs::answer::{self, CSV, Table};
use crate::store::JobRow;

/// The routes of this resource.
pub(super) fn router() -> OpenApiRouter<AppState> {
    OpenApiRouter::new()
        .routes(routes!(list_jobs::list_jobs))
        .routes(routes!(get_job::get_job))
        .routes(routes!(get_program::get_job_program))
        .routes(routes!(get_report::get_job_report))
        .routes(routes!(get_residuals::get_job_residuals))
        .routes(routes!(get_changes::get_job_changes))
        .routes(routes!(get_plot::get_job_plot))
}

async fn find(app: &AppState, id: &str) -> Result<JobRow, Problem> {
    app.store.job(id).await?.ok_or_else(|| Problem::job_not_found(id))
}

/// A table of a job, unless the client knows it.
async fn table(app: &AppState, id: &str, headers: &HeaderMap, table: Table) -> Result<Response, Problem> {
    choose(headers, &[CSV])?;
    let job = find(app, id).await?;
    let answer = answer::table(app, &job, table).await?;
    unless_known(headers, table.sha256(&job)?, || answer)
}

fn no_result(job: &JobRow) -> Problem {
    let detail = format!("the job is {}", job.document.state.as_str());
    Problem::new(ProblemType::ResultNotFound, detail)
}
