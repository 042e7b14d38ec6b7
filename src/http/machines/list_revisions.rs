//! Lists the revisions of a machine.

use axum::extract::State;
use http::HeaderMap;

use crate::description::operation;
use crate::http::AppState;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::paging::{Listed, PageQuery};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::MachineDocument;

refusals!(Refusals: MalformedRequest, MachineNotFound, NotAcceptable, InvalidRequest);

/// List the revisions of a machine
///
/// Newest first. Revisions of a deleted machine are listed too.
#[operation(
    get,
    path = "/v1/machines/{machine_id}/revisions",
    tag = "machines",
    operation_id = "list_machine_revisions",
    params(("machine_id" = String, Path, description = "Id of the machine, chosen by the client", example = "example-ac-table"), PageQuery),
    responses(
        (status = 200, description = "A page of revisions", body = Listed<MachineDocument>,
            example = json!({"items": [], "next_cursor": null})),
        Refusals,
    )
)]
pub(super) async fn list_machine_revisions(
    State(app): State<AppState>,
    Path(machine_id): Path<String>,
    Query(page): Query<PageQuery>,
    headers: HeaderMap,
) -> Result<Json<Listed<MachineDocument>>, Problem> {
    choose(&headers, &["application/json"])?;
    let (limit, before) = page.read()?;
    let page = app.store.machine_revisions(&machine_id, limit, before).await?;
    let page = page.ok_or_else(|| Problem::machine_not_found(&machine_id))?;
    Ok(Json(Listed::new(page, |revision| revision.document)))
}
