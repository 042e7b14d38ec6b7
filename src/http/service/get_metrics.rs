//! Counts and times, for Prometheus.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::HeaderMap;
use http::header::CONTENT_TYPE;

use crate::http::AppState;
use crate::http::negotiate::choose;
use crate::http::problem::Problem;
use crate::http::refusals::refusals;

refusals!(Refusals: NotAcceptable, Busy);

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
pub(super) async fn get_metrics(
    State(app): State<AppState>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    // Scrapers ask for forms of their own first, and take plain text at the end.
    choose(&headers, &["text/plain"])?;
    let text = app.recorder.handle().render();
    Ok(([(CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], text).into_response())
}
