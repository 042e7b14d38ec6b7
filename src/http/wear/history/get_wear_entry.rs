//! Reads a wear entry.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;

use super::ever_existed;
use crate::description::operation;
use crate::http::AppState;
use crate::http::conditional::unless_known;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, MachineNotFound, WearEntryNotFound, NotAcceptable, InvalidRequest);

/// Read a wear entry
///
/// The entry as posted, and its withdrawal if it was withdrawn.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/tools/{tool_id}/wear-entries/{id}",
    tag = "wear",
    operation_id = "get_wear_entry",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("tool_id" = String, Path, description = "Id of the tool, chosen by the client", example = "T12"),
        ("id" = String, Path, description = "The entry", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the version that you have"),
    ),
    responses(
        (status = 200, description = "The entry", body = crate::wire::WearEntry, headers(("ETag" = String, description = "Tag of the content"))),
        (status = 304, description = "Not changed: your version is current"),
        Refusals,
    )
)]
pub(super) async fn get_wear_entry(
    State(app): State<AppState>,
    Path((machine_id, tool_id, id)): Path<(String, String, String)>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &["application/json"])?;
    if let Some(found) = app.store.wear_entry(&machine_id, &tool_id, &id).await? {
        // An entry changes at most once.
        let state = if found.withdrawn.is_some() { "-withdrawn" } else { "" };
        return unless_known(&headers, &format!("{id}{state}"), || Json(found));
    }
    ever_existed(&app, &machine_id).await?;
    Err(Problem::wear_entry_not_found(&tool_id, &id))
}
