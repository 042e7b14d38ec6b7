//! One path at one feed.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::HeaderMap;

use super::figures::{SVG, SimulationFigure, respond};
use super::{OFFERS, work};
use crate::http::AppState;
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::{SimulationAnswer, SimulationRequest};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest, UnreachablePose, UnstableLoop, TooCostly, Busy
);

/// Simulate the servo drives along a path
///
/// Following error of each axis and contour error of the tool, from the loop gains and the feed; the commanded path
/// is the reference. With `Accept: image/svg+xml` a figure.
#[utoipa::path(
    post,
    path = "/v1/servo-simulations",
    tag = "servo",
    operation_id = "simulate_servo",
    params(SimulationFigure),
    request_body(
        content((SimulationRequest = "application/json", example = json!({
            "machine_id": "example-ac-table",
            "path": {"kind": "xc-circle", "radius_mm": 60.0, "center_x_mm": 100.0},
            "feed_mm_per_min": 1800.0,
            "position_gain_scale": {"C": 0.8333}
        }))),
    ),
    responses(
        (status = 200, description = "What the path gets", content((SimulationAnswer = "application/json"), (String = "image/svg+xml"))),
        Refusals,
    )
)]
pub(super) async fn simulate_servo(
    State(app): State<AppState>,
    Query(figure): Query<SimulationFigure>,
    headers: HeaderMap,
    Json(request): Json<SimulationRequest>,
) -> Result<Response, Problem> {
    let kind = choose(&headers, OFFERS)?;
    let (revision, work, ()) =
        work(&app, request.options(), |task, faults| request.apply(task, faults)).await?;
    let drives = work.task.drives;
    let axes = work.axes();
    let simulation = app.compute.run(move |stop| work.simulate(stop)).await??;
    let answer = SimulationAnswer::of(revision, &simulation, &drives, &axes);
    if kind == SVG {
        return respond(figure.draw(&request.path, request.feed_mm_per_min, &answer));
    }
    Ok(Json(answer).into_response())
}
