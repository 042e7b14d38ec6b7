//! Reads the readings of a run.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;

use super::find;
use crate::description::operation;
use crate::http::AppState;
use crate::http::conditional::unless_known;
use crate::http::extract::{Path, Query, json_response};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, MachineNotFound, CalibrationNotFound, NotAcceptable, InvalidRequest);

/// Read the readings of a run
///
/// The run as posted, with defaults left out. Its SHA-256 is `run_sha256` of the run, and also its `ETag`.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/calibrations/{id}/run",
    tag = "calibrations",
    operation_id = "get_calibration_run",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("id" = String, Path, description = "The run", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the version that you have"),
    ),
    responses(
        (status = 200, description = "The readings", body = crate::wire::CalibrationRequest, headers(("ETag" = String, description = "SHA-256 of the readings"))),
        (status = 304, description = "Not changed: your version is current"),
        Refusals,
    )
)]
pub(super) async fn get_calibration_run(
    State(app): State<AppState>,
    Path((machine_id, id)): Path<(String, String)>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &["application/json"])?;
    let run = find(&app, &machine_id, &id).await?;
    unless_known(&headers, &run.document.run_sha256, || json_response(run.run.clone()))
}
