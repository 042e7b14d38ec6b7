//! Reads a job.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;

use super::{find, job_tag};
use crate::description::operation;
use crate::http::AppState;
use crate::http::conditional::unless_known;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, JobNotFound, NotAcceptable, InvalidRequest);

/// Read a job
///
/// The request, the machine revision, the digest of the upload, and the result.
#[operation(
    get,
    path = "/v1/jobs/{id}",
    tag = "jobs",
    operation_id = "get_job",
    params(
        ("id" = String, Path, description = "The job", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the version that you have"),
    ),
    responses(
        (status = 200, description = "The job", body = crate::wire::JobDocument, headers(("ETag" = String, description = "Tag of the content"))),
        (status = 304, description = "Not changed: your version is current"),
        Refusals,
    )
)]
pub(super) async fn get_job(
    State(app): State<AppState>,
    Path(id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &["application/json"])?;
    let job = find(&app, &id).await?.document;
    let tag = job_tag(&job);
    unless_known(&headers, &tag, || Json(job))
}
