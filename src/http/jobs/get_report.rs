//! Reads the report of a job.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;
use serde::Serialize;
use utoipa::ToSchema;

use super::find;
use crate::http::AppState;
use crate::http::conditional::unless_known;
use crate::http::extract::{Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::programs::answer::{self, REPORT_TYPES, part_of_json};
use crate::http::refusals::refusals;
use crate::wire::{
    CcReport, CompensationReport, NoParameters, PostingReport, ServoReport, VerificationReport, WearReport,
};

refusals!(Refusals: MalformedRequest, JobNotFound, ResultNotFound, JobNotSucceeded, NotAcceptable, RangeNotSatisfiable, InvalidRequest);

/// The report of any operation.
#[derive(Debug, Serialize, ToSchema)]
#[serde(untagged)]
#[expect(dead_code, reason = "describes the answer")]
enum AnyReport {
    /// Of `cc-compensation`.
    CcCompensation(CcReport),
    /// Of `servo-simulation`.
    ServoSimulation(ServoReport),
    /// Of `wear-compensation`.
    WearCompensation(WearReport),
    /// Of `verification`.
    Verification(VerificationReport),
    /// Of `compensation`.
    Compensation(Box<CompensationReport>),
    /// Of `posting`.
    Posting(PostingReport),
}

/// Read the report of a job
///
/// JSON, or the plot with `Accept: image/svg+xml`.
#[utoipa::path(
    get,
    path = "/v1/jobs/{id}/report",
    tag = "jobs",
    operation_id = "get_job_report",
    params(
        ("id" = String, Path, description = "The job", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ("If-None-Match" = Option<String>, Header, description = "ETag that is known"),
        ("Range" = Option<String>, Header, description = "One range of bytes, such as `bytes=0-1023`"),
        ("If-Range" = Option<String>, Header, description = "ETag under which the range is meant; all of it otherwise"),
    ),
    responses(
        (status = 200, description = "The report", body = AnyReport, headers(("ETag" = String, description = "Its tag"))),
        (status = 206, description = "The bytes of the JSON text that Range asks for", body = String, content_type = "application/json",
            headers(("Content-Range" = String, description = "Which bytes of how many"))),
        (status = 304, description = "It is as you know it"),
        Refusals,
    )
)]
pub(super) async fn get_job_report(
    State(app): State<AppState>,
    Path(id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let kind = choose(&headers, REPORT_TYPES)?;
    let job = find(&app, &id).await?;
    let tag = answer::report_tag(&job, kind);
    if kind == answer::SVG {
        let plot = answer::plot(&app, &job).await?;
        return unless_known(&headers, &tag, || plot);
    }
    let report = answer::report(&app, &job)?.to_owned();
    unless_known(&headers, &tag, || part_of_json(&headers, &tag, report))
}
