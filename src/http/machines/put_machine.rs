//! Stores a machine: new, or as a new revision.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::header::LOCATION;
use http::{HeaderMap, StatusCode};

use crate::description::operation;
use crate::http::AppState;
use crate::http::author::By;
use crate::http::conditional::{expected, machine_tag, stale, tagged};
use crate::http::extract::{Json, Path, Query};
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::jobs::profile_sha256;
use crate::store::{NewRevision, PutOutcome};
use crate::wire::{Fault, MachineProfile, NoParameters, is_slug};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, RequestTimeout, PreconditionFailed, PreconditionRequired,
    BodyTooLarge, UnsupportedMediaType, InvalidRequest, InvalidMachine, Busy
);

/// Store a machine
///
/// A new id creates a machine (201). An existing machine gets a new revision (200) and needs `If-Match` with the
/// `ETag` of the revision that you read. An identical profile keeps the same revision. `If-None-Match: *` refuses to
/// replace a machine. If both conditions are sent, both must be met.
#[operation(
    put,
    path = "/v1/machines/{machine_id}",
    tag = "machines",
    operation_id = "put_machine",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "dmu-80-t", pattern = "^[a-z0-9][a-z0-9-]{0,63}$"),
        ("If-Match" = Option<String>, Header, description = "ETag of the revision to replace"),
        ("If-None-Match" = Option<String>, Header, description = "`*`: store only a new machine"),
    ),
    request_body(content = MachineProfile, description = "The profile", example = json!({
        "name": "DMU 80 T",
        "kinematics": {
            "rotary_axes": [
                {"name": "A", "side": "table", "direction": [1, 0, 0], "point_mm": [0, 0, -50], "limits_deg": [-120, 120]},
                {"name": "C", "side": "table", "direction": [0, 0, 1], "point_mm": [0, 0, 0]}
            ],
            "linear_limits_mm": {"X": [-400, 400]}
        },
        "work_offsets_mm": {"G54": [120.5, -80, 312.25], "G54.1 P3": [0, 0, 250]},
        "max_feed_mm_per_min": 15000,
        "plane_solution": {"rule": "negative-first", "axis": "A"},
        "serial_number": "1138-5519",
        "calibration_due_days": 90,
        "calibration_limits": {"E_X0C_um": 10, "E_A0C_urad": 30}
    })),
    responses(
        (status = 201, description = "A new machine", body = crate::wire::MachineDocument,
            headers(("ETag" = String, description = "Tag of the revision"), ("Location" = String, description = "The machine"))),
        (status = 200, description = "A new revision, or the same for an identical profile", body = crate::wire::MachineDocument,
            headers(("ETag" = String, description = "Tag of the revision"))),
        Refusals,
    )
)]
pub(super) async fn put_machine(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
    By(actor): By,
    Json(profile): Json<MachineProfile>,
) -> Result<Response, Problem> {
    check_slug(&machine_id)?;
    let expected = expected(&headers)?;
    let (profile, _machine) =
        profile.into_machine().map_err(|faults| Problem::invalid(ProblemType::InvalidMachine, faults))?;
    let (sha256, now) = (profile_sha256(&profile), app.sources.timestamp());
    let new = NewRevision {
        machine_id: machine_id.clone(),
        profile,
        sha256,
        calibration_id: None,
        created_at: now,
    };
    let put = app.store.put_machine(new, expected, None, &actor).await?;
    match put.map_err(|reason| stale(reason, &machine_id))? {
        PutOutcome::Created(stored) => {
            let location = [(LOCATION, format!("/v1/machines/{machine_id}"))];
            Ok(tagged(&machine_tag(&stored), (StatusCode::CREATED, location, Json(stored.document))))
        }
        PutOutcome::Replaced(stored) => {
            Ok(tagged(&machine_tag(&stored), Json(stored.document).into_response()))
        }
    }
}

fn check_slug(machine_id: &str) -> Result<(), Problem> {
    if is_slug(machine_id) {
        return Ok(());
    }
    let detail = "a machine id has 1 to 64 characters of a-z, 0-9 and -, and does not begin with -";
    Err(Problem::invalid(ProblemType::InvalidRequest, vec![Fault::new("/machine_id", detail)]))
}
