//! The steps of every request on its way to a handler, and their refusals: no account for its memory, an address or a
//! method that does not exist.

use std::convert::Infallible;
use std::pin::pin;
use std::task::{Context, Poll};

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
use super::guard::{guard, refusal};
use super::host::one_host;
use super::note_refusal::note_refusal;
use super::printed::settled;
use super::problem::{Problem, ProblemType};
use super::rates::Who;
use super::security_log::Reason;
use super::watch::watch;
use crate::jobs::asked_by;
use crate::jobs::memory::{Account, paid_by};

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
        let answered = watch(self.app.clone(), request, |request| admitted(app, request, route));
        Box::pin(answered.map(|response| Ok(dated(response))))
    }
}

// These functions return the future of a block. An async function would keep the request twice, as an argument and as a
// variable, and every step would move that much memory.

/// The answer to a request, if the request is admitted.
#[expect(clippy::manual_async_fn, reason = "its future keeps the request once")]
fn admitted(app: AppState, mut request: Request, route: Route) -> impl Future<Output = Response> {
    async move {
        if let Err(problem) = one_host(&request) {
            note_refusal(&app, Reason::Host, None, request.method(), request.extensions());
            return problem.into_response();
        }
        if let Err(problem) = chunked_or_plain(&request) {
            return problem.into_response();
        }
        if let Err(refused) = guard(&app, &mut request).await {
            // Boxed because it is rare: otherwise its memory would be part of every request's.
            return Box::pin(refusal(&app, refused, request)).await;
        }
        let (who, account) = match opened(&app, &request) {
            Ok(opened) => opened,
            Err(refusal) => return *refusal,
        };
        let answered = pin!(answered(request, route));
        let Some(account) = account else { return answered.await };
        let response = paid_by(account.clone(), asked_by(who, answered)).await;
        settled(&app, account, response).await
    }
}

/// The caller of a request that has passed the guard, and the account that reserves the memory for its work. Requests
/// of monitoring need no account: they are answered whatever memory they need.
///
/// # Errors
/// The answer to a request that must not reach its handler.
fn opened(app: &AppState, request: &Request) -> Result<(Who, Option<Account>), Box<Response>> {
    if let Some(refusal) = admit(app, request) {
        return Err(Box::new(refusal));
    }
    let who = asks(request);
    if is_watching(request.extensions()) {
        return Ok((who, None));
    }
    match app.memory.open(&who) {
        Ok(account) => Ok((who, Some(account))),
        Err(fault) => Err(Box::new(Problem::from(fault).into_response())),
    }
}

/// Passes on a request with its decompressed body.
#[expect(clippy::manual_async_fn, reason = "its future keeps the request once")]
fn answered(request: Request, mut route: Route) -> impl Future<Output = Response> {
    async move {
        let called = if request.headers().contains_key(CONTENT_ENCODING) {
            match plain(request) {
                Ok(request) => route.call(request),
                Err(refusal) => return *refusal,
            }
        } else {
            route.call(request)
        };
        called.await.unwrap_or_else(|fault| match fault {})
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
