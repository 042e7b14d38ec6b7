//! Gains that reach a target.

use axum::extract::State;
use http::HeaderMap;

use super::work;
use crate::description::operation;
use crate::http::AppState;
use crate::http::caller::Caller;
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::{MatchingAnswer, MatchingRequest, NoParameters};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest, UnreachablePose, UnstableLoop, TooCostly, Busy
);

/// Match the position gains of a path
///
/// The answer has two parts. First, the smallest common Kv (speed divided by following error, 1/s) with which the
/// contour error keeps the first target at the given feed, within gain and phase margins. Second, the fastest feed of
/// the path for each target, with the present gains and with the matched gains.
#[operation(
    post,
    path = "/v1/servo-matching",
    tag = "servo",
    operation_id = "match_servo",
    request_body(
        content((MatchingRequest = "application/json", example = json!({
            "machine_id": "example-ac-table",
            "path": {"kind": "xc-circle", "radius_mm": 60.0, "center_x_mm": 100.0},
            "feed_mm_per_min": 1800.0,
            "target_um": [10.0, 25.0]
        }))),
    ),
    responses((status = 200, description = "Gains and feed limits", body = MatchingAnswer), Refusals)
)]
pub(super) async fn match_servo(
    State(app): State<AppState>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
    caller: Caller,
    Json(request): Json<MatchingRequest>,
) -> Result<Json<MatchingAnswer>, Problem> {
    choose(&headers, &["application/json"])?;
    let (revision, work, (targets_mm, options)) =
        work(&app, &caller, request.options(), |task, faults| request.apply(task, faults)).await?;
    let drives = work.task.drives;
    let matching = app.compute.run(move |stop| work.match_gains(&targets_mm, &options, stop)).await??;
    Ok(Json(MatchingAnswer::of(revision, &matching, &drives)))
}
