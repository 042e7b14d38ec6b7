//! Creates a new secret that signs webhooks.

use axum::extract::{Request, State};
use axum::response::Response;
use http::StatusCode;

use super::shown;
use crate::description::operation;
use crate::http::AppState;
use crate::http::author::actor;
use crate::http::extract::Query;
use crate::http::idempotency::{key, key_reused, used};
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::jobs::{SECRET_OVERLAP_S, new_webhook_secret};
use crate::store::KeyUse;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, NotAcceptable, KeyReused, InvalidRequest);

/// Rotate the secret of webhooks
///
/// Creates a new secret. The previous secret signs too for 24 hours, so that you can give the new secret to the
/// receivers. If a secret has leaked, rotate it, give the new secret to the receivers, and let them refuse the old
/// one.
#[operation(
    post,
    path = "/v1/webhooks/secret/rotation",
    tag = "webhooks",
    operation_id = "rotate_webhook_secret",
    params(
        ("Idempotency-Key" = Option<String>, Header, description = "The same key creates only one new secret; a repeated request returns the newest secret"),
    ),
    responses(
        (status = 201, description = "The new secret", body = crate::wire::WebhookSecretDocument, example = json!({
            "secret": "whsec_C2FVsBQIhrscChlQIMV+b5sSYspob7oDAAAAAAAAAAA=", "created_at": "2026-03-14T09:26:53.589Z",
            "previous": [{"created_at": "2026-01-02T08:00:00.000Z", "signs_until": "2026-03-15T09:26:53.589Z"}]})),
        Refusals,
    )
)]
pub(super) async fn rotate_webhook_secret(
    State(app): State<AppState>,
    Query(NoParameters {}): Query<NoParameters>,
    request: Request,
) -> Result<Response, Problem> {
    let (parts, _no_body) = request.into_parts();
    choose(&parts.headers, &["application/json"])?;
    let actor = actor(&parts)?;
    let used = used(&app, &parts, key(&parts)?, &[]);
    if !made_before(&app, used.as_ref()).await? {
        let secret = new_webhook_secret().map_err(|fault| Problem::internal(&fault))?;
        let (now, until) = (app.sources.timestamp(), app.sources.timestamp_after(SECRET_OVERLAP_S));
        let rotated = app.store.rotate_webhook_secret(&secret, &now, &until, used.as_ref(), &actor).await?;
        // Otherwise the same key arrived twice at the same time, and the other request was first.
        if !rotated && !made_before(&app, used.as_ref()).await? {
            return Err(key_reused());
        }
    }
    shown(&app, StatusCode::CREATED).await
}

async fn made_before(app: &AppState, used: Option<&KeyUse>) -> Result<bool, Problem> {
    let Some(used) = used else { return Ok(false) };
    match app.store.webhook_secret_made_by(used).await? {
        Some(true) => Ok(true),
        Some(false) => Err(key_reused()),
        // The key may belong to something else that was stored.
        None if app.store.remembered(used).await?.is_some() => Err(key_reused()),
        None if app.store.api_key_made_by(used).await?.is_some() => Err(key_reused()),
        None => Ok(false),
    }
}
