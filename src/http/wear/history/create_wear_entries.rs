//! Stores measured wear.

use axum::extract::{FromRequest, Request, State};
use axum::response::{IntoResponse, Response};
use http::StatusCode;
use http::header::LOCATION;

use crate::description::operation;
use crate::http::AppState;
use crate::http::author::actor;
use crate::http::current_machine::current_machine;
use crate::http::extract::{Json, Path, Query};
use crate::http::idempotency::{answered, key, key_reused, unless_keyed, used};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::jobs::measured_at;
use crate::store::{AddedWear, Remembered, WearConflict};
use crate::wire::{
    Fault, FaultList, MAX_WEAR_EDGES, MAX_WEAR_ENTRIES, NoParameters, WearEntriesAnswer, WearEntriesRequest,
    WearEntry, check_name, other_quantity, path_segment,
};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, MachineNotFound, NotAcceptable, RequestTimeout, KeyReused,
    BodyTooLarge, UnsupportedMediaType, InvalidRequest, Busy
);

/// Store measured wear
///
/// Post one entry or an array of entries; either all are stored or none. An entry states the wear of a cutter, or of
/// one of its edges, after a number of parts. It never changes. A new or reground cutter in the same tool gets a new
/// `cutter_id`. All entries of one cutter are either of the radius or of the flank.
#[operation(
    post,
    path = "/v1/machines/{machine_id}/tools/{tool_id}/wear-entries",
    tag = "wear",
    operation_id = "create_wear_entries",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("tool_id" = String, Path, description = "Id of the tool, chosen by the client", example = "T12"),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key with the same request returns the same answer"),
    ),
    request_body(
        content((WearEntriesRequest = "application/json", examples(
            ("one" = (summary = "A ball on the tool setter", value = json!({
                "measured_at": "2025-03-14T09:26:53Z", "parts_cut": 120, "radius_wear_um": 14.0,
                "standard_uncertainty_um": 1.0, "note": "tool setter"
            }))),
            ("edges" = (summary = "Two flutes under the microscope", value = json!([
                {"measured_at": "2025-03-14T09:26:53Z", "parts_cut": 120, "flank_wear_um": 88.0, "cutter_id": "regrind 2", "edge": "1"},
                {"measured_at": "2025-03-14T09:28:10Z", "parts_cut": 120, "flank_wear_um": 93.5, "cutter_id": "regrind 2", "edge": "2"}
            ]))),
        ))),
    ),
    responses(
        (status = 201, description = "The stored entry, or an array of entries if an array was posted", body = WearEntriesAnswer,
            headers(("Location" = String, description = "The entry, or the list if several were posted"))),
        Refusals,
    )
)]
pub(super) async fn create_wear_entries(
    State(app): State<AppState>,
    Path((machine_id, tool_id)): Path<(String, String)>,
    Query(NoParameters {}): Query<NoParameters>,
    request: Request,
) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    choose(&parts.headers, &["application/json"])?;
    let (key, actor) = (key(&parts)?, actor(&parts)?);
    let machine = unless_keyed(key.as_ref(), current_machine(&app, &machine_id).await)?;
    let Json(request) =
        Json::<WearEntriesRequest>::from_request(Request::from_parts(parts.clone(), body), &app).await?;
    let text = serde_json::to_string(&request).map_err(|fault| Problem::internal(&fault))?;
    let used = used(&app, &parts, key, &[&text]);
    if let Some(Remembered::Wear(known)) = answered(&app, used.as_ref()).await? {
        return created(&request, known);
    }
    machine?;
    let entries = checked_entries(&app, &machine_id, &tool_id, &request)?;
    let added = app.store.add_wear_entries(&entries, used.as_ref(), &actor).await?;
    if added == AddedWear::Stored {
        return created(&request, entries);
    }
    // The same key may have arrived twice at the same time: then the other request was stored first, and this one
    // conflicts with it.
    match (answered(&app, used.as_ref()).await?, added) {
        (Some(Remembered::Wear(first)), _) => created(&request, first),
        (_, AddedWear::Refused(conflicts)) => Err(refused(&request, &conflicts)),
        _ => Err(key_reused()),
    }
}

/// The entries as they will be stored.
fn checked_entries(
    app: &AppState,
    machine_id: &str,
    tool_id: &str,
    request: &WearEntriesRequest,
) -> Result<Vec<WearEntry>, Problem> {
    let mut faults = FaultList::default();
    check_name(|| "/tool_id".to_owned(), tool_id, &mut faults);
    request.check(&mut faults);
    let (now, created_at) = (app.sources.clock.now(), app.sources.timestamp());
    let mut entries: Vec<WearEntry> = Vec::with_capacity(request.entries().len().min(MAX_WEAR_ENTRIES));
    for (index, posted) in request.entries().iter().take(MAX_WEAR_ENTRIES).enumerate() {
        let measured_at =
            measured_at(&posted.measured_at, now).unwrap_or_else(|Fault { pointer, detail }| {
                faults.push(|| Fault::new(request.pointer(index) + &pointer, detail));
                String::new()
            });
        entries.push(WearEntry {
            id: app.sources.ids.next().to_string(),
            machine_id: machine_id.to_owned(),
            tool_id: tool_id.to_owned(),
            cutter_id: posted.cutter_id.clone(),
            edge: posted.edge.clone(),
            measured_at,
            created_at: created_at.clone(),
            parts_cut: u32::try_from(posted.parts_cut).unwrap_or_default(),
            radius_wear_um: posted.radius_wear_um,
            flank_wear_um: posted.flank_wear_um,
            standard_uncertainty_um: posted.standard_uncertainty_um,
            note: posted.note.clone(),
            withdrawn: None,
        });
    }
    let mut order: Vec<usize> = (0..entries.len()).collect();
    let place = |index: &usize| {
        let entry = entries.get(*index);
        entry.map(|entry| (&entry.cutter_id, &entry.edge, entry.parts_cut, &entry.measured_at))
    };
    order.sort_by(|one, other| place(one).cmp(&place(other)));
    let mut twice: Vec<(usize, usize)> = order
        .windows(2)
        .filter_map(|pair| match pair {
            [one, next] if place(one) == place(next) => Some((*one, *next)),
            _ => None,
        })
        .collect();
    if faults.is_empty() {
        twice.sort_unstable_by_key(|(_, next)| *next);
        for (one, next) in twice {
            let detail = format!(
                "has the same cutter, edge, parts and time as entry {one} of this request; remove one of them"
            );
            faults.push(|| Fault::new(request.pointer(next), detail));
        }
    }
    faults.into_result().map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))?;
    Ok(entries)
}

fn refused(request: &WearEntriesRequest, conflicts: &[WearConflict]) -> Problem {
    let mut faults = FaultList::default();
    for conflict in conflicts {
        let (index, member, detail) = match conflict {
            WearConflict::OtherQuantity { index } => {
                let posted = request.entries().get(*index);
                let Some((entry, (quantity, _))) = posted.and_then(|entry| Some((entry, entry.wear()?)))
                else {
                    continue;
                };
                let member = format!("/{}", quantity.member());
                (index, member, other_quantity(&entry.cutter_id, quantity))
            }
            WearConflict::AlreadyThere { index, id } => {
                let detail = format!(
                    "entry {id} has the same cutter, edge, parts and time; withdraw it if it is wrong, and send an Idempotency-Key if a request may arrive twice"
                );
                (index, String::new(), detail)
            }
            WearConflict::TooMany { index } => {
                let detail = format!(
                    "a cutter has at most {MAX_WEAR_ENTRIES} entries; this one would be one too many"
                );
                (index, String::new(), detail)
            }
            WearConflict::TooManyEdges { index } => {
                let detail =
                    format!("a cutter has at most {MAX_WEAR_EDGES} edges; this one would be one too many");
                (index, "/edge".to_owned(), detail)
            }
        };
        faults.push(|| Fault::new(request.pointer(*index) + &member, detail));
    }
    Problem::invalid(ProblemType::InvalidRequest, faults.into_result().err().unwrap_or_default())
}

fn created(request: &WearEntriesRequest, mut entries: Vec<WearEntry>) -> Result<Response, Problem> {
    let Some(first) = entries.first() else {
        return Err(Problem::internal(&"entries that were stored are not there"));
    };
    let mut location =
        format!("/v1/machines/{}/tools/{}/wear-entries", first.machine_id, path_segment(&first.tool_id));
    let answer = match request {
        WearEntriesRequest::One(_) => {
            let entry = entries.swap_remove(0);
            location = format!("{location}/{}", entry.id);
            WearEntriesAnswer::One(Box::new(entry))
        }
        WearEntriesRequest::Many(_) => WearEntriesAnswer::Many(entries),
    };
    Ok((StatusCode::CREATED, [(LOCATION, location)], Json(answer)).into_response())
}
