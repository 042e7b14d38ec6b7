//! What every request goes through on its way to a handler, and what any may run into: the deadline, a panic, an address
//! or a method that is not there.

use std::any::Any;
use std::convert::Infallible;
use std::panic::AssertUnwindSafe;
use std::time::Duration;

use axum::body::Body;
use axum::extract::{Request, State};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use futures::FutureExt;
use http::header::CONTENT_ENCODING;
use tower::{ServiceExt, service_fn};
use tower_http::decompression::RequestDecompression;

use super::AppState;
use super::admission::admit;
use super::guard::guard;
use super::observation::watch;
use super::problem::{Problem, ProblemType};

/// The id of a request.
#[derive(Debug, Clone)]
pub(super) struct RequestId(pub(super) String);

/// Every request goes through this, once, to its handler: one layer, as each of axum's copies all that lie within it.
pub(super) async fn pass(State(app): State<AppState>, request: Request, next: Next) -> Response {
    let app = &app;
    watch(app, request, |request| {
        caught(within_time(app, async move {
            let request = match guard(app, request).await {
                Ok(request) => request,
                Err(refusal) => return *refusal,
            };
            match admit(app, &request) {
                Some(refusal) => refusal,
                None => decompressed(request, next).await,
            }
        }))
    })
    .await
}

/// Hands on a request whose body is what it says before it was compressed.
async fn decompressed(request: Request, next: Next) -> Response {
    if !request.headers().contains_key(CONTENT_ENCODING) {
        return next.run(request).await;
    }
    let run = |request: http::Request<_>| next.clone().run(request.map(Body::new)).map(Ok::<_, Infallible>);
    match RequestDecompression::new(service_fn(run)).oneshot(request).await {
        Ok(response) => response.map(Body::new),
        Err(fault) => match fault {},
    }
}

/// Ends a request that takes too long; what it computes is told to stop.
async fn within_time(app: &AppState, answered: impl Future<Output = Response>) -> Response {
    let limit_s = app.settings.request_timeout_s;
    match tokio::time::timeout(Duration::from_secs_f64(limit_s), answered).await {
        Ok(response) => response,
        Err(_elapsed) => {
            Problem::new(ProblemType::TimedOut, format!("the request took longer than {limit_s} s"))
                .into_response()
        }
    }
}

/// Answers a panic.
async fn caught(answered: impl Future<Output = Response>) -> Response {
    AssertUnwindSafe(answered).catch_unwind().await.unwrap_or_else(|cause| panicked(&*cause))
}

fn panicked(cause: &(dyn Any + Send)) -> Response {
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
