//! The Idempotency-Key of a request that stores something.

use http::request::Parts;

use super::AppState;
use super::caller::Caller;
use super::problem::{Problem, ProblemType};
use crate::jobs::timestamp;
use crate::store::{JobRow, KeyUse, Remembered, sha256_hex};

/// Longest key taken (bytes).
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
            format!("Idempotency-Key is not one text of 1 to {MAX_KEY_BYTES} visible ASCII characters");
        return Err(Problem::new(ProblemType::MalformedRequest, detail));
    }
    Ok(Some(text.to_owned()))
}

/// The key with the digest of all that makes the request: method, path, query and what its body says. Every API key has
/// idempotency keys of its own, so that nobody is answered what another was.
pub(super) fn used(app: &AppState, parts: &Parts, key: Option<String>, body: &[&str]) -> Option<KeyUse> {
    let mut key = key?;
    if let Some(id) = parts.extensions.get::<Caller>().and_then(|caller| caller.key_id.as_ref()) {
        // No client can send a tab.
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

/// What a request under this key was answered with before.
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

/// What is missing is said at once to a request without a key. Under a key the same request may have been answered before
/// it went missing: it is said when no answer is remembered.
pub(super) fn unless_keyed<T>(
    key: Option<&String>,
    found: Result<T, Problem>,
) -> Result<Result<T, Problem>, Problem> {
    match (key, found) {
        (None, Err(missing)) => Err(missing),
        (_, found) => Ok(found),
    }
}

/// The job that a request under this key has already made.
///
/// # Errors
/// The key was used for another request.
pub(super) async fn remembered(app: &AppState, used: Option<&KeyUse>) -> Result<Option<JobRow>, Problem> {
    match answered(app, used).await? {
        Some(Remembered::Job(job)) => Ok(Some(*job)),
        None => Ok(None),
        // The fingerprint names method and path, so the same request never has an answer of another kind.
        Some(_) => Err(key_reused()),
    }
}

/// The refusal of a key that stands for something else.
pub(super) fn key_reused() -> Problem {
    let detail = "the Idempotency-Key was first used for another request";
    Problem::new(ProblemType::KeyReused, detail)
}
