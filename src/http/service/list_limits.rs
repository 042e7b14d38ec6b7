//! The limits of the service: size, number, cost and time.

use axum::extract::State;
use http::HeaderMap;
use serde::Serialize;

use crate::config::{ENVIRONMENT, MEANINGS, Settings};
use crate::description::{ToSchema, operation};
use crate::http::AppState;
use crate::http::extract::{Json, Query};
use crate::http::negotiate::choose;
use crate::http::problem::{Problem, ProblemType};
use crate::http::refusals::refusals;
use crate::wire::NoParameters;

refusals!(Refusals: MalformedRequest, NotAcceptable, InvalidRequest, Busy);

/// Every limit.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct Limits {
    /// The limits, in no particular order.
    items: Vec<Limit>,
}

/// A limit.
#[derive(Debug, Serialize, ToSchema)]
pub(super) struct Limit {
    /// Name of the setting, as in the settings file.
    #[schema(example = "max_body_bytes")]
    setting: &'static str,
    /// Name of its environment variable.
    #[schema(example = "TRUNNION_MAX_BODY_BYTES")]
    environment: &'static str,
    /// Meaning of the limit.
    meaning: &'static str,
    /// Value of the limit, in its unit.
    #[schema(example = 268_435_456)]
    value: f64,
    /// Unit of the value; `1` for a number of things.
    #[schema(example = "bytes")]
    unit: &'static str,
    /// Status of the answer if the limit is exceeded; null if the connection is closed or the item waits instead.
    #[schema(example = 413)]
    status: Option<u16>,
    /// Type of the problem if the limit is exceeded; null if the connection is closed or the item waits instead.
    #[schema(example = "/problems/body-too-large")]
    problem: Option<String>,
}

type Row = (&'static str, fn(&Settings) -> f64, &'static str, Option<ProblemType>);

/// Each limit with its unit and the answer if it is exceeded.
const LIMITS: &[Row] = &[
    ("max_body_bytes", |s| s.max_body_bytes as f64, "bytes", Some(ProblemType::BodyTooLarge)),
    ("max_surface_bytes", |s| s.max_surface_bytes as f64, "bytes", Some(ProblemType::BodyTooLarge)),
    (
        "max_surface_memory_bytes",
        |s| s.max_surface_memory_bytes as f64,
        "bytes",
        Some(ProblemType::BodyTooLarge),
    ),
    ("max_memory_bytes", |s| s.max_memory_bytes as f64, "bytes", Some(ProblemType::MemoryBudget)),
    ("max_json_bytes", |s| s.max_json_bytes as f64, "bytes", Some(ProblemType::BodyTooLarge)),
    ("max_parameters_bytes", |s| s.max_parameters_bytes as f64, "bytes", Some(ProblemType::BodyTooLarge)),
    ("max_result_bytes", |s| s.max_result_bytes as f64, "bytes", Some(ProblemType::ResultTooLarge)),
    ("max_url_bytes", |s| s.max_url_bytes as f64, "bytes", Some(ProblemType::UrlTooLong)),
    ("max_header_bytes", |s| s.max_header_bytes as f64, "bytes", Some(ProblemType::HeaderTooLarge)),
    ("max_poses", |s| s.max_poses as f64, "1", Some(ProblemType::TooCostly)),
    ("max_cost_s", |s| s.max_cost_s, "s", Some(ProblemType::TooCostly)),
    ("max_computations", |s| s.computations() as f64, "1", Some(ProblemType::Busy)),
    ("max_waiting_computations", |s| s.max_waiting_computations as f64, "1", Some(ProblemType::Busy)),
    ("max_queued_jobs", |s| s.max_queued_jobs as f64, "1", Some(ProblemType::QueueFull)),
    ("max_tools_per_machine", |s| f64::from(s.max_tools_per_machine), "1", Some(ProblemType::ToolTableFull)),
    ("max_event_streams", |s| s.max_event_streams as f64, "1", Some(ProblemType::Busy)),
    ("max_deliveries", |s| s.max_deliveries as f64, "1", None),
    ("max_deliveries_per_receiver", |s| s.max_deliveries_per_receiver as f64, "1", None),
    ("max_connections", |s| s.max_connections as f64, "1", None),
    ("max_spool_bytes", |s| s.max_spool_bytes as f64, "bytes", Some(ProblemType::StorageUnavailable)),
    ("max_share_per_caller", |s| s.max_share_per_caller, "1", Some(ProblemType::Quota)),
    ("max_rate_per_s", |s| s.max_rate_per_s, "1/s", Some(ProblemType::TooManyRequests)),
    ("max_burst_requests", |s| f64::from(s.max_burst_requests), "1", Some(ProblemType::TooManyRequests)),
    ("request_timeout_s", |s| s.request_timeout_s, "s", Some(ProblemType::TimedOut)),
    ("header_timeout_s", |s| s.header_timeout_s, "s", None),
    ("body_pause_timeout_s", |s| s.body_pause_timeout_s, "s", Some(ProblemType::RequestTimeout)),
    ("answer_pause_timeout_s", |s| s.answer_pause_timeout_s, "s", None),
    ("webhook_timeout_s", |s| s.webhook_timeout_s, "s", None),
];

/// The limits of the service
///
/// Every limit, with the setting that changes it and the answer if it is exceeded. A limit of zero means no limit
/// where its meaning says so.
#[operation(
    get,
    path = "/v1/limits",
    tag = "service",
    operation_id = "list_limits",
    responses(
        (status = 200, description = "The limits", body = Limits, example = json!({"items": [{
            "setting": "max_body_bytes", "environment": "TRUNNION_MAX_BODY_BYTES",
            "meaning": "Largest program or CSV body, after decompression (bytes)", "value": 268_435_456.0,
            "unit": "bytes", "status": 413, "problem": "/problems/body-too-large"}]})),
        Refusals,
    )
)]
pub(super) async fn list_limits(
    State(app): State<AppState>,
    Query(NoParameters {}): Query<NoParameters>,
    headers: HeaderMap,
) -> Result<Json<Limits>, Problem> {
    choose(&headers, &["application/json"])?;
    let named = |table: &'static [(&str, &str)], setting: &str| {
        table.iter().find(|(name, _)| *name == setting).map_or("", |(_, text)| text.trim())
    };
    let items = LIMITS
        .iter()
        .map(|(setting, value, unit, problem)| Limit {
            setting,
            environment: named(ENVIRONMENT, setting),
            meaning: named(MEANINGS, setting),
            value: value(&app.settings),
            unit,
            status: problem.map(|kind| kind.status().as_u16()),
            problem: problem.map(|kind| format!("/problems/{}", kind.code())),
        })
        .collect();
    Ok(Json(Limits { items }))
}
