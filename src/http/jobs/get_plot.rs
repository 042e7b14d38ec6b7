//! Draws the plot of a job.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;

use super::find;
use crate::description::operation;
use crate::http::AppState;
use crate::http::conditional::unless_known;
use crate::http::extract::{Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::programs::answer;
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, JobNotFound, ResultNotFound, JobNotSucceeded, NotAcceptable, InvalidRequest, Busy, TooCostly);

/// Draw the plot of a job
///
/// For a compensation: the deviation along the path, the worn cutter's offset, or the sum of each motion's errors, before
/// and after. For a servo simulation: the contour error. For a verification: the residuals.
#[operation(
    get,
    path = "/v1/jobs/{id}/plot",
    tag = "jobs",
    operation_id = "get_job_plot",
    params(
        ("id" = String, Path, description = "The job", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the version that you have"),
    ),
    responses(
        (status = 200, description = "The plot", body = String, content_type = "image/svg+xml",
            headers(("ETag" = String, description = "Tag of the content"))),
        (status = 304, description = "Not changed: your version is current"),
        Refusals,
    )
)]
pub(super) async fn get_job_plot(
    State(app): State<AppState>,
    Path(id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &[answer::SVG])?;
    let job = find(&app, &id).await?;
    let plot = answer::plot(&app, &job).await?;
    unless_known(&headers, &answer::report_tag(&job, answer::SVG), || plot)
}
