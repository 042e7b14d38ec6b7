//! Applies the errors of a run to the machine.

use axum::extract::{Request, State};
use axum::response::Response;

use super::{find, measured_revision};
use crate::description::operation;
use crate::http::AppState;
use crate::http::author::actor;
use crate::http::body::{Incoming, media_type};
use crate::http::conditional::{expected, machine_response, machine_tag, stale, tagged};
use crate::http::extract::{Path, Query, is_json};
use crate::http::idempotency::{answered, key, used};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::jobs::profile_sha256;
use crate::store::{Expected, NewRevision, PutOutcome, Remembered, Revision, Stale};
use crate::wire::{AppliedProfile, ApplyRequest, NoParameters, OtherAxes, read_json};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, CalibrationNotFound, NotAcceptable, RequestTimeout,
    KeyReused, ConfirmationNeeded, AxesChanged, PreconditionFailed, PreconditionRequired, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest, InvalidMachine
);

/// Apply a calibration run
///
/// The run's location errors replace those of the measured axes. This makes a new revision of the machine, which
/// names the run. If the run is applied again to that revision, the revision stays the same. To go back, apply an
/// older run. `If-Match` with the machine's `ETag` is required.
///
/// `{"confirm": true}` is needed in three cases: a value changes by more than 0.2 mm or 1000 µrad, the run leaves an
/// error undetermined, or the squareness has changed since the run. A run of only one axis is refused if the error of
/// the axis that carries it has changed since: post its readings again.
#[operation(
    post,
    path = "/v1/machines/{machine_id}/calibrations/{id}/apply",
    tag = "calibrations",
    operation_id = "apply_calibration",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("id" = String, Path, description = "The run", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ("If-Match" = String, Header, description = "ETag of the machine's current revision; `*` fits every revision", example = "*"),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key with the same request returns the same answer"),
    ),
    request_body(content = Option<ApplyRequest>, description = "No body, or the confirmation of a large change", example = json!({"confirm": true})),
    responses(
        (status = 200, description = "The machine with the errors of the run", body = crate::wire::MachineDocument,
            headers(("ETag" = String, description = "Tag of the revision"),
                ("Trunnion-Calibration" = String, description = "The run"))),
        Refusals,
    )
)]
pub(super) async fn apply_calibration(
    State(app): State<AppState>,
    Path((machine_id, id)): Path<(String, String)>,
    Query(NoParameters {}): Query<NoParameters>,
    request: Request,
) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    choose(&parts.headers, &["application/json"])?;
    let (key, actor) = (key(&parts)?, actor(&parts)?);
    let text = Incoming::new(body, app.settings.body_pause_timeout_s)
        .whole(&parts.headers, app.settings.max_json_bytes)
        .await?;
    let ApplyRequest { confirm } = if text.is_empty() {
        ApplyRequest::default()
    } else if media_type(&parts.headers).as_deref().is_none_or(is_json) {
        read_json(&text)?
    } else {
        let detail = "send application/json or no body";
        return Err(Problem::new(ProblemType::UnsupportedMediaType, detail));
    };
    let expected = expected(&parts.headers)?;
    let condition = format!("{expected:?}");
    let used = used(&app, &parts, key, &[&condition, if confirm { "confirmed" } else { "" }]);
    if let Some(Remembered::Revision(known)) = answered(&app, used.as_ref()).await? {
        return Ok(machine(*known));
    }
    let run = find(&app, &machine_id, &id).await?;
    let current =
        app.store.machine(&machine_id).await?.ok_or_else(|| Problem::machine_not_found(&machine_id))?;
    // The profile that is changed is the one that is read here: no other change may come between.
    let this = Expected::OneOf(vec![(current.document.revision, current.sha256.clone())]);
    match &expected {
        None => return Err(stale(Stale::Unconditional, &machine_id)),
        Some(expected) if !current.fits(expected) => return Err(stale(Stale::Changed, &machine_id)),
        Some(_) => {}
    }
    let measured = measured_revision(&app, &run).await?;
    let AppliedProfile { profile, to_confirm } =
        run.document.apply_to(&current.document.profile, &measured.document.profile).map_err(|other| {
            let what = match other {
                OtherAxes::Nominal => "whose nominal rotary axes differ from those",
                OtherAxes::Carrier => {
                    "where the axis that carries the measured axis has another location error than that"
                }
            };
            let (then, now) = (measured.document.revision, current.document.revision);
            let detail = format!("the run measured revision {then}, {what} of revision {now}");
            Problem::new(ProblemType::AxesChanged, detail)
        })?;
    if !confirm && !to_confirm.is_empty() {
        return Err(Problem::invalid(ProblemType::ConfirmationNeeded, to_confirm));
    }
    let (profile, _machine) =
        profile.into_machine().map_err(|faults| Problem::invalid(ProblemType::InvalidMachine, faults))?;
    let new = NewRevision {
        machine_id: machine_id.clone(),
        sha256: profile_sha256(&profile),
        profile,
        calibration_id: Some(id),
        created_at: app.sources.timestamp(),
    };
    let put = app.store.put_machine(new, Some(this), used.as_ref(), &actor).await?;
    match put.map_err(|reason| stale(reason, &machine_id))? {
        PutOutcome::Created(stored) | PutOutcome::Replaced(stored) => Ok(machine(stored)),
    }
}

fn machine(stored: Revision) -> Response {
    tagged(&machine_tag(&stored), machine_response(stored))
}
