//! The edge: all steps around a handler. `edge` itself adds `Date`. `watch` adds the id, the trace, the log line and the
//! headers of every answer. `time_limit` ends what takes too long or panics. `before_handler` has the checks before a
//! handler. A new check goes there, a new header of every answer into `watch`, and a new fact about a request into
//! `request_facts`. An address or a method that does not exist is refused here.

use std::convert::Infallible;
use std::task::{Context, Poll};

use axum::extract::Request;
use axum::response::Response;
use axum::routing::Route;
use futures::FutureExt;
use futures::future::BoxFuture;
use tower::{Layer, Service};

use super::AppState;
use super::date::dated;
use super::problem::{Problem, ProblemType};
use super::watch::watch;

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
        Box::pin(watch(app, request, route).map(|response| Ok(dated(response))))
    }
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
