//! What every request goes through: its id, its span and log line, its deadline, and the last look at its answer.

use std::any::Any;
use std::time::{Duration, Instant};

use axum::extract::{MatchedPath, Request, State};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use http::header::{ALLOW, CONTENT_TYPE, HeaderName};
use http::{HeaderMap, HeaderValue};
use tracing::Instrument;

use super::AppState;
use super::problem::{PROBLEM_JSON, Problem, ProblemType};

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");

/// The id of a request.
#[derive(Debug, Clone)]
pub(super) struct RequestId(pub(super) String);

/// Id, span, log line, counts; a refusal that is not a problem document yet becomes one.
pub(super) async fn watch(State(app): State<AppState>, mut request: Request, next: Next) -> Response {
    let id = request_id(&app, request.headers());
    let method = request.method().clone();
    let route = request.extensions().get::<MatchedPath>().map_or("unmatched", MatchedPath::as_str).to_owned();
    let span =
        tracing::info_span!("request", request_id = %id, %method, %route, key_id = tracing::field::Empty);
    request.extensions_mut().insert(RequestId(id.clone()));
    let began = Instant::now();
    let mut response = dressed(next.run(request).instrument(span.clone()).await);
    let (elapsed_s, status) = (began.elapsed().as_secs_f64(), response.status().as_u16());
    if let Ok(value) = HeaderValue::try_from(&id) {
        response.headers_mut().insert(REQUEST_ID, value);
    }
    span.in_scope(|| tracing::info!(status, elapsed_ms = elapsed_s * 1e3, "answered"));
    // A client must not be able to multiply the series by inventing methods.
    let known = matches!(method.as_str(), "GET" | "HEAD" | "POST" | "PUT" | "DELETE" | "PATCH" | "OPTIONS");
    let method = if known { method.as_str() } else { "other" };
    let labels = [("method", method.to_owned()), ("route", route), ("status", status.to_string())];
    metrics::with_local_recorder(&*app.recorder, || {
        metrics::counter!("trunnion_requests_total", &labels).increment(1);
        metrics::histogram!("trunnion_request_duration_seconds", &labels).record(elapsed_s);
    });
    response
}

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

fn request_id(app: &AppState, headers: &HeaderMap) -> String {
    let given = headers.get(REQUEST_ID).and_then(|value| value.to_str().ok());
    let sound = |id: &&str| (1..=128).contains(&id.len()) && id.bytes().all(|byte| byte.is_ascii_graphic());
    given.filter(sound).map_or_else(|| app.sources.ids.next().to_string(), str::to_owned)
}

fn dressed(response: Response) -> Response {
    let status = response.status();
    if !(status.is_client_error() || status.is_server_error()) {
        return response;
    }
    let has = response.headers().get(CONTENT_TYPE).is_some_and(|kind| kind == PROBLEM_JSON);
    if has {
        return response;
    }
    let kind = ProblemType::of_status(status);
    let detail = if kind == ProblemType::UnsupportedMediaType {
        "content codings are gzip and zstd"
    } else {
        kind.title()
    };
    let mut problem = Problem::new(kind, detail).into_response();
    for name in [ALLOW, http::header::ACCEPT_ENCODING] {
        if let Some(value) = response.headers().get(&name) {
            problem.headers_mut().insert(name, value.clone());
        }
    }
    problem
}
