//! Webhooks: the secret that signs them. The deliveries are listed under each job.

#[cfg(test)]
mod described;
mod get_secret;
mod rotate_secret;

use axum::response::{IntoResponse, Response};
#[cfg(test)]
pub(super) use described::describe_messages;
use http::StatusCode;
use http::header::CACHE_CONTROL;

use super::AppState;
use super::described::resource;
use super::extract::Json;
use super::problem::Problem;
use crate::jobs::signing_now;
use crate::store::WebhookSecretRow;
use crate::wire::{PreviousSecret, WebhookSecretDocument};

resource! {
    get_secret::get_webhook_secret,
    rotate_secret::rotate_webhook_secret,
}

/// The secrets that sign now; the answer must not be cached.
async fn shown(app: &AppState, status: StatusCode) -> Result<Response, Problem> {
    let now = app.sources.timestamp();
    let kept = app.store.webhook_secrets().await?;
    let mut signing = signing_now(&kept, &now).cloned();
    let WebhookSecretRow { secret, created_at, .. } =
        signing.next().ok_or_else(|| Problem::internal(&"there is no secret to sign webhooks with"))?;
    let previous = signing
        .filter_map(|row| Some(PreviousSecret { created_at: row.created_at, signs_until: row.signs_until? }))
        .collect();
    let document = WebhookSecretDocument { secret, created_at, previous };
    Ok((status, [(CACHE_CONTROL, "no-store")], Json(document)).into_response())
}
