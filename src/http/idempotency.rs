//! The Idempotency-Key of a request that stores something.

use http::request::Parts;

use super::AppState;
use super::problem::{Problem, ProblemType};
use super::request_facts::RequestFacts;
use crate::jobs::timestamp;
use crate::store::{JobRow, KeyUse, Remembered, sha256_hex};

/// Longest key that is accepted (bytes).
const MAX_KEY_BYTES: usize = 255;

/// The key of a request, if it has one, before its body is known.
pub(super) fn key(parts: &Parts) -> Result<Option<String>, Problem> {
    let mut values = parts.headers.get_all("idempotency-key").iter();
    let Some(value) = values.next() else { return Ok(None) };
    let text = value.to_str().unwrap_or_default().trim();
    let sound = !text.is_empty()
        && text.len() <= MAX_KEY_BYTES
        && text.bytes().all(|b| b.is_ascii_graphic() || b == b' ');
    if !sound || values.next().is_some() {
        let detail =
            format!("Idempotency-Key must be one text of 1 to {MAX_KEY_BYTES} visible ASCII characters");
        return Err(Problem::new(ProblemType::MalformedRequest, detail));
    }
    Ok(Some(text.to_owned()))
}

/// The key with the digest of everything that makes the request: method, path, query and content of the body. Every
/// API key has idempotency keys of its own, so that no caller gets the answer of another.
pub(super) fn used(app: &AppState, parts: &Parts, key: Option<String>, body: &[&str]) -> Option<KeyUse> {
    let mut key = key?;
    if let Some(id) = RequestFacts::caller_of(&parts.extensions).and_then(|caller| caller.key_id.as_ref()) {
        // A client cannot send a tab.
        key = format!("{id}\t{}", sha256_hex(key.as_bytes()));
    }
    let uri = &parts.uri;
    let head = format!("{}\n{}\n{}\n", parts.method, uri.path(), uri.query().unwrap_or_default());
    let fingerprint = sha256_hex((head + &body.join("\n")).as_bytes());
    Some(KeyUse {
        key,
        fingerprint,
        since: app.sources.timestamp_before(app.settings.idempotency_retention_s),
        farthest: app.sources.farthest(app.settings.idempotency_retention_s),
        not_before: timestamp(app.sources.clock.passed()),
    })
}

/// The key of one part of a request that stores several things. The first part has the key of the request, so that a
/// key that another request used is refused.
pub(super) fn key_of_part(used: Option<&KeyUse>, part: usize) -> Option<KeyUse> {
    let mut used = used?.clone();
    if part > 0 {
        // A client cannot send a tab. A key may be as long as the store takes.
        used.key = format!("{}\t{part}", sha256_hex(used.key.as_bytes()));
    }
    Some(used)
}

/// The earlier answer to a request with this key.
///
/// # Errors
/// The key was used for another request.
pub(super) async fn answered(app: &AppState, used: Option<&KeyUse>) -> Result<Option<Remembered>, Problem> {
    let Some(used) = used else { return Ok(None) };
    match app.store.remembered(used).await? {
        Some(Remembered::Other) => Err(key_reused()),
        other => Ok(other),
    }
}

/// Reports a missing resource at once if the request has no key. With a key, the same request may have been answered
/// before the resource was deleted; the fault is then reported only if no answer is remembered.
pub(super) fn unless_keyed<T>(
    key: Option<&String>,
    found: Result<T, Problem>,
) -> Result<Result<T, Problem>, Problem> {
    match (key, found) {
        (None, Err(missing)) => Err(missing),
        (_, found) => Ok(found),
    }
}

/// The job that a request with this key has already created.
///
/// # Errors
/// The key was used for another request.
pub(super) async fn remembered(app: &AppState, used: Option<&KeyUse>) -> Result<Option<JobRow>, Problem> {
    match answered(app, used).await? {
        Some(Remembered::Job(job)) => Ok(Some(*job)),
        None => Ok(None),
        // The fingerprint contains method and path, so the same request never has an answer of another kind.
        Some(_) => Err(key_reused()),
    }
}

/// The refusal of a key that belongs to another request.
pub(super) fn key_reused() -> Problem {
    let detail = "the Idempotency-Key was first used for another request; send a new key";
    Problem::new(ProblemType::KeyReused, detail)
}
