//! Reads the program that a job made.

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
use crate::http::programs::answer::{self, PROGRAM_TYPES};
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, JobNotFound, ResultNotFound, JobNotSucceeded, NotAcceptable, RangeNotSatisfiable, InvalidRequest);

/// Read the program of a job
///
/// The same bytes as in the first answer.
#[operation(
    get,
    path = "/v1/jobs/{id}/program",
    tag = "jobs",
    operation_id = "get_job_program",
    params(
        ("id" = String, Path, description = "The job", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the version that you have"),
        ("Range" = Option<String>, Header, description = "One range of bytes, such as `bytes=0-1023`"),
        ("If-Range" = Option<String>, Header, description = "ETag of the version that the range belongs to; if it has changed, the answer is the whole content"),
    ),
    responses(
        (status = 200, description = "The program", body = String, content_type = "text/plain",
            headers(
                ("ETag" = String, description = "Tag of the content"),
                ("Content-Disposition" = String, description = "File name"),
                ("Trunnion-Motions-Checked" = i64, description = "Number of motions that were checked, moved or computed again: the largest count of one step. 0 means none"),
            )),
        (status = 206, description = "The bytes that Range asks for", body = String, content_type = "text/plain",
            headers(("Content-Range" = String, description = "Position of the bytes, and total length"))),
        (status = 304, description = "Not changed: your version is current"),
        Refusals,
    )
)]
pub(super) async fn get_job_program(
    State(app): State<AppState>,
    Path(id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let kind = choose(&headers, PROGRAM_TYPES)?;
    let job = find(&app, &id).await?;
    let program = answer::program(&app, &job, kind, &headers).await?;
    let tag = answer::program_tag(&job);
    unless_known(&headers, &tag, || program)
}
