//! Shows the secret that signs webhooks.

use axum::extract::State;
use axum::response::Response;
use http::{HeaderMap, StatusCode};

use super::shown;
use crate::description::operation;
use crate::http::AppState;
use crate::http::extract::Query;
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, NotAcceptable, InvalidRequest);

/// Read the secret of webhooks
///
/// Receivers verify deliveries with this secret (Standard Webhooks, `v1`). It is created at the first start. After a
/// rotation, the previous secrets sign too for one day.
#[operation(
    get,
    path = "/v1/webhooks/secret",
    tag = "webhooks",
    operation_id = "get_webhook_secret",
    responses(
        (status = 200, description = "The secret", body = crate::wire::WebhookSecretDocument, example = json!({
            "secret": "whsec_C2FVsBQIhrscChlQIMV+b5sSYspob7oDAAAAAAAAAAA=", "created_at": "2026-03-14T09:26:53.589Z",
            "previous": []})),
        Refusals,
    )
)]
pub(super) async fn get_webhook_secret(
    State(app): State<AppState>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &["application/json"])?;
    shown(&app, StatusCode::OK).await
}
