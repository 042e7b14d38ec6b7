//! Reads the report of a job.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;
use serde::Serialize;
use utoipa::ToSchema;

use super::{find, no_result};
use crate::http::AppState;
use crate::http::conditional::unless_known;
use crate::http::extract::{Path, Query, json_response};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::programs::answer::{self, REPORT_TYPES};
use crate::http::refusals::refusals;
use crate::wire::{
    CcReport, CompensationReport, NoParameters, PostingReport, ServoReport, VerificationReport, WearReport,
};

refusals!(Refusals: MalformedRequest, JobNotFound, ResultNotFound, NotAcceptable, InvalidRequest);

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
    ),
    responses(
        (status = 200, description = "The report", body = AnyReport, headers(("ETag" = String, description = "Its tag"))),
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
    let report = job.report.clone().ok_or_else(|| no_result(&job))?;
    unless_known(&headers, &tag, || json_response(report))
}
