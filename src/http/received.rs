//! What the service knows about a request beside what the client sent. It is one extension of the request: each further
//! one would cost every request two allocations.

use axum::extract::{FromRequestParts, MatchedPath};
use http::Extensions;
use http::request::Parts;

use super::AppState;
use super::caller::Caller;
use super::observation::Trace;
use super::problem::Problem;
use super::request_id::RequestId;
use crate::store::Actor;
use crate::wire::AuditOrigin;

/// A request's id, its trace and its caller.
#[derive(Debug, Clone)]
pub(super) struct Received {
    pub(super) id: RequestId,
    pub(super) trace: Trace,
    /// The caller, after the request has passed the guard.
    pub(super) caller: Option<Caller>,
}

impl Received {
    /// That of this request; `None` for a request that did not come by the edge.
    pub(super) fn of(extensions: &Extensions) -> Option<&Self> {
        extensions.get()
    }

    /// The caller of this request, if it has passed the guard.
    pub(super) fn caller_of(extensions: &Extensions) -> Option<&Caller> {
        Self::of(extensions)?.caller.as_ref()
    }
}

impl FromRequestParts<AppState> for Caller {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _app: &AppState) -> Result<Self, Problem> {
        caller(&parts.extensions)
    }
}

/// The caller.
///
/// # Errors
/// The request did not pass the guard. That is a fault of the service, and the request is refused.
pub(super) fn caller(extensions: &Extensions) -> Result<Caller, Problem> {
    let found = Received::caller_of(extensions).cloned();
    found.ok_or_else(|| Problem::internal(&"a request did not pass the guard"))
}

/// The author of a change, for the audit log.
#[derive(Debug)]
pub(super) struct By(pub(super) Actor);

impl FromRequestParts<AppState> for By {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _app: &AppState) -> Result<Self, Problem> {
        actor(parts).map(Self)
    }
}

/// The author of a change, for the audit log.
///
/// # Errors
/// The request did not pass the guard.
pub(super) fn actor(parts: &Parts) -> Result<Actor, Problem> {
    let found = &parts.extensions;
    Ok(Actor {
        origin: AuditOrigin::Http,
        key_id: caller(found)?.key_id.map(|id| id.to_string()),
        method: Some(parts.method.to_string()),
        route: found.get::<MatchedPath>().map(|route| route.as_str().to_owned()),
        request_id: Received::of(found).map(|request| request.id.as_str().to_owned()),
    })
}
