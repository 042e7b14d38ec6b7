//! Counts and times, for Prometheus.

use axum::extract::State;
use axum::response::{IntoResponse, Response};
use http::HeaderMap;
use http::header::CONTENT_TYPE;

use crate::description::operation;
use crate::http::AppState;
use crate::http::caller::Caller;
use crate::http::negotiate::choose;
use crate::http::observation::{Calibrations, Readings, metrics_text};
use crate::http::problem::Problem;
use crate::http::refusals::refusals;
use crate::jobs::CalibrationReading;
use crate::meter;
use crate::store::disk_space;

/// Most machines whose calibrations are measured, so that the number of series has a bound.
const MOST_MACHINES: u32 = 1000;

refusals!(Refusals: NotAcceptable, Busy);

/// Read the metrics
///
/// Requests by operation and status, computations, the store, the process and the age of calibrations, in the text format
/// that Prometheus reads.
#[operation(
    get,
    path = "/metrics",
    tag = "service",
    operation_id = "get_metrics",
    responses(
        (status = 200, description = "Prometheus text", body = String, content_type = "text/plain",
            example = "trunnion_http_requests_total{operation=\"get_readiness\",method=\"GET\",status=\"200\"} 1"),
        Refusals,
    )
)]
pub(super) async fn get_metrics(
    State(app): State<AppState>,
    caller: Caller,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    // Scrapers first ask for formats of their own, and accept plain text last.
    choose(&headers, &["text/plain"])?;
    let now = app.sources.clock.now();
    let ages = app.store.calibration_ages(caller.machines.as_deref(), MOST_MACHINES + 1).await;
    let readings = Readings {
        abandoned: app.abandoned.get(),
        resident_bytes: meter::resident_bytes(),
        uptime_s: app.began.elapsed().as_secs_f64(),
        // If the store does not answer, its values are missing.
        queue: app.queue.reading().await.ok(),
        disk: disk_space(&app.settings.data_dir).ok(),
        deliveries: app.courier.reading().await.ok(),
        calibrations: ages.ok().map(|ages| {
            let all = ages.len();
            let read = ages.into_iter().take(MOST_MACHINES as usize);
            let machines: Vec<_> = read.map(|age| CalibrationReading::of(age, now)).collect();
            Calibrations { is_cut: all > machines.len(), machines }
        }),
        soundness: app.spool.blobs().soundness().reading(),
    };
    let text = metrics_text(app.operations(), &readings, &app.security);
    Ok(([(CONTENT_TYPE, "text/plain; version=0.0.4; charset=utf-8")], text).into_response())
}
