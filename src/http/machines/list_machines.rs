//! Lists machines.

use axum::extract::State;
use http::HeaderMap;

use crate::description::operation;
use crate::http::AppState;
use crate::http::caller::Caller;
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::paging::{Listed, PageQuery};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::MachineDocument;

refusals!(Refusals: MalformedRequest, NotAcceptable, InvalidRequest);

/// List machines
///
/// The machines that the API key reaches, at their current revisions; newest machine first.
#[operation(
    get,
    path = "/v1/machines",
    tag = "machines",
    operation_id = "list_machines",
    params(PageQuery),
    responses(
        (status = 200, description = "A page of machines", body = Listed<MachineDocument>,
            example = json!({"items": [], "next_cursor": null})),
        Refusals,
    )
)]
pub(super) async fn list_machines(
    State(app): State<AppState>,
    Query(page): Query<PageQuery>,
    caller: Caller,
    headers: HeaderMap,
) -> Result<Json<Listed<MachineDocument>>, Problem> {
    choose(&headers, &["application/json"])?;
    let (limit, before) = page.read()?;
    let page = app.store.machines(caller.machines.as_deref(), limit, before).await?;
    Ok(Json(Listed::new(page, |machine| machine.document)))
}
