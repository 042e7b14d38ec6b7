//! Delivers a job's end once more.

use axum::extract::{Request, State};
use axum::response::{IntoResponse, Response};
use http::StatusCode;
use http::header::LOCATION;

use super::find;
use super::list_deliveries::shown;
use crate::description::operation;
use crate::http::AppState;
use crate::http::author::actor;
use crate::http::extract::{Json, Path, Query};
use crate::http::idempotency::{key, key_reused, remembered, used};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::store::Redelivery;
use crate::wire::{JobDocument, NoParameters};

refusals!(
    Refusals: MalformedRequest, JobNotFound, NotAcceptable, NothingToDeliver, KeyReused, InvalidRequest
);

/// Deliver a job's end again
///
/// Sends the webhook to `callback_url` now, whatever the result of earlier attempts. If that fails, further attempts
/// follow after the usual pauses. The delivery keeps its `webhook-id`.
#[operation(
    post,
    path = "/v1/jobs/{id}/deliveries",
    tag = "webhooks",
    operation_id = "deliver_job_again",
    params(
        ("id" = String, Path, description = "The job", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60"),
        ("Idempotency-Key" = Option<String>, Header, description = "The same key asks for only one delivery"),
    ),
    responses(
        (status = 202, description = "The delivery is scheduled", body = crate::wire::DeliveryDocument,
            headers(("Location" = String, description = "The deliveries of the job")),
            example = json!({
                "webhook_id": "msg_0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60", "event": "job.succeeded", "state": "waiting",
                "attempts": 0, "next_attempt_at": "2026-03-14T09:26:58.701Z"})),
        Refusals,
    )
)]
pub(super) async fn deliver_job_again(
    State(app): State<AppState>,
    Path(id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    request: Request,
) -> Result<Response, Problem> {
    let (parts, _no_body) = request.into_parts();
    choose(&parts.headers, &["application/json"])?;
    let (key, actor) = (key(&parts)?, actor(&parts)?);
    let job = find(&app, &id).await?.document;
    let used = used(&app, &parts, key, &[]);
    if remembered(&app, used.as_ref()).await?.is_none() {
        match app.store.deliver_again(&id, &app.sources.timestamp(), used.as_ref(), &actor).await? {
            Redelivery::Asked => app.courier.wake(),
            Redelivery::Nothing => return Err(nothing(&job)),
            // The same key arrived twice at the same time; the other request was first.
            Redelivery::KeyTaken => {
                remembered(&app, used.as_ref()).await?.ok_or_else(key_reused)?;
            }
        }
    }
    let delivery = app.store.delivery(&id).await?.ok_or_else(|| nothing(&job))?;
    let place = [(LOCATION, format!("/v1/jobs/{id}/deliveries"))];
    Ok((StatusCode::ACCEPTED, place, Json(shown(&job, delivery))).into_response())
}

fn nothing(job: &JobDocument) -> Problem {
    let detail = if job.callback_url.is_none() {
        "the job has no callback_url".to_owned()
    } else {
        format!("the job is {} and has not ended", job.state.as_str())
    };
    Problem::new(ProblemType::NothingToDeliver, detail)
}
