//! Refusals before the body is read: an address or a header that is too long, and a caller that sends too many
//! requests.

use std::net::SocketAddr;
use std::sync::Arc;

use axum::extract::{ConnectInfo, MatchedPath, Request};
use axum::response::{IntoResponse, Response};
use http::header::RETRY_AFTER;
use http::{Extensions, HeaderValue, Method};

use super::AppState;
use super::note_refusal::note_refusal;
use super::problem::{Problem, ProblemType};
use super::rates::Who;
use super::request_facts::RequestFacts;
use super::security_log::Reason;

/// Requests of monitoring. They are never refused for their rate.
const WATCHING: [&str; 3] = ["/healthz", "/readyz", "/metrics"];

/// The refusal of a request that must not reach its handler.
pub(super) fn admit(app: &AppState, request: &Request) -> Option<Response> {
    let key_id = RequestFacts::caller_of(request.extensions()).and_then(|caller| caller.key_id.clone());
    if let Err(problem) = measured(app, request) {
        return Some(problem.into_response());
    }
    turned_away(app, request.method(), request.extensions(), key_id.as_ref())
}

/// Whether the request comes from monitoring.
pub(super) fn is_watching(extensions: &Extensions) -> bool {
    extensions.get::<MatchedPath>().is_some_and(|path| WATCHING.contains(&path.as_str()))
}

/// The answer to a caller that sends too many requests: counted by key, or by address if no key was accepted.
pub(super) fn turned_away(
    app: &AppState,
    method: &Method,
    extensions: &Extensions,
    key_id: Option<&Arc<str>>,
) -> Option<Response> {
    let rates = app.rates.as_ref()?;
    if is_watching(extensions) {
        return None;
    }
    let wait = rates.admit(asking(extensions, key_id.cloned())).err()?;
    note_refusal(app, Reason::Rate, key_id.map(|id| &**id), method, extensions);
    let rate = app.settings.max_rate_per_s;
    let detail = format!("more than {rate} requests per second from one caller; send them more slowly");
    let mut response = Problem::new(ProblemType::TooManyRequests, detail).into_response();
    let wait_s = wait.as_secs() + u64::from(wait.subsec_nanos() > 0);
    response.headers_mut().insert(RETRY_AFTER, HeaderValue::from(wait_s));
    Some(response)
}

/// The caller: by key, or by address if there is no key.
fn asking(extensions: &Extensions, key_id: Option<Arc<str>>) -> Who {
    let peer = extensions.get::<ConnectInfo<SocketAddr>>();
    key_id.map_or_else(|| peer.map_or(Who::Others, |peer| Who::at(peer.0.ip())), Who::Key)
}

/// The caller of a request that passed the guard.
pub(super) fn asks(request: &Request) -> Who {
    let extensions = request.extensions();
    asking(extensions, RequestFacts::caller_of(extensions).and_then(|caller| caller.key_id.clone()))
}

/// Checks the length of the address, and of all header fields together as they were sent, without the four bytes
/// between them.
fn measured(app: &AppState, request: &Request) -> Result<(), Problem> {
    let uri = request.uri();
    let length = uri.path_and_query().map_or(uri.path().len(), |whole| whole.as_str().len());
    let limit = app.settings.max_url_bytes;
    if length > limit {
        let detail = format!(
            "path and query have {length} bytes, but the limit is {limit}; send long parameters in the body"
        );
        return Err(Problem::new(ProblemType::UrlTooLong, detail));
    }
    let length: usize =
        request.headers().iter().map(|(name, value)| name.as_str().len() + value.len() + 4).sum();
    let limit = app.settings.max_header_bytes;
    if length > limit {
        let detail = format!(
            "the header has {length} bytes, but the limit is {limit}; send fewer or shorter header fields"
        );
        return Err(Problem::new(ProblemType::HeaderTooLarge, detail));
    }
    Ok(())
}
