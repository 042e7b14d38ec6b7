//! Lists the wear entries of a tool.

use axum::extract::State;
use http::HeaderMap;
use serde::Deserialize;

use super::{checked, ever_existed};
use crate::description::{IntoParams, operation};
use crate::http::AppState;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::paging::{Listed, PageQuery};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::WearEntry;

refusals!(Refusals: MalformedRequest, MachineNotFound, NotAcceptable, InvalidRequest);

/// Filters and page.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields, default)]
#[into_params(parameter_in = Query)]
pub(super) struct WearEntryQuery {
    /// Number of items.
    #[param(minimum = 1, maximum = 200, default = 50)]
    limit: Option<u64>,
    /// `next_cursor` of the previous page.
    cursor: Option<String>,
    /// Only entries of this cutter.
    cutter_id: Option<String>,
}

/// List wear entries
///
/// The last stored entry comes first; withdrawn entries and those of a deleted machine are listed too. For a tool
/// without entries the list is empty.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/tools/{tool_id}/wear-entries",
    tag = "wear",
    operation_id = "list_wear_entries",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("tool_id" = String, Path, description = "Id of the tool, chosen by the client", example = "T12"),
        WearEntryQuery,
    ),
    responses(
        (status = 200, description = "A page of entries", body = Listed<WearEntry>,
            example = json!({"items": [], "next_cursor": null})),
        Refusals,
    )
)]
pub(super) async fn list_wear_entries(
    State(app): State<AppState>,
    Path((machine_id, tool_id)): Path<(String, String)>,
    Query(query): Query<WearEntryQuery>,
    headers: HeaderMap,
) -> Result<Json<Listed<WearEntry>>, Problem> {
    choose(&headers, &["application/json"])?;
    let WearEntryQuery { limit, cursor, cutter_id } = query;
    let (limit, before) = PageQuery::new(limit, cursor).read()?;
    checked("/tool_id", &tool_id)?;
    let page = app.store.wear_entries(&machine_id, &tool_id, cutter_id.as_deref(), limit, before).await?;
    if page.items.is_empty() {
        ever_existed(&app, &machine_id).await?;
    }
    Ok(Json(Listed::new(page, |entry| entry)))
}
