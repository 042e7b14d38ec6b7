//! Deletes a tool from its machine's table.

use axum::extract::State;
use http::{HeaderMap, StatusCode};

use super::not_found;
use crate::description::operation;
use crate::http::AppState;
use crate::http::author::By;
use crate::http::conditional::{expected, stale_tool};
use crate::http::extract::{Path, Query};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::store::Stale;
use crate::wire::NoParameters;

refusals!(
    Refusals: MalformedRequest, MachineNotFound, ToolNotFound, PreconditionFailed, PreconditionRequired, InvalidRequest
);

/// Delete a tool
///
/// `If-Match` is required. The tool's revisions stay readable for the reports that name them, and its wear entries
/// stay. If a tool is stored again under the same id, the revision numbers continue.
#[operation(
    delete,
    path = "/v1/machines/{machine_id}/tools/{tool_id}",
    tag = "tools",
    operation_id = "delete_tool",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("tool_id" = String, Path, description = "Id of the tool, chosen by the client", example = "T12"),
        ("If-Match" = String, Header, description = "ETag of the current revision; `*` fits every revision", example = "*"),
    ),
    responses((status = 204, description = "The tool is deleted"), Refusals)
)]
pub(super) async fn delete_tool(
    State(app): State<AppState>,
    Path((machine_id, tool_id)): Path<(String, String)>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
    By(actor): By,
) -> Result<StatusCode, Problem> {
    let expected = expected(&headers)?;
    let now = app.sources.timestamp();
    match app.store.delete_tool(&machine_id, &tool_id, expected, &now, &actor).await? {
        Ok(()) => Ok(StatusCode::NO_CONTENT),
        Err(Stale::Missing) => Err(not_found(&app, &machine_id, &tool_id).await),
        Err(reason) => Err(stale_tool(reason, &tool_id)),
    }
}
