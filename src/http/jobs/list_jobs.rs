//! Lists jobs.

use axum::extract::State;
use http::HeaderMap;
use serde::Deserialize;
use utoipa::IntoParams;

use super::with_progress;
use crate::http::AppState;
use crate::http::caller::Caller;
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::paging::{Listed, PageQuery};
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::jobs::time_bound;
use crate::store::JobFilter;
use crate::wire::{FaultList, JobDocument, JobOperation, JobState};

refusals!(Refusals: MalformedRequest, NotAcceptable, InvalidRequest);

/// Filters and page.
#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields, default)]
#[into_params(parameter_in = Query)]
pub(super) struct JobQuery {
    /// Number of items.
    #[param(minimum = 1, maximum = 200, default = 50)]
    limit: Option<u64>,
    /// `next_cursor` of the previous page.
    cursor: Option<String>,
    /// Only jobs of this machine.
    machine_id: Option<String>,
    /// Only jobs in this state.
    #[param(inline)]
    state: Option<JobState>,
    /// Only jobs with this client id.
    external_id: Option<String>,
    /// Only jobs with this operation.
    #[param(inline)]
    operation: Option<JobOperation>,
    /// Only jobs created at this time or later (RFC 3339, for example `2026-03-14T09:26:53.589Z`).
    #[param(format = "date-time")]
    created_after: Option<String>,
    /// Only jobs created before this time (RFC 3339).
    #[param(format = "date-time")]
    created_before: Option<String>,
}

/// List jobs
///
/// Newest first; only jobs of machines that the API key reaches.
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
    let JobQuery { limit, cursor, machine_id, state, external_id, operation, created_after, created_before } =
        query;
    let mut faults = FaultList::default();
    let mut bound = |pointer, text: Option<String>| {
        text.and_then(|text| time_bound(pointer, &text).map_err(|fault| faults.push(|| fault)).ok())
    };
    let created_after = bound("/created_after", created_after);
    let created_before = bound("/created_before", created_before);
    faults.into_result().map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))?;
    let (limit, before) = PageQuery::new(limit, cursor).read()?;
    let machines = caller.machines.as_deref().cloned();
    let filter =
        JobFilter { machine_id, state, external_id, operation, created_after, created_before, machines };
    let page = app.store.jobs(&filter, limit, before).await?;
    Ok(Json(Listed::new(page, |job| with_progress(&app, job).document)))
}
