//! Lists jobs.

use axum::extract::State;
use http::HeaderMap;
use serde::Deserialize;

use super::with_progress;
use crate::description::{IntoParams, operation};
use crate::http::AppState;
use crate::http::caller::Caller;
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::paging::{Listed, PageQuery};
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::jobs::period;
use crate::store::JobFilter;
use crate::wire::{Fault, FaultList, JobDocument, JobOperation, JobState};

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
    /// Only jobs that read a program with this SHA-256.
    #[param(
        pattern = "^[0-9a-f]{64}$",
        example = "2cf24dba5fb0a30e26e83b2ac5b9e29e1b161e5c1fa7425e73043362938b9824"
    )]
    input_sha256: Option<String>,
    /// Only jobs that wrote a program with this SHA-256.
    #[param(
        pattern = "^[0-9a-f]{64}$",
        example = "2cf24dba5fb0a30e26e83b2ac5b9e29e1b161e5c1fa7425e73043362938b9824"
    )]
    output_sha256: Option<String>,
}

/// A digest as it is stored; adds a fault.
fn digest(pointer: &str, text: Option<String>, faults: &mut FaultList) -> Option<String> {
    let digits = |text: &str| text.len() == 64 && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    let text = text?;
    if digits(&text) {
        return Some(text.to_ascii_lowercase());
    }
    let detail = "a SHA-256 is written with 64 hexadecimal digits";
    faults.push(|| Fault::new(pointer, detail));
    None
}

/// List jobs
///
/// Newest first; only jobs of machines that the API key reaches. `input_sha256` and `output_sha256` find the jobs of a
/// program: where a file on a control came from, and whether a source was computed before.
#[operation(
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
    let JobQuery {
        limit,
        cursor,
        machine_id,
        state,
        external_id,
        operation,
        created_after,
        created_before,
        input_sha256,
        output_sha256,
    } = query;
    let mut faults = FaultList::default();
    let pointers = ["/created_after", "/created_before"];
    let (created_after, created_before) =
        period(pointers, created_after.as_deref(), created_before.as_deref(), &mut faults);
    let input_sha256 = digest("/input_sha256", input_sha256, &mut faults);
    let output_sha256 = digest("/output_sha256", output_sha256, &mut faults);
    faults.into_result().map_err(|faults| Problem::invalid(ProblemType::InvalidRequest, faults))?;
    let (limit, before) = PageQuery::new(limit, cursor).read()?;
    let machines = caller.machines.as_deref().cloned();
    let filter = JobFilter {
        machine_id,
        state,
        external_id,
        operation,
        created_after,
        created_before,
        input_sha256,
        output_sha256,
        machines,
    };
    let page = app.store.jobs(&filter, limit, before).await?;
    Ok(Json(Listed::new(page, |job| with_progress(&app, job).document)))
}
