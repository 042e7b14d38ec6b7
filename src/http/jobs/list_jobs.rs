//! Lists jobs.

use axum::extract::State;
use http::HeaderMap;
use serde::Deserialize;
use utoipa::IntoParams;

use crate::http::AppState;
use crate::http::caller::Caller;
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::paging::{Listed, PageQuery};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::store::JobFilter;
use crate::wire::{JobDocument, JobState};

refusals!(Refusals: MalformedRequest, NotAcceptable, InvalidRequest);

/// Which jobs, and which page of them.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields, default)]
#[into_params(parameter_in = Query)]
pub(super) struct JobQuery {
    /// How many items.
    #[param(minimum = 1, maximum = 200, default = 50)]
    limit: Option<u64>,
    /// `next_cursor` of the page before.
    cursor: Option<String>,
    /// Only of this machine.
    machine_id: Option<String>,
    /// Only in this state.
    #[param(inline)]
    state: Option<JobState>,
    /// Only with this id of your own.
    external_id: Option<String>,
}

/// List jobs
///
/// Newest first; of the machines that the API key reaches.
#[utoipa::path(
    get,
    path = "/v1/jobs",
    tag = "jobs",
    operation_id = "list_jobs",
    params(JobQuery),
    responses(
        (status = 200, description = "A page of jobs", body = Listed<JobDocument>,
            example = json!({"items": [], "next_cursor": null})),
        Refusals,
    )
)]
pub(super) async fn list_jobs(
    State(app): State<AppState>,
    Query(query): Query<JobQuery>,
    caller: Caller,
    headers: HeaderMap,
) -> Result<Json<Listed<JobDocument>>, Problem> {
    choose(&headers, &["application/json"])?;
    let JobQuery { limit, cursor, machine_id, state, external_id } = query;
    let (limit, before) = PageQuery::new(limit, cursor).read()?;
    let machines = caller.machines.as_deref().cloned();
    let filter = JobFilter { machine_id, state, external_id, machines };
    let page = app.store.jobs(&filter, limit, before).await?;
    Ok(Json(Listed::new(page, |job| job.document)))
}
