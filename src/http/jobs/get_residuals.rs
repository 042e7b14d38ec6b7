//! Reads the residuals of a verification.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;

use super::table;
use crate::description::operation;
use crate::http::AppState;
use crate::http::extract::{Path, Query};
use crate::http::problem::Problem;
use crate::http::programs::answer::Table;
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, JobNotFound, ResultNotFound, JobNotSucceeded, NotAcceptable, RangeNotSatisfiable, InvalidRequest);

/// Read the residuals of a verification
///
/// One row for every sample of the surface: place, normal, residual above the surface (negative below it), and the
/// line of the program that left it. Residual and line are empty if no tool came there.
#[operation(
    get,
    path = "/v1/jobs/{id}/residuals",
    tag = "jobs",
    operation_id = "get_job_residuals",
    params(
        ("id" = String, Path, description = "The job", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the version that you have"),
        ("Range" = Option<String>, Header, description = "One range of bytes, such as `bytes=0-1023`"),
        ("If-Range" = Option<String>, Header, description = "ETag of the version that the range belongs to; if it has changed, the answer is the whole content"),
    ),
    responses(
        (status = 200, description = "The table", body = String, content_type = "text/csv",
            headers(("ETag" = String, description = "Tag of the content"), ("Content-Disposition" = String, description = "File name"))),
        (status = 206, description = "The bytes that Range asks for", body = String, content_type = "text/csv",
            headers(("Content-Range" = String, description = "Position of the bytes, and total length"))),
        (status = 304, description = "Not changed: your version is current"),
        Refusals,
    )
)]
pub(super) async fn get_job_residuals(
    State(app): State<AppState>,
    Path(id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    table(&app, &id, &headers, Table::Residuals).await
}
