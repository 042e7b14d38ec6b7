//! Facts about a request that the service adds: its id, its trace and its caller. They share one extension of the
//! request, because each extension costs every request an allocation. A new fact is a member here, and `watch` sets it.

use axum::extract::FromRequestParts;
use http::Extensions;
use http::request::Parts;

use super::AppState;
use super::caller::Caller;
use super::observation::Trace;
use super::problem::Problem;
use super::request_id::RequestId;

/// A request's id, its trace and its caller.
#[derive(Debug, Clone)]
pub(super) struct RequestFacts {
    pub(super) id: RequestId,
    pub(super) trace: Trace,
    /// The caller, after the request has passed the guard.
    pub(super) caller: Option<Caller>,
}

impl RequestFacts {
    /// The facts about this request; `None` if it did not pass `watch`.
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
    let found = RequestFacts::caller_of(extensions).cloned();
    found.ok_or_else(|| Problem::internal(&"a request did not pass the guard"))
}
