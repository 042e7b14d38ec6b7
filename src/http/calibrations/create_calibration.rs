//! Stores a run with its results.

use axum::extract::{FromRequest, Request, State};
use axum::response::{IntoResponse, Response};
use http::StatusCode;
use http::header::LOCATION;

use super::tag;
use crate::description::operation;
use crate::http::AppState;
use crate::http::author::actor;
use crate::http::conditional::tagged;
use crate::http::current_machine::current_machine;
use crate::http::extract::{Json, Path, Query, json_response};
use crate::http::idempotency::{answered, key, key_reused, unless_keyed, used};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::jobs::{evaluate, measured_at};
use crate::store::{CalibrationRow, NewCalibration, Remembered, sha256_hex};
use crate::wire::{CalibrationHead, CalibrationRequest, NoParameters};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, KeyReused,
    BodyTooLarge, UnsupportedMediaType, InvalidRequest, Busy, TooCostly
);

/// Store a calibration run
///
/// Post the readings as taken with nominal kinematics in the control. The service keeps them for ever together with
/// their results: the location errors of both rotary axes with uncertainties, and the errors that the run cannot
/// separate. The machine does not change until the run is applied.
#[operation(
    post,
    path = "/v1/machines/{machine_id}/calibrations",
    tag = "calibrations",
    operation_id = "create_calibration",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key with the same request returns the same answer"),
    ),
    request_body(content = CalibrationRequest, description = "The run", example = json!({
        "kind": "rtcp-ballbar", "measured_at": "2025-03-14T09:26:53Z", "temperature_c": 20.1, "note": "after the crash",
        "instrument": "ball bar", "instrument_serial_number": "BB-4711", "bar_length_mm": 100, "setup_error_um": {"e_xs": 1.2, "e_ys": -0.4},
        "tests": [
            {"rotary_axis": "C", "bar_direction": "radial", "ball_mm": [150, 0, 60], "eccentricity_um": [6.7, 16.4]},
            {"rotary_axis": "C", "bar_direction": "axial", "ball_mm": [150, 0, 60], "eccentricity_um": [-2.0, 2.6]},
            {"rotary_axis": "A", "bar_direction": "radial", "ball_mm": [30, 0, 160], "eccentricity_um": [9.9, -69.1]},
            {"rotary_axis": "A", "bar_direction": "axial", "ball_mm": [30, 0, 160], "readings": [
                {"angle_deg": -90, "length_change_um": -4.1}, {"angle_deg": -45, "length_change_um": -0.3},
                {"angle_deg": 0, "length_change_um": 0.0}, {"angle_deg": 45, "length_change_um": 3.9},
                {"angle_deg": 90, "length_change_um": 10.2}]}]
    })),
    responses(
        (status = 201, description = "The run with its results", body = crate::wire::CalibrationDocument,
            headers(("ETag" = String, description = "Tag of the content"), ("Location" = String, description = "The run"))),
        Refusals,
    )
)]
pub(super) async fn create_calibration(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    request: Request,
) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    choose(&parts.headers, &["application/json"])?;
    let (key, actor) = (key(&parts)?, actor(&parts)?);
    let current = unless_keyed(key.as_ref(), current_machine(&app, &machine_id).await)?;
    let Json(request) =
        Json::<CalibrationRequest>::from_request(Request::from_parts(parts.clone(), body), &app).await?;
    let run = serde_json::to_string(&request).map_err(|fault| Problem::internal(&fault))?;
    let used = used(&app, &parts, key, &[&run]);
    if let Some(Remembered::Calibration(known)) = answered(&app, used.as_ref()).await? {
        return Ok(created(&known));
    }
    let current = current?;
    let mut known = Vec::new();
    let measured_at = measured_at(&request.measured_at, app.sources.clock.now()).unwrap_or_else(|fault| {
        known.push(fault);
        String::new()
    });
    let (id, created_at) = (app.sources.ids.next().to_string(), app.sources.timestamp());
    let new = app
        .compute
        .run(move |_stop| {
            let head = CalibrationHead {
                id,
                machine_id: &machine_id,
                machine_revision: current.revision,
                measured_at,
                created_at,
                run_sha256: sha256_hex(run.as_bytes()),
            };
            let document = evaluate(&request, &current.machine, head, known)
                .map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))?;
            let text = serde_json::to_string(&document).map_err(|fault| Problem::internal(&fault))?;
            let document_sha256 = sha256_hex(text.as_bytes());
            Ok::<_, Problem>(NewCalibration { document, text, document_sha256, run })
        })
        .await??;
    if app.store.add_calibration(&new, used.as_ref(), &actor).await? {
        let NewCalibration { document, text, document_sha256, run } = new;
        return Ok(created(&CalibrationRow { text, document, document_sha256, run }));
    }
    // The same key arrived twice at the same time; the other request was stored.
    match answered(&app, used.as_ref()).await? {
        Some(Remembered::Calibration(first)) => Ok(created(&first)),
        _ => Err(key_reused()),
    }
}

fn created(run: &CalibrationRow) -> Response {
    let location = format!("/v1/machines/{}/calibrations/{}", run.document.machine_id, run.document.id);
    let response = (StatusCode::CREATED, [(LOCATION, location)], json_response(run.text.clone()));
    tagged(tag(run), response.into_response())
}
