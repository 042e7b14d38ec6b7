//! Reads a key.

use axum::extract::State;
use axum::response::Response;
use http::HeaderMap;

use super::key_not_found;
use crate::description::operation;
use crate::http::AppState;
use crate::http::conditional::unless_known;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, KeyNotFound, NotAcceptable, InvalidRequest);

/// Read an API key
///
/// Its scopes, its expiry and its last use; never its secret.
#[operation(
    get,
    path = "/v1/keys/{id}",
    tag = "keys",
    operation_id = "get_api_key",
    params(
        ("id" = String, Path, description = "The key's id", example = "5f1c2d4e9a07"),
        ("If-None-Match" = Option<String>, Header, description = "ETag of the version that you have"),
    ),
    responses(
        (status = 200, description = "The key", body = crate::wire::ApiKeyDocument, headers(("ETag" = String, description = "Tag of the content"))),
        (status = 304, description = "Not changed: your version is current"),
        Refusals,
    )
)]
pub(super) async fn get_api_key(
    State(app): State<AppState>,
    Path(id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &["application/json"])?;
    let key = app.store.api_key(&id).await?.ok_or_else(|| key_not_found(&id))?;
    // These are the only members of a key that ever change.
    let [revoked, used] = [&key.revoked_at, &key.last_used_at].map(|time| time.as_deref().unwrap_or("never"));
    let tag = format!("{id}-{revoked}-{used}");
    unless_known(&headers, &tag, || Json(key))
}
