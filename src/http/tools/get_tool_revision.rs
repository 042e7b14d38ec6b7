//! Reads one revision of a tool.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;

use crate::description::operation;
use crate::http::AppState;
use crate::http::conditional::{tool_tag, unless_known};
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, RevisionNotFound, NotAcceptable, InvalidRequest);

/// Read one revision of a tool
///
/// A revision never changes, and stays after its tool or its machine is deleted.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/tools/{tool_id}/revisions/{revision}",
    tag = "tools",
    operation_id = "get_tool_revision",
    params(
        ("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"),
        ("tool_id" = String, Path, description = "Id of the tool, chosen by the client", example = "T12"),
        ("revision" = i64, Path, description = "Number of the revision", example = 1),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the revision that you have"),
    ),
    responses(
        (status = 200, description = "The revision", body = crate::wire::ToolDocument,
            headers(("ETag" = String, description = "Tag of the revision"))),
        (status = 304, description = "Not changed: your revision is current"),
        Refusals,
    )
)]
pub(super) async fn get_tool_revision(
    State(app): State<AppState>,
    Path((machine_id, tool_id, revision)): Path<(String, String, String)>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &["application/json"])?;
    let found = match revision.parse() {
        Ok(number) => app.store.tool_revision(&machine_id, &tool_id, number).await?,
        Err(_) => None,
    };
    let found = found.ok_or_else(|| {
        let detail = format!("tool {tool_id:?} of machine {machine_id:?} has no revision {revision:?}");
        Problem::new(ProblemType::RevisionNotFound, detail)
    })?;
    unless_known(&headers, &tool_tag(&found), || Json(found.document))
}
