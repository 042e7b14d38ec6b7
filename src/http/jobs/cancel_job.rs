//! Cancels a job.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::{HeaderMap, StatusCode};

use super::{find, job_tag};
use crate::description::operation;
use crate::http::AppState;
use crate::http::author::By;
use crate::http::conditional::tagged;
use crate::http::extract::{Json, Path, Query};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::store::Cancelling;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, JobNotFound, NotAcceptable, JobEnded, InvalidRequest);

/// Cancel a job
///
/// A waiting job is cancelled at once (200). A running job gets a stop signal (202) and is cancelled when it has
/// stopped, which takes about a tenth of a second. A finished job stays as it is (409).
#[operation(
    delete,
    path = "/v1/jobs/{id}",
    tag = "jobs",
    operation_id = "cancel_job",
    params(("id" = String, Path, description = "The job", example = "0195a3f0-7c3e-7b1a-8b57-3f1c2d4e5f60")),
    responses(
        (status = 200, description = "The cancelled job", body = crate::wire::JobDocument,
            headers(("ETag" = String, description = "Tag of the content"))),
        (status = 202, description = "The job, which will stop", body = crate::wire::JobDocument,
            headers(("ETag" = String, description = "Tag of the content"))),
        Refusals,
    )
)]
pub(super) async fn cancel_job(
    State(app): State<AppState>,
    Path(id): Path<String>,
    Query(NoParameters {}): Query<NoParameters>,
    By(by): By,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    choose(&headers, &["application/json"])?;
    let status = match app.queue.cancel(&id, &by).await? {
        Cancelling::Unknown => return Err(Problem::job_not_found(&id)),
        Cancelling::Ended(state) => {
            let detail = format!("the job is {} and cannot be cancelled", state.as_str());
            return Err(Problem::new(ProblemType::JobEnded, detail));
        }
        Cancelling::Cancelled | Cancelling::Already => StatusCode::OK,
        Cancelling::Requested => StatusCode::ACCEPTED,
    };
    let job = find(&app, &id).await?.document;
    Ok(tagged(&job_tag(&job), (status, Json(job)).into_response()))
}
