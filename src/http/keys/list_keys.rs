//! Lists keys.

use axum::extract::State;
use http::HeaderMap;

use crate::description::operation;
use crate::http::AppState;
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::paging::{Listed, PageQuery};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::ApiKeyDocument;

refusals!(Refusals: MalformedRequest, NotAcceptable, InvalidRequest);

/// List the API keys
///
/// Newest first, including revoked and expired keys. A key is never deleted, because the audit log names it. Secrets
/// are not stored.
#[operation(
    get,
    path = "/v1/keys",
    tag = "keys",
    operation_id = "list_api_keys",
    params(PageQuery),
    responses(
        (status = 200, description = "A page of keys", body = Listed<ApiKeyDocument>,
            example = json!({"items": [], "next_cursor": null})),
        Refusals,
    )
)]
pub(super) async fn list_api_keys(
    State(app): State<AppState>,
    Query(page): Query<PageQuery>,
    headers: HeaderMap,
) -> Result<Json<Listed<ApiKeyDocument>>, Problem> {
    choose(&headers, &["application/json"])?;
    let (limit, before) = page.read()?;
    let page = app.store.api_keys(limit, before).await?;
    Ok(Json(Listed::new(page, |key| key)))
}
