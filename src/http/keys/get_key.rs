//! Reads a key.

use axum::extract::State;
use http::HeaderMap;

use super::key_not_found;
use crate::http::AppState;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::{ApiKeyDocument, NoParameters};

refusals!(Refusals: MalformedRequest, KeyNotFound, NotAcceptable, InvalidRequest);

/// Read an API key
///
/// What it allows, when it ends, when it was last used; never its secret.
#[utoipa::path(
    get,
    path = "/v1/keys/{id}",
    tag = "keys",
    operation_id = "get_api_key",
    params(("id" = String, Path, description = "The key's id", example = "5f1c2d4e9a07")),
    responses((status = 200, description = "The key", body = ApiKeyDocument), Refusals)
)]
pub(super) async fn get_api_key(
    State(app): State<AppState>,
    Path(id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Json<ApiKeyDocument>, Problem> {
    choose(&headers, &["application/json"])?;
    Ok(Json(app.store.api_key(&id).await?.ok_or_else(|| key_not_found(&id))?))
}
