//! The outermost look at every request: its id, its trace, its span, its one log line, its counts; and the last look at
//! its answer.

use std::time::{Duration, Instant};

use axum::extract::{MatchedPath, Request};
use axum::response::{IntoResponse, Response};
use http::header::{ALLOW, CONTENT_TYPE, HeaderName, LOCATION};
use http::{HeaderMap, HeaderValue, Method, StatusCode};
use tracing::field::Empty;
use tracing::{Instrument, Span};

use super::subject::Subject;
use super::{FinishedSpan, Trace};
use crate::http::AppState;
use crate::http::edge::RequestId;
use crate::http::problem::{PROBLEM_JSON, Problem, ProblemType};
use crate::meter;

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");
const TRACE_RESPONSE: HeaderName = HeaderName::from_static("traceresponse");

/// Id, trace, span, log line, counts; a refusal that is not a problem document yet becomes one.
pub(in crate::http) async fn watch<Answered: Future<Output = Response>>(
    app: &AppState,
    mut request: Request,
    answered: impl FnOnce(Request) -> Answered,
) -> Response {
    let in_flight = meter::IN_FLIGHT.enter();
    let fresh = app.sources.ids.next();
    let trace = Trace::of(request.headers(), fresh);
    let request_id = given_id(request.headers()).map_or_else(|| fresh.to_string(), str::to_owned);
    let route = request.extensions().get::<MatchedPath>().cloned();
    let method = request.method().clone();
    let path = request.uri().path().to_owned();
    let mut watched = Watched {
        app,
        route: route.as_ref().map(MatchedPath::as_str),
        method,
        path: &path,
        request_id: &request_id,
        trace,
        span: Span::none(),
        began: Instant::now(),
        ended: false,
    };
    watched.open();
    let span = watched.span.clone();
    request.extensions_mut().insert(RequestId(request_id.clone()));
    let mut response = dressed(answered(request).instrument(span).await);
    if let Ok(value) = HeaderValue::try_from(&request_id) {
        response.headers_mut().insert(REQUEST_ID, value);
    }
    if let Ok(value) = HeaderValue::try_from(trace.to_string()) {
        response.headers_mut().insert(TRACE_RESPONSE, value);
    }
    watched.end(&response);
    drop(in_flight);
    response
}

/// A request under way. What drops it before its end is a client that leaves.
struct Watched<'a> {
    app: &'a AppState,
    route: Option<&'a str>,
    method: Method,
    path: &'a str,
    request_id: &'a str,
    trace: Trace,
    span: Span,
    began: Instant,
    ended: bool,
}

impl Watched<'_> {
    fn subject(&self) -> Subject<'_> {
        self.route.map_or_else(Subject::default, |pattern| Subject::of(pattern, self.path))
    }

    /// The span is there whatever level is logged: faults within the request need its ids.
    fn open(&mut self) {
        let Subject { machine_id, job_id } = self.subject();
        let operation = self.app.operations().of(self.route, &self.method).map(|series| &*series.operation);
        self.span = tracing::error_span!(
            "request",
            request_id = self.request_id,
            trace_id = format_args!("{:032x}", self.trace.trace_id),
            operation,
            machine_id,
            job_id,
            key_id = Empty,
        );
    }

    fn end(mut self, response: &Response) {
        self.ended = true;
        self.report(Some(response));
    }

    fn report(&self, response: Option<&Response>) {
        let elapsed = self.began.elapsed();
        let status = response.map(Response::status);
        let Some(series) = self.app.operations().of(self.route, &self.method) else { return };
        match status {
            Some(status) => series.count(status),
            None => self.app.abandoned.add(1),
        }
        series.times.record(elapsed);
        let Subject { machine_id, job_id } = self.subject();
        let made = response
            .and_then(|response| response.headers().get(LOCATION)?.to_str().ok())
            .and_then(Subject::job_of_location);
        if let Some(made) = made {
            self.span.record("job_id", made);
        }
        log_line(&self.span, status, elapsed, series.method);
        if let Some(exporter) = self.app.exporter()
            && self.trace.sampled
        {
            exporter.export(&FinishedSpan {
                trace: self.trace,
                operation: &series.operation,
                method: series.method,
                route: self.route,
                status,
                elapsed,
                ended_at: self.app.sources.clock.now(),
                request_id: self.request_id,
                machine_id,
                job_id: job_id.or(made),
            });
        }
    }
}

impl Drop for Watched<'_> {
    fn drop(&mut self) {
        if !self.ended {
            self.report(None);
        }
    }
}

/// One line for each request: what was refused is a warning, what is our fault an error.
fn log_line(span: &Span, status: Option<StatusCode>, elapsed: Duration, method: &str) {
    let elapsed_ms = elapsed.as_secs_f64() * 1e3;
    span.in_scope(|| match status {
        None => tracing::warn!(method, elapsed_ms, "abandoned by the client"),
        Some(status) => {
            let code = status.as_u16();
            if status == StatusCode::SERVICE_UNAVAILABLE || status.is_client_error() {
                tracing::warn!(method, status = code, elapsed_ms, "answered");
            } else if status.is_server_error() {
                tracing::error!(method, status = code, elapsed_ms, "answered");
            } else {
                tracing::info!(method, status = code, elapsed_ms, "answered");
            }
        }
    });
}

fn given_id(headers: &HeaderMap) -> Option<&str> {
    let given = headers.get(REQUEST_ID)?.to_str().ok()?;
    ((1..=128).contains(&given.len()) && given.bytes().all(|byte| byte.is_ascii_graphic())).then_some(given)
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
