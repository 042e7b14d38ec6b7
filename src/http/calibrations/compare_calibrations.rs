//! Compares two runs.

use axum::extract::State;
use http::HeaderMap;
use serde::Deserialize;

use super::find;
use crate::description::{IntoParams, operation};
use crate::http::AppState;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::CalibrationDifference;

refusals!(Refusals: MalformedRequest, MachineNotFound, CalibrationNotFound, NotAcceptable, InvalidRequest);

/// The run to subtract.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(super) struct ComparedWith {
    /// Id of the run to subtract.
    #[param(example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")]
    from: String,
}

/// Compare two calibration runs
///
/// Each error of this run minus the same error of another run of the machine. The answer has the standard uncertainty
/// of each difference, and says whether the difference is significant (more than twice its uncertainty).
#[operation(
    get,
    path = "/v1/machines/{machine_id}/calibrations/{id}/difference",
    tag = "calibrations",
    operation_id = "compare_calibrations",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("id" = String, Path, description = "The run", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ComparedWith,
    ),
    responses((status = 200, description = "The difference", body = CalibrationDifference), Refusals)
)]
pub(super) async fn compare_calibrations(
    State(app): State<AppState>,
    Path((machine_id, id)): Path<(String, String)>,
    Query(with): Query<ComparedWith>,
    headers: HeaderMap,
) -> Result<Json<CalibrationDifference>, Problem> {
    choose(&headers, &["application/json"])?;
    let here = find(&app, &machine_id, &id).await?;
    let there = find(&app, &machine_id, &with.from).await?;
    Ok(Json(CalibrationDifference::of(&here.document, &there.document)))
}
