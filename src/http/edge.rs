//! What every request goes through on its way to a handler, and what any may run into: the deadline, a panic, an address
//! or a method that is not there.

use std::any::Any;
use std::convert::Infallible;
use std::panic::AssertUnwindSafe;
use std::task::{Context, Poll};
use std::time::Duration;

use axum::extract::Request;
use axum::response::{IntoResponse, Response};
use axum::routing::Route;
use futures::FutureExt;
use futures::future::BoxFuture;
use http::HeaderValue;
use http::header::{ACCEPT_ENCODING, CONTENT_ENCODING};
use tower::{Layer, Service};

use super::AppState;
use super::admission::{admit, asks, is_watching};
use super::coding::{TAKEN, coding, unpacked};
use super::date::dated;
use super::framing::chunked_or_plain;
use super::guard::guard;
use super::host::one_host;
use super::note_refusal::note_refusal;
use super::printed::settled;
use super::problem::{Problem, ProblemType};
use super::security_log::Reason;
use super::watch::watch;
use crate::jobs::asked_by;
use crate::jobs::memory::paid_by;

/// Puts every route behind what its requests go through.
#[derive(Debug, Clone)]
pub(super) struct EdgeLayer(pub(super) AppState);

impl Layer<Route> for EdgeLayer {
    type Service = Edge;

    fn layer(&self, route: Route) -> Edge {
        Edge { app: self.0.clone(), route }
    }
}

/// A route behind the edge. One service of our own instead of a layer for each step: each of axum's copies all that lies
/// within it, for every request.
#[derive(Debug, Clone)]
pub(super) struct Edge {
    app: AppState,
    route: Route,
}

impl Service<Request> for Edge {
    type Response = Response;
    type Error = Infallible;
    type Future = BoxFuture<'static, Result<Response, Infallible>>;

    fn poll_ready(&mut self, _context: &mut Context<'_>) -> Poll<Result<(), Infallible>> {
        Poll::Ready(Ok(()))
    }

    fn call(&mut self, request: Request) -> Self::Future {
        let Self { app, route } = self.clone();
        Box::pin(async move { Ok(dated(pass(&app, request, route).await)) })
    }
}

/// Every request goes through this, once, to its handler.
async fn pass(app: &AppState, request: Request, route: Route) -> Response {
    watch(app, request, |request| caught(within_time(app, admitted(app, request, route)))).await
}

/// The answer to a request, if it may be asked.
async fn admitted(app: &AppState, request: Request, route: Route) -> Response {
    if let Err(problem) = one_host(&request) {
        note_refusal(app, Reason::Host, None, request.method(), request.extensions());
        return problem.into_response();
    }
    if let Err(problem) = chunked_or_plain(&request) {
        return problem.into_response();
    }
    let request = match guard(app, request).await {
        Ok(request) => request,
        Err(refusal) => return *refusal,
    };
    if let Some(refusal) = admit(app, &request) {
        return refusal;
    }
    // What watches the service is answered whatever it holds.
    if is_watching(request.extensions()) {
        return answered(request, route).await;
    }
    let who = asks(&request);
    let account = match app.memory.open(&who) {
        Ok(account) => account,
        Err(fault) => return Problem::from(fault).into_response(),
    };
    let response = paid_by(account.clone(), asked_by(who, answered(request, route))).await;
    settled(app, account, response).await
}

/// Hands on a request whose body is what it was before it was compressed.
async fn answered(request: Request, mut route: Route) -> Response {
    let request = if request.headers().contains_key(CONTENT_ENCODING) {
        match plain(request) {
            Ok(request) => request,
            Err(refusal) => return *refusal,
        }
    } else {
        request
    };
    match route.call(request).await {
        Ok(response) => response,
        Err(fault) => match fault {},
    }
}

/// The request before it was compressed.
fn plain(request: Request) -> Result<Request, Box<Response>> {
    if let Some(coding) = coding(request.headers()) {
        return unpacked(request, coding).map_err(|fault| Box::new(Problem::from(fault).into_response()));
    }
    let detail = "content codings are gzip and zstd, one of them for a body";
    let mut refusal = Problem::new(ProblemType::UnsupportedMediaType, detail).into_response();
    refusal.headers_mut().insert(ACCEPT_ENCODING, HeaderValue::from_static(TAKEN));
    Err(Box::new(refusal))
}

// What lies round an answer is put together from futures that are there: an async function would keep each twice, as what
// it was given and as what it waits for, and every request would move as much.

/// Ends a request that takes too long; what it computes is told to stop.
fn within_time(app: &AppState, answered: impl Future<Output = Response>) -> impl Future<Output = Response> {
    let limit_s = app.settings.request_timeout_s;
    tokio::time::timeout(Duration::from_secs_f64(limit_s), answered).map(move |answered| {
        answered.unwrap_or_else(|_elapsed| {
            let detail = format!("the request took longer than {limit_s} s");
            Problem::new(ProblemType::TimedOut, detail).into_response()
        })
    })
}

/// Answers a panic.
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

/// Nothing is at this address.
pub(super) async fn not_found(request: Request) -> Problem {
    Problem::new(ProblemType::NotFound, format!("there is nothing at {}", request.uri().path()))
}

/// The resource does not have this method.
pub(super) async fn method_not_allowed(request: Request) -> Problem {
    Problem::new(ProblemType::MethodNotAllowed, format!("there is no {} here", request.method()))
}
