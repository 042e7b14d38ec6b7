//! Counts and times, for Prometheus.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::header::CONTENT_TYPE;

use crate::http::AppState;
use crate::http::refusals::refusals;

refusals!(Refusals: Busy);

/// Counts and times of requests
///
/// In the text form that Prometheus reads.
#[utoipa::path(
    get,
    path = "/metrics",
    tag = "service",
    operation_id = "get_metrics",
    responses(
        (status = 200, description = "Prometheus text", body = String, content_type = "text/plain",
            example = "trunnion_requests_total{method=\"GET\",route=\"/readyz\",status=\"200\"} 1"),
        Refusals,
    )
)]
pub(super) async fn get_metrics(State(app): State<AppState>) -> Response {
    ([(CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], app.recorder.handle().render())
        .into_response()
}
