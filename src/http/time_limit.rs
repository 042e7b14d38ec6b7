//! The answer to a request that takes too long, or whose steps panic.

use std::any::Any;
use std::panic::AssertUnwindSafe;
use std::time::Duration;

use axum::response::{IntoResponse, Response};
use futures::FutureExt;

use super::AppState;
use super::problem::{Problem, ProblemType};
use super::within::within;

/// The answer, or the refusal of a request that takes too long or panics. `answered` is pinned by the caller: each of these
/// steps moves it.
pub(super) fn limited(
    app: &AppState,
    answered: impl Future<Output = Response> + Unpin,
) -> impl Future<Output = Response> {
    caught(within_time(app, answered))
}

/// Ends a request that takes too long; its computation is stopped.
fn within_time(app: &AppState, answered: impl Future<Output = Response>) -> impl Future<Output = Response> {
    let limit_s = app.settings.request_timeout_s;
    within(Duration::from_secs_f64(limit_s), answered).map(move |answered| {
        answered.unwrap_or_else(|| {
            let detail = format!(
                "the request took longer than the limit of {limit_s} s; split it, or post it as a job"
            );
            Problem::new(ProblemType::TimedOut, detail).into_response()
        })
    })
}

/// Turns a panic into an answer.
fn caught(answered: impl Future<Output = Response>) -> impl Future<Output = Response> {
    AssertUnwindSafe(answered)
        .catch_unwind()
        .map(|answered| answered.unwrap_or_else(|cause| panicked(&*cause)))
}

fn panicked(cause: &(dyn Any + Send)) -> Response {
    let text = cause.downcast_ref::<&str>().map(ToString::to_string);
    let text = text.or_else(|| cause.downcast_ref::<String>().cloned()).unwrap_or_default();
    Problem::internal(&format!("a handler panicked: {text}")).into_response()
}
