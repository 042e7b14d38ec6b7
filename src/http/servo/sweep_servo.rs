//! One path with many gains and feeds.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::HeaderMap;

use super::figures::{SVG, SweepFigureChoice, respond};
use super::{OFFERS, work};
use crate::description::operation;
use crate::http::AppState;
use crate::http::caller::Caller;
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::{SweepAnswer, SweepRequest};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest, UnreachablePose, TooCostly, Busy
);

/// Sweep gains and feeds over a path
///
/// The contour error of every combination. Rows are gains: `position_gain_scale` has a list for each axis, and the
/// lists are stepped together. Columns are feeds. With `Accept: image/svg+xml` the answer is a figure.
#[operation(
    post,
    path = "/v1/servo-sweeps",
    tag = "servo",
    operation_id = "sweep_servo",
    params(SweepFigureChoice),
    request_body(
        content((SweepRequest = "application/json", example = json!({
            "machine_id": "example-ac-table",
            "path": {"kind": "xc-circle", "radius_mm": 60.0, "center_x_mm": 100.0},
            "feed_mm_per_min": [900.0, 1200.0, 1800.0],
            "position_gain_scale": {"C": [0.8, 0.9, 1.0, 1.1, 1.2]}
        }))),
    ),
    responses(
        (status = 200, description = "Every combination", content((SweepAnswer = "application/json"), (String = "image/svg+xml"))),
        Refusals,
    )
)]
pub(super) async fn sweep_servo(
    State(app): State<AppState>,
    Query(figure): Query<SweepFigureChoice>,
    headers: HeaderMap,
    caller: Caller,
    Json(request): Json<SweepRequest>,
) -> Result<Response, Problem> {
    let kind = choose(&headers, OFFERS)?;
    let (revision, work, sets) =
        work(&app, &caller, request.options(), |task, faults| request.rows(task, faults)).await?;
    let columns = work.sweep(&app.compute, request.feed_mm_per_min.clone(), sets).await?;
    let answer = SweepAnswer::of(revision, request.labels(), &request.feed_mm_per_min, &columns);
    if kind == SVG {
        return Ok(respond(figure.draw(&request.path, &answer)));
    }
    Ok(Json(answer).into_response())
}
