//! What every request may run into: the deadline, a panic, an address or a method that is not there.

use std::any::Any;
use std::time::Duration;

use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use super::AppState;
use super::problem::{Problem, ProblemType};

/// The id of a request.
#[derive(Debug, Clone)]
pub(super) struct RequestId(pub(super) String);

/// Ends a request that takes too long; what it computes is told to stop.
pub(super) async fn deadline(State(app): State<AppState>, request: Request, next: Next) -> Response {
    let limit_s = app.settings.request_timeout_s;
    match tokio::time::timeout(Duration::from_secs_f64(limit_s), next.run(request)).await {
        Ok(response) => response,
        Err(_elapsed) => {
            Problem::new(ProblemType::TimedOut, format!("the request took longer than {limit_s} s"))
                .into_response()
        }
    }
}

/// The answer to a panic.
#[expect(clippy::needless_pass_by_value, reason = "the layer hands it over")]
pub(super) fn panicked(cause: Box<dyn Any + Send + 'static>) -> Response {
    let text = cause.downcast_ref::<&str>().map(ToString::to_string);
    let text = text.or_else(|| cause.downcast_ref::<String>().cloned()).unwrap_or_default();
    Problem::internal(&format!("a handler panicked: {text}")).into_response()
}

/// Nothing is at this address.
pub(super) async fn not_found(request: Request) -> Problem {
    Problem::new(ProblemType::NotFound, format!("there is nothing at {}", request.uri().path()))
}

/// The resource does not have this method.
pub(super) async fn method_not_allowed(request: Request) -> Problem {
    Problem::new(ProblemType::MethodNotAllowed, format!("there is no {} here", request.method()))
}
