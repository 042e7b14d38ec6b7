//! Bodies, chunk by chunk: bounded in length and in the pauses between chunks.

use std::time::{Duration, Instant};

use axum::body::Body;
use bytes::{Bytes, BytesMut};
use http::HeaderMap;
use http::header::{CONTENT_ENCODING, CONTENT_LENGTH, CONTENT_TYPE};
use http_body_util::BodyExt;

use super::problem::{Problem, ProblemType};

/// A body being read.
pub(super) struct Incoming {
    body: Body,
    pause: Duration,
}

/// How long a refused body is still swallowed, so that the client gets to read the refusal.
const SWALLOW: Duration = Duration::from_secs(1);

impl Incoming {
    /// A body of which no two chunks may be further apart than `pause_s`.
    pub(super) fn new(body: Body, pause_s: f64) -> Self {
        Self { body, pause: Duration::from_secs_f64(pause_s) }
    }

    /// The next chunk.
    pub(super) async fn next(&mut self) -> Result<Option<Bytes>, Problem> {
        loop {
            let frame = tokio::time::timeout(self.pause, self.body.frame()).await;
            match frame.map_err(|_elapsed| too_slow(self.pause))? {
                None => return Ok(None),
                Some(Err(fault)) => return Err(broken(&fault)),
                Some(Ok(frame)) => {
                    if let Ok(bytes) = frame.into_data()
                        && !bytes.is_empty()
                    {
                        return Ok(Some(bytes));
                    }
                }
            }
        }
    }

    /// The whole body.
    pub(super) async fn whole(&mut self, headers: &HeaderMap, limit: u64) -> Result<Bytes, Problem> {
        let announced = content_length(headers);
        let mut whole = BytesMut::new();
        if announced.is_some_and(|length| length > limit) {
            return Err(self.refuse_length(limit).await);
        }
        while let Some(chunk) = self.next().await? {
            if (whole.len() + chunk.len()) as u64 > limit {
                drop(whole);
                return Err(self.refuse_length(limit).await);
            }
            whole.extend_from_slice(&chunk);
        }
        Ok(whole.freeze())
    }

    /// Refuses a body that is too long, after swallowing some of the rest.
    pub(super) async fn refuse_length(&mut self, limit: u64) -> Problem {
        self.swallow().await;
        Problem::new(ProblemType::BodyTooLarge, format!("the body is larger than {limit} bytes"))
    }

    /// Reads on for a moment and drops what comes: a client that is still sending does not read the answer.
    pub(super) async fn swallow(&mut self) {
        let end = Instant::now() + SWALLOW;
        while let Some(left) = end.checked_duration_since(Instant::now()) {
            match tokio::time::timeout(left, self.body.frame()).await {
                Ok(Some(Ok(_))) => {}
                _ => return,
            }
        }
    }

    /// The body itself, for a reader that cuts it into fields.
    pub(super) fn into_body(self) -> Body {
        self.body
    }
}

/// Bytes that the header announces, where they are those of the content itself.
pub(super) fn content_length(headers: &HeaderMap) -> Option<u64> {
    if headers.contains_key(CONTENT_ENCODING) {
        return None;
    }
    headers.get(CONTENT_LENGTH)?.to_str().ok()?.parse().ok()
}

/// Essence of the content type, lower case: `text/csv` for `Text/CSV; charset=utf-8`.
pub(super) fn media_type(headers: &HeaderMap) -> Option<String> {
    let value = headers.get(CONTENT_TYPE)?;
    let essence = value.to_str().unwrap_or("unreadable/unreadable").split(';').next()?.trim();
    if essence.is_empty() { None } else { Some(essence.to_ascii_lowercase()) }
}

fn too_slow(pause: Duration) -> Problem {
    let detail = format!("no byte of the body arrived for {} s", pause.as_secs_f64());
    Problem::new(ProblemType::RequestTimeout, detail)
}

fn broken(fault: &axum::Error) -> Problem {
    tracing::debug!(error = %fault, "a body broke off");
    Problem::new(ProblemType::MalformedRequest, "the body ends early or cannot be decompressed")
}
