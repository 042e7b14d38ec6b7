//! Reads a run: its document, its figures, its report page.

use axum::extract::State;
use axum::response::{Html, IntoResponse, Response};
use http::HeaderMap;

use super::figures::{CalibrationFigure, SVG};
use super::{document, find, report_page};
use crate::description::operation;
use crate::http::AppState;
use crate::http::extract::{Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;

refusals!(
    Refusals: MalformedRequest, MachineNotFound, CalibrationNotFound, NotAcceptable, InvalidRequest, Busy, TooCostly
);

/// Read a calibration run
///
/// JSON as first answered. With `Accept: image/svg+xml`: a figure (`plot`). With `Accept: text/html`: a report to print,
/// sign and file, with expanded uncertainties, their budget, limits and verdicts, and all figures.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/calibrations/{id}",
    tag = "calibrations",
    operation_id = "get_calibration",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("id" = String, Path, description = "The run", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        CalibrationFigure,
        ("If-None-Match" = Option<String>, Header, description = "ETag of the version that you have"),
    ),
    responses(
        (status = 200, description = "The run", content(
            (crate::wire::CalibrationDocument = "application/json"), (String = "image/svg+xml"), (String = "text/html")),
            headers(("ETag" = String, description = "Tag of the content"))),
        (status = 304, description = "Not changed: your version is current"),
        Refusals,
    )
)]
pub(super) async fn get_calibration(
    State(app): State<AppState>,
    Path((machine_id, id)): Path<(String, String)>,
    Query(figure): Query<CalibrationFigure>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let kind = choose(&headers, &["application/json", SVG, "text/html"])?;
    let run = find(&app, &machine_id, &id).await?;
    match kind {
        SVG => figure.respond(&app, run).await,
        "text/html" => Ok(Html(Box::pin(report_page::page(&app, run)).await?).into_response()),
        _ => document(&headers, &run),
    }
}
