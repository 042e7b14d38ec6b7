//! Runs all steps of a request inside its span, writes its log line and counts it. Adds its id, its trace and the
//! protecting headers to the answer.

use std::future::poll_fn;
use std::pin::pin;
use std::time::{Duration, Instant};

use axum::extract::{MatchedPath, Request};
use axum::response::{IntoResponse, Response};
use axum::routing::Route;
use http::header::{ALLOW, CONTENT_TYPE, HeaderName, LOCATION};
use http::{HeaderMap, HeaderValue, StatusCode, Uri};
use tracing::Span;
use tracing::field::Empty;

use super::AppState;
use super::answer_guard::guard_answer;
use super::before_handler::checked_and_handled;
use super::observation::{FinishedSpan, Series, Subject, TRACE_ID, Trace};
use super::problem::{PROBLEM_JSON, Problem, ProblemType};
use super::request_facts::RequestFacts;
use super::request_id::RequestId;
use super::time_limit::limited;
use crate::meter;

/// The name under which requests are logged. Filters of logs know it, so it stays, wherever this file goes.
const LOGGED_AS: &str = "trunnion::http::observation::watch";

const REQUEST_ID: HeaderName = HeaderName::from_static("x-request-id");
const TRACE_RESPONSE: HeaderName = HeaderName::from_static("traceresponse");

/// Answers a request. A refusal that is not yet a problem document becomes one.
#[expect(clippy::manual_async_fn, reason = "an async function would store the request twice")]
pub(super) fn watch(app: AppState, mut request: Request, route: Route) -> impl Future<Output = Response> {
    async move {
        let in_flight = meter::IN_FLIGHT.enter();
        let fresh = app.sources.ids.next();
        let trace = Trace::of(request.headers(), fresh);
        let (request_id, trace_text) = (RequestId::new(fresh), trace.text());
        let client_request_id = client_request_id(request.headers()).map(ToOwned::to_owned);
        let matched = request.extensions().get::<MatchedPath>().cloned();
        let pattern = matched.as_ref().map(MatchedPath::as_str);
        let mut watched = Watched {
            app: &app,
            pattern,
            series: app.operations().of(pattern, request.method()),
            address: app.exporter().map(|_exporter| request.uri().clone()),
            request_id: request_id.as_str(),
            client_request_id: client_request_id.as_deref(),
            trace,
            trace_id: trace_text
                .get(TRACE_ID)
                .and_then(|id| std::str::from_utf8(id).ok())
                .unwrap_or_default(),
            span: Span::none(),
            began: Instant::now(),
            ended: false,
        };
        watched.open(request.uri());
        request.extensions_mut().insert(RequestFacts { id: request_id, trace, caller: None });
        let answer = {
            // Pinned here, so that the futures around it hold only a pointer. It is dropped before the request counts as
            // answered, but outside the span: code that runs while it is dropped must not need the span.
            let handled = pin!(checked_and_handled(&app, request, route));
            let mut limited = pin!(limited(&app, handled));
            poll_fn(|context| watched.span.in_scope(|| limited.as_mut().poll(context))).await
        };
        let mut response = dressed(answer);
        guard_answer(&mut response, pattern, app.settings.tls_certificate.is_some());
        response.headers_mut().insert(REQUEST_ID, request_id.header());
        if let Ok(value) = HeaderValue::from_bytes(&trace_text) {
            response.headers_mut().insert(TRACE_RESPONSE, value);
        }
        watched.end(&response);
        drop(in_flight);
        response
    }
}

/// A running request. If it is dropped before its end, the client has left.
struct Watched<'a> {
    app: &'a AppState,
    /// The pattern of its path.
    pattern: Option<&'a str>,
    series: Option<&'a Series>,
    /// The address; `None` if there is no exporter.
    address: Option<Uri>,
    request_id: &'a str,
    client_request_id: Option<&'a str>,
    trace: Trace,
    trace_id: &'a str,
    span: Span,
    began: Instant,
    ended: bool,
}

impl Watched<'_> {
    /// The machine and the job in the path.
    fn subject<'p>(&self, address: &'p Uri) -> Subject<'p> {
        self.pattern.map_or_else(Subject::default, |pattern| Subject::of(pattern, address.path()))
    }

    /// The span exists at every log level: faults within the request need its ids.
    fn open(&mut self, address: &Uri) {
        let Subject { machine_id, job_id } = self.subject(address);
        let operation = self.series.map(|series| &*series.operation);
        self.span = tracing::error_span!(
            target: LOGGED_AS,
            "request",
            request_id = self.request_id,
            client_request_id = self.client_request_id,
            trace_id = format_args!("{}", self.trace_id),
            operation,
            machine_id,
            job_id,
            key_id = Empty,
            source = Empty,
            refused = Empty,
        );
    }

    fn end(mut self, response: &Response) {
        self.ended = true;
        self.report(Some(response));
    }

    fn report(&self, response: Option<&Response>) {
        let elapsed = self.began.elapsed();
        let status = response.map(Response::status);
        let Some(series) = self.series else { return };
        match status {
            Some(status) => series.count(status),
            None => self.app.abandoned.add(1),
        }
        series.times.record(elapsed);
        let made = response
            .and_then(|response| response.headers().get(LOCATION)?.to_str().ok())
            .and_then(Subject::job_of_location);
        if let Some(made) = made {
            self.span.record("job_id", made);
        }
        let problem = response.and_then(|response| response.extensions().get::<ProblemType>());
        let quiet = is_asked_often(self.pattern) && status.is_some_and(|status| status.is_success());
        let line = Line { problem: problem.map(|kind| kind.code()), quiet, elapsed, method: series.method };
        line.write(&self.span, status);
        if let Some(exporter) = self.app.exporter()
            && self.trace.sampled
        {
            let Subject { machine_id, job_id } =
                self.address.as_ref().map_or_else(Subject::default, |address| self.subject(address));
            exporter.export(&FinishedSpan {
                trace: self.trace,
                operation: &series.operation,
                method: series.method,
                route: self.pattern,
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

/// Whether this is a check of the service's health. Containers and balancers ask every few seconds.
fn is_asked_often(route: Option<&str>) -> bool {
    matches!(route, Some("/healthz" | "/readyz"))
}

/// The members of a request's line.
struct Line<'a> {
    /// Code of the problem document, if one was answered.
    problem: Option<&'static str>,
    /// Whether the line is only for a log of everything.
    quiet: bool,
    elapsed: Duration,
    method: &'a str,
}

impl Line<'_> {
    /// One line for each request: a refusal is a warning, a fault of the service is an error.
    fn write(&self, span: &Span, status: Option<StatusCode>) {
        let Self { problem, quiet, elapsed, method } = *self;
        let elapsed_ms = elapsed.as_secs_f64() * 1e3;
        macro_rules! line {
            ($level:ident, $($parts:tt)*) => {
                tracing::$level!(target: LOGGED_AS, parent: span, method, $($parts)*)
            };
        }
        let Some(status) = status else {
            return line!(warn, elapsed_ms, "abandoned by the client");
        };
        let code = status.as_u16();
        if status == StatusCode::SERVICE_UNAVAILABLE || status.is_client_error() {
            line!(warn, status = code, elapsed_ms, problem, "answered");
        } else if status.is_server_error() {
            line!(error, status = code, elapsed_ms, problem, "answered");
        } else if quiet {
            line!(debug, status = code, elapsed_ms, "answered");
        } else {
            line!(info, status = code, elapsed_ms, "answered");
        }
    }
}

/// The client's own id of the request, if it is one word of at most 128 characters. It is kept beside ours and never
/// replaces it: a client could give two requests the same id, or the id of another client.
fn client_request_id(headers: &HeaderMap) -> Option<&str> {
    let given = headers.get(REQUEST_ID)?.to_str().ok()?;
    let sound = (1..=128).contains(&given.len()) && given.bytes().all(|byte| byte.is_ascii_graphic());
    sound.then_some(given)
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
