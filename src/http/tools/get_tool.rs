//! Reads a tool.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;

use super::not_found;
use crate::description::operation;
use crate::http::AppState;
use crate::http::conditional::{tool_tag, unless_known};
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, MachineNotFound, ToolNotFound, NotAcceptable, InvalidRequest);

/// Read a tool
///
/// The current revision. If `If-None-Match` has its `ETag`, the answer is 304.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/tools/{tool_id}",
    tag = "tools",
    operation_id = "get_tool",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("tool_id" = String, Path, description = "Id of the tool, chosen by the client", example = "T12"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the revision that you have"),
    ),
    responses(
        (status = 200, description = "The current revision", body = crate::wire::ToolDocument,
            headers(("ETag" = String, description = "Tag of the revision"))),
        (status = 304, description = "Not changed: your revision is current"),
        Refusals,
    )
)]
pub(super) async fn get_tool(
    State(app): State<AppState>,
    Path((machine_id, tool_id)): Path<(String, String)>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &["application/json"])?;
    let Some(found) = app.store.tool(&machine_id, &tool_id).await? else {
        return Err(not_found(&app, &machine_id, &tool_id).await);
    };
    unless_known(&headers, &tool_tag(&found), || Json(found.document))
}
