//! Reads the report of a job.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;
use serde::Serialize;

use super::find;
use crate::description::{ToSchema, operation};
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
    /// Report of `cc-compensation`.
    CcCompensation(CcReport),
    /// Report of `servo-simulation`.
    ServoSimulation(ServoReport),
    /// Report of `wear-compensation`.
    WearCompensation(WearReport),
    /// Report of `verification`.
    Verification(VerificationReport),
    /// Report of `compensation`.
    Compensation(Box<CompensationReport>),
    /// Report of `posting`.
    Posting(PostingReport),
}

/// Read the report of a job
///
/// JSON, or the plot with `Accept: image/svg+xml`.
#[operation(
    get,
    path = "/v1/jobs/{id}/report",
    tag = "jobs",
    operation_id = "get_job_report",
    params(
        ("id" = String, Path, description = "The job", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the version that you have"),
        ("Range" = Option<String>, Header, description = "One range of bytes, such as `bytes=0-1023`"),
        ("If-Range" = Option<String>, Header, description = "ETag of the version that the range belongs to; if it has changed, the answer is the whole content"),
    ),
    responses(
        (status = 200, description = "The report", body = AnyReport, headers(("ETag" = String, description = "Tag of the content"))),
        (status = 206, description = "The bytes of the JSON text that Range asks for", body = String, content_type = "application/json",
            headers(("Content-Range" = String, description = "Position of the bytes, and total length"))),
        (status = 304, description = "Not changed: your version is current"),
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
