//! Lists the attempts to deliver a job's end.

use axum::extract::State;
use http::HeaderMap;

use super::find;
use crate::description::operation;
use crate::http::AppState;
use crate::http::caller::Caller;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::paging::PageQuery;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::store::DeliveryRow;
use crate::wire::{
    Deliveries, DeliveryAttempt, DeliveryDocument, JobDocument, Scope, event_type, webhook_id,
};

refusals!(Refusals: MalformedRequest, JobNotFound, NotAcceptable, InvalidRequest);

/// List the deliveries of a job's end
///
/// The state of the delivery to `callback_url`, and every attempt, newest first. If an attempt got no answer, only a
/// key with the scope `admin` sees the cause.
#[operation(
    get,
    path = "/v1/jobs/{id}/deliveries",
    tag = "webhooks",
    operation_id = "list_job_deliveries",
    params(
        ("id" = String, Path, description = "The job", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        PageQuery,
    ),
    responses(
        (status = 200, description = "A page of attempts", body = Deliveries, example = json!({
            "delivery": {
                "webhook_id": "msg_0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60", "event": "job.succeeded", "state": "waiting",
                "attempts": 1, "next_attempt_at": "2026-03-14T09:26:58.701Z"},
            "items": [{
                "started_at": "2026-03-14T09:26:53.589Z", "duration_ms": 42, "status": 503, "outcome": "refused",
                "detail": "the receiver answered 503"}],
            "next_cursor": null})),
        Refusals,
    )
)]
pub(super) async fn list_job_deliveries(
    State(app): State<AppState>,
    Path(id): Path<String>,
    Query(page): Query<PageQuery>,
    caller: Caller,
    headers: HeaderMap,
) -> Result<Json<Deliveries>, Problem> {
    choose(&headers, &["application/json"])?;
    let (limit, before) = page.read()?;
    let job = find(&app, &id).await?.document;
    let delivery = app.store.delivery(&id).await?.map(|row| shown(&job, row));
    let page = app.store.delivery_attempts(&id, limit, before).await?;
    let next_cursor = page.next.map(|cursor| cursor.to_string());
    let mut items = page.items;
    if !caller.may(Scope::Admin) {
        items = items.into_iter().map(DeliveryAttempt::without_cause).collect();
    }
    Ok(Json(Deliveries { delivery, items, next_cursor }))
}

/// A delivery as clients see it.
pub(super) fn shown(job: &JobDocument, row: DeliveryRow) -> DeliveryDocument {
    DeliveryDocument {
        webhook_id: webhook_id(&job.id),
        event: event_type(job),
        state: row.state,
        attempts: row.attempts,
        next_attempt_at: row.due_at,
    }
}
