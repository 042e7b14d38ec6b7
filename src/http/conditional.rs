//! Entity tags and the conditions built from them (RFC 9110 §13).

use axum::response::{IntoResponse, Response};
use http::header::{ETAG, IF_MATCH, IF_NONE_MATCH};
use http::{HeaderMap, HeaderName, HeaderValue, StatusCode};

use super::extract::Json;
use super::idempotency::key_reused;
use super::problem::{Problem, ProblemType};
use crate::store::{Expected, Revision, Stale, ToolRevision};

/// Digits of the digest in a revision's tag.
const DIGEST_DIGITS: usize = 16;

/// The tag of a machine revision, without quotes.
pub(super) fn machine_tag(revision: &Revision) -> String {
    revision_tag(revision.document.revision, &revision.sha256)
}

/// The tag of a tool revision, without quotes.
pub(super) fn tool_tag(revision: &ToolRevision) -> String {
    revision_tag(revision.document.revision, &revision.sha256)
}

fn revision_tag(revision: i64, sha256: &str) -> String {
    format!("r{revision}-{}", sha256.get(..DIGEST_DIGITS).unwrap_or(sha256))
}

/// Puts the tag on a response.
pub(super) fn tagged(tag: &str, response: impl IntoResponse) -> Response {
    let mut response = response.into_response();
    if let Ok(value) = HeaderValue::try_from(format!("\"{tag}\"")) {
        response.headers_mut().insert(ETAG, value);
    }
    response
}

/// The calibration run that the errors of the revision come from.
const CALIBRATION: HeaderName = HeaderName::from_static("trunnion-calibration");

/// A revision as a response; a header names the calibration run that its errors come from, if there is one.
pub(super) fn machine_response(stored: Revision) -> Response {
    let mut response = Json(stored.document).into_response();
    if let Some(id) = stored.calibration_id.and_then(|id| HeaderValue::try_from(id).ok()) {
        response.headers_mut().insert(CALIBRATION, id);
    }
    response
}

/// The response, or 304 if the client already has it.
pub(super) fn unless_known<R: IntoResponse>(
    headers: &HeaderMap,
    tag: &str,
    respond: impl FnOnce() -> R,
) -> Result<Response, Problem> {
    let known = match tags(headers, &IF_NONE_MATCH)? {
        Some(Tags::Any) => true,
        Some(Tags::List(list)) => list.iter().any(|known| known.value == tag),
        None => false,
    };
    Ok(if known { tagged(tag, StatusCode::NOT_MODIFIED) } else { tagged(tag, respond()) })
}

/// The conditions of a request that replaces or deletes a machine or a tool; both, if there are two.
pub(super) fn expected(headers: &HeaderMap) -> Result<Option<Expected>, Problem> {
    // Both are read before either is applied: an unreadable one is always reported.
    let (matching, absent) = (tags(headers, &IF_MATCH)?, tags(headers, &IF_NONE_MATCH)?);
    Ok(match (matching, absent) {
        (Some(Tags::Any), None) => Some(Expected::Any),
        (Some(Tags::Any), Some(Tags::List(not))) => {
            Some(Expected::AnyBut(not.iter().filter_map(ours).collect()))
        }
        (Some(Tags::List(list)), not) => {
            let named: Vec<_> = list.iter().filter(|tag| !tag.weak).filter_map(ours).collect();
            Some(Expected::OneOf(match not {
                None => named,
                Some(Tags::Any) => Vec::new(),
                Some(Tags::List(not)) => {
                    let not: Vec<_> = not.iter().filter_map(ours).collect();
                    named.into_iter().filter(|tag| !not.contains(tag)).collect()
                }
            }))
        }
        // The resource would have to exist and not to exist: that is never true.
        (Some(Tags::Any), Some(Tags::Any)) => Some(Expected::OneOf(Vec::new())),
        (None, Some(Tags::Any)) => Some(Expected::Nothing),
        (None, Some(Tags::List(_)) | None) => None,
    })
}

/// Revision and digest of a tag, if it is a tag of a revision.
fn ours(tag: &Tag) -> Option<(i64, String)> {
    let (revision, digest) = tag.value.strip_prefix('r')?.split_once('-')?;
    let digest = (digest.len() == DIGEST_DIGITS).then(|| digest.to_owned())?;
    Some((revision.parse().ok()?, digest))
}

/// The refusal if a condition about a machine is not met.
pub(super) fn stale(reason: Stale, machine_id: &str) -> Problem {
    stale_thing(reason, "machine", machine_id)
}

/// The refusal if a condition about a tool is not met.
pub(super) fn stale_tool(reason: Stale, tool_id: &str) -> Problem {
    stale_thing(reason, "tool", tool_id)
}

fn stale_thing(stale: Stale, what: &str, id: &str) -> Problem {
    match stale {
        Stale::Unconditional => Problem::new(
            ProblemType::PreconditionRequired,
            format!("{what} {id:?} exists; send If-Match with the ETag of the revision to replace"),
        ),
        Stale::Changed => Problem::new(
            ProblemType::PreconditionFailed,
            format!("{what} {id:?} has another revision than the condition allows; read it again"),
        ),
        Stale::Missing => Problem::new(
            ProblemType::PreconditionFailed,
            format!("{what} {id:?} does not exist, so If-Match cannot match"),
        ),
        Stale::KeyTaken => key_reused(),
    }
}

struct Tag {
    weak: bool,
    value: String,
}

enum Tags {
    Any,
    List(Vec<Tag>),
}

fn tags(headers: &HeaderMap, name: &HeaderName) -> Result<Option<Tags>, Problem> {
    let refuse = || {
        let detail = format!("{name} is neither * nor a list of entity tags in double quotes");
        Problem::new(ProblemType::MalformedRequest, detail)
    };
    let mut list = Vec::new();
    let mut any = false;
    for value in headers.get_all(name) {
        let mut rest = value.to_str().map_err(|_not_text| refuse())?.trim();
        if rest == "*" {
            any = true;
            continue;
        }
        while !rest.is_empty() {
            let weak = rest.strip_prefix("W/");
            let (inner, after) = weak
                .unwrap_or(rest)
                .strip_prefix('"')
                .and_then(|text| text.split_once('"'))
                .ok_or_else(refuse)?;
            list.push(Tag { weak: weak.is_some(), value: inner.to_owned() });
            let after = after.trim_start();
            rest = match after.strip_prefix(',') {
                Some(next) => next.trim_start(),
                None if after.is_empty() => after,
                None => return Err(refuse()),
            };
        }
    }
    match (any, list.is_empty()) {
        (true, true) => Ok(Some(Tags::Any)),
        (true, false) => Err(refuse()),
        (false, true) if headers.contains_key(name) => Err(refuse()),
        (false, true) => Ok(None),
        (false, false) => Ok(Some(Tags::List(list))),
    }
}
