//! Revokes a key.

use axum::extract::State;
use http::StatusCode;

use super::key_not_found;
use crate::description::operation;
use crate::http::AppState;
use crate::http::author::By;
use crate::http::extract::{Path, Query};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, KeyNotFound, InvalidRequest);

/// Revoke an API key
///
/// The key is invalid from now on. A service whose keys are all revoked stays closed; create a new key on the command
/// line.
#[operation(
    delete,
    path = "/v1/keys/{id}",
    tag = "keys",
    operation_id = "revoke_api_key",
    params(("id" = String, Path, description = "The key's id", example = "5f1c2d4e9a07")),
    responses((status = 204, description = "The key is revoked"), Refusals)
)]
pub(super) async fn revoke_api_key(
    State(app): State<AppState>,
    Path(id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    By(actor): By,
) -> Result<StatusCode, Problem> {
    let revoked = app.store.revoke_api_key(&id, &app.sources.timestamp(), &actor).await;
    app.keys.forget();
    revoked?.map(|_key| StatusCode::NO_CONTENT).ok_or_else(|| key_not_found(&id))
}
