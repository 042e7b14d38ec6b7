//! Lists the revisions of a tool.

use axum::extract::State;
use http::HeaderMap;

use crate::description::operation;
use crate::http::AppState;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::paging::{Listed, PageQuery};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::ToolDocument;

refusals!(Refusals: MalformedRequest, MachineNotFound, ToolNotFound, NotAcceptable, InvalidRequest);

/// List the revisions of a tool
///
/// Newest first. Revisions of a deleted tool, and of the tools of a deleted machine, are listed too.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/tools/{tool_id}/revisions",
    tag = "tools",
    operation_id = "list_tool_revisions",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("tool_id" = String, Path, description = "Id of the tool, chosen by the client", example = "T12"),
        PageQuery,
    ),
    responses(
        (status = 200, description = "A page of revisions", body = Listed<ToolDocument>,
            example = json!({"items": [], "next_cursor": null})),
        Refusals,
    )
)]
pub(super) async fn list_tool_revisions(
    State(app): State<AppState>,
    Path((machine_id, tool_id)): Path<(String, String)>,
    Query(page): Query<PageQuery>,
    headers: HeaderMap,
) -> Result<Json<Listed<ToolDocument>>, Problem> {
    choose(&headers, &["application/json"])?;
    let (limit, before) = page.read()?;
    let Some(page) = app.store.tool_revisions(&machine_id, &tool_id, limit, before).await? else {
        return Err(super::not_found(&app, &machine_id, &tool_id).await);
    };
    Ok(Json(Listed::new(page, |revision| revision.document)))
}
