//! The author of a change, for the audit log: the caller and the request.

use axum::extract::{FromRequestParts, MatchedPath};
use http::request::Parts;

use super::AppState;
use super::problem::Problem;
use super::request_facts::{RequestFacts, caller};
use crate::store::Actor;
use crate::wire::AuditOrigin;

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
        request_id: RequestFacts::of(found).map(|request| request.id.as_str().to_owned()),
    })
}
