//! Records refusals of the guard and of admission.

use std::net::SocketAddr;

use axum::extract::{ConnectInfo, MatchedPath};
use http::{Extensions, Method};

use super::AppState;
use super::request_facts::RequestFacts;
use super::security_log::{Reason, SecurityEvent};

/// Writes a refusal to the security log, and its reason and source to the request's log line.
pub(super) fn note_refusal(
    app: &AppState,
    reason: Reason,
    key_id: Option<&str>,
    method: &Method,
    extensions: &Extensions,
) {
    let source = extensions.get::<ConnectInfo<SocketAddr>>().map(|peer| peer.0.ip().to_canonical());
    let span = tracing::Span::current();
    span.record("refused", reason.as_str());
    if let Some(source) = source {
        span.record("source", tracing::field::display(source));
    }
    app.security.note(SecurityEvent {
        at: app.sources.timestamp(),
        reason,
        source,
        key_id: key_id.map(ToOwned::to_owned),
        method: method.to_string(),
        route: extensions.get::<MatchedPath>().map(|route| route.as_str().to_owned()),
        request_id: RequestFacts::of(extensions)
            .map_or_else(String::new, |request| request.id.as_str().to_owned()),
    });
}
