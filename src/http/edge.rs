//! The steps of every request on its way to a handler, and their refusals: the deadline, a panic, an address or a
//! method that does not exist.

use std::any::Any;
use std::convert::Infallible;
use std::panic::AssertUnwindSafe;
use std::pin::pin;
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
use super::within::within;
use crate::jobs::asked_by;
use crate::jobs::memory::paid_by;

/// Adds the steps of every request in front of each route.
#[derive(Debug, Clone)]
pub(super) struct EdgeLayer(pub(super) AppState);

impl Layer<Route> for EdgeLayer {
    type Service = Edge;

    fn layer(&self, route: Route) -> Edge {
        Edge { app: self.0.clone(), route }
    }
}

/// A route with the steps in front of it. It is one service instead of a layer for each step: each of axum's layers
/// copies all inner layers for every request.
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

/// Every request passes through this once, on the way to its handler.
async fn pass(app: &AppState, request: Request, route: Route) -> Response {
    watch(app, request, |request| async move {
        // Pinned here. The futures around it then move a pointer, and not two thousand bytes. If the client leaves, it is
        // dropped after them: nothing in it may need the span or the account of the request while it is dropped.
        let admitted = pin!(admitted(app, request, route));
        caught(within_time(app, admitted)).await
    })
    .await
}

/// The answer to a request, if the request is admitted.
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
    // Monitoring requests are answered whatever memory they need.
    if is_watching(request.extensions()) {
        return answered(request, route).await;
    }
    let who = asks(&request);
    let account = match app.memory.open(&who) {
        Ok(account) => account,
        Err(fault) => return Problem::from(fault).into_response(),
    };
    let answered = pin!(answered(request, route));
    let response = paid_by(account.clone(), asked_by(who, answered)).await;
    settled(app, account, response).await
}

/// Passes on a request with its decompressed body.
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

/// The request with its decompressed body.
fn plain(request: Request) -> Result<Request, Box<Response>> {
    if let Some(coding) = coding(request.headers()) {
        return unpacked(request, coding).map_err(|fault| Box::new(Problem::from(fault).into_response()));
    }
    let detail = "use one content coding for a body: gzip or zstd";
    let mut refusal = Problem::new(ProblemType::UnsupportedMediaType, detail).into_response();
    refusal.headers_mut().insert(ACCEPT_ENCODING, HeaderValue::from_static(TAKEN));
    Err(Box::new(refusal))
}

// The steps after an answer are combined from existing futures. An async function would keep each future twice, as an
// argument and as the awaited value, and every request would move that much memory.

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

/// The address does not exist.
pub(super) async fn not_found(request: Request) -> Problem {
    Problem::new(ProblemType::NotFound, format!("there is nothing at {}", request.uri().path()))
}

/// The resource does not have this method.
pub(super) async fn method_not_allowed(request: Request) -> Problem {
    Problem::new(
        ProblemType::MethodNotAllowed,
        format!("this address does not support the method {}", request.method()),
    )
}
