//! Creates a key.

use axum::extract::{FromRequest, Request, State};
use axum::response::{IntoResponse, Response};
use http::StatusCode;
use http::header::{CACHE_CONTROL, LOCATION};

use crate::description::operation;
use crate::http::AppState;
use crate::http::author::actor;
use crate::http::extract::{Json, Query};
use crate::http::idempotency::{key, key_reused, used};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::jobs::{IssueFault, IssuedKey, issue_key};
use crate::store::KeyUse;
use crate::wire::{ApiKeyRequest, Fault, NewApiKeyDocument, NoParameters, Scope};

refusals!(
    Refusals: MalformedRequest, UnreadableJson, NotAcceptable, RequestTimeout, KeyReused, BodyTooLarge,
    UnsupportedMediaType, InvalidRequest, Busy
);

/// Create an API key
///
/// The key is shown only in this answer, because the service stores only its digest. The first key closes the service
/// from the next request on, so it needs the scope `admin`.
#[operation(
    post,
    path = "/v1/keys",
    tag = "keys",
    operation_id = "create_api_key",
    params(
        ("Idempotency-Key" = Option<String>, Header, description = "The same key with the same request creates only one API key; only the first answer has its secret"),
    ),
    request_body(content = ApiKeyRequest, description = "Who uses the key, and its scopes", example = json!({
        "name": "Office of hall 3", "scopes": ["read", "compute", "machines", "calibrations", "admin"],
        "expires_at": "2099-01-01T00:00:00Z"
    })),
    responses(
        (status = 201, description = "The key", body = NewApiKeyDocument,
            headers(("Location" = String, description = "The key without its secret"))),
        Refusals,
    )
)]
pub(super) async fn create_api_key(
    State(app): State<AppState>,
    Query(NoParameters {}): Query<NoParameters>,
    request: Request,
) -> Result<Response, Problem> {
    let (parts, body) = request.into_parts();
    choose(&parts.headers, &["application/json"])?;
    let (idempotency_key, actor) = (key(&parts)?, actor(&parts)?);
    let Json(request) =
        Json::<ApiKeyRequest>::from_request(Request::from_parts(parts.clone(), body), &app).await?;
    let said = serde_json::to_string(&request).map_err(|fault| Problem::internal(&fault))?;
    let used = used(&app, &parts, idempotency_key, &[&said]);
    if let Some(known) = made_before(&app, used.as_ref()).await? {
        return Ok(created(known));
    }
    if actor.key_id.is_none() && !request.scopes.contains(&Scope::Admin) {
        let detail = "the first key closes the service, so it needs the scope admin; without it no further key could be created";
        return Err(Problem::invalid(ProblemType::InvalidRequest, vec![Fault::new("/scopes", detail)]));
    }
    let IssuedKey { row, key } = issue_key(&request, &app.sources).map_err(|fault| match fault {
        IssueFault::Invalid(faults) => Problem::invalid(ProblemType::InvalidRequest, faults),
        IssueFault::NoRandomness(_) => Problem::internal(&fault),
    })?;
    let added = app.store.add_api_key(&row, used.as_ref(), &actor).await;
    app.keys.forget();
    if added? {
        return Ok(created(NewApiKeyDocument { key: Some(key), document: row.document }));
    }
    // The same key arrived twice at the same time; the other request was stored.
    made_before(&app, used.as_ref()).await?.map(created).ok_or_else(key_reused)
}

async fn made_before(app: &AppState, used: Option<&KeyUse>) -> Result<Option<NewApiKeyDocument>, Problem> {
    let Some(used) = used else { return Ok(None) };
    match app.store.api_key_made_by(used).await? {
        Some(Some(document)) => Ok(Some(NewApiKeyDocument { key: None, document })),
        Some(None) => Err(key_reused()),
        // The key may belong to something else that was stored.
        None if app.store.remembered(used).await?.is_some() => Err(key_reused()),
        None if app.store.webhook_secret_made_by(used).await?.is_some() => Err(key_reused()),
        None => Ok(None),
    }
}

fn created(key: NewApiKeyDocument) -> Response {
    let location = format!("/v1/keys/{}", key.document.id);
    let headers = [(LOCATION, location), (CACHE_CONTROL, "no-store".to_owned())];
    (StatusCode::CREATED, headers, Json(key)).into_response()
}
