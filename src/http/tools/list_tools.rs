//! Lists the tools of a machine.

use axum::extract::State;
use http::HeaderMap;

use crate::description::operation;
use crate::http::AppState;
use crate::http::current_machine::current_machine;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::paging::{Listed, PageQuery};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::ToolDocument;

refusals!(Refusals: MalformedRequest, MachineNotFound, NotAcceptable, InvalidRequest);

/// List the tools of a machine
///
/// The tools at their current revisions, newest tool first. For a machine without tools the list is empty.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/tools",
    tag = "tools",
    operation_id = "list_tools",
    params(("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"), PageQuery),
    responses(
        (status = 200, description = "A page of tools", body = Listed<ToolDocument>,
            example = json!({"items": [], "next_cursor": null})),
        Refusals,
    )
)]
pub(super) async fn list_tools(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    Query(page): Query<PageQuery>,
    headers: HeaderMap,
) -> Result<Json<Listed<ToolDocument>>, Problem> {
    choose(&headers, &["application/json"])?;
    let (limit, before) = page.read()?;
    let page = app.store.tools_page(&machine_id, limit, before).await?;
    if page.items.is_empty() {
        current_machine(&app, &machine_id).await?;
    }
    Ok(Json(Listed::new(page, |tool| tool.document)))
}
