//! Bodies, chunk by chunk: bounded in length and in the pauses between chunks.

use std::borrow::Cow;
use std::error::Error;
use std::pin::Pin;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

use axum::body::{Body, BodyDataStream, HttpBody};
use bytes::{Bytes, BytesMut};
use futures::stream::{self, Fuse, Stream, StreamExt};
use http::HeaderMap;
use http::header::{CONTENT_ENCODING, CONTENT_LENGTH, CONTENT_TYPE};
use http_body_util::BodyExt;
use thiserror::Error;

use super::coding::CodingFault;
use super::problem::{Problem, ProblemType};
use super::within::within;
use crate::jobs::memory::{self, MemoryFault};

/// A body being read.
pub(super) struct Incoming {
    body: Body,
    pause: Duration,
}

/// Knows when a form's reader is between two fields, and holds the part of the body that the reader has not read.
#[derive(Debug)]
pub(super) struct BetweenFields {
    left: Arc<AtomicUsize>,
    header_bytes: usize,
    chunks: Arc<Mutex<Fuse<BodyDataStream>>>,
}

/// Within a field, the field's own limit applies.
const UNBOUNDED: usize = usize::MAX;

impl BetweenFields {
    /// The reader starts to look for the next field.
    pub(super) fn enter(&self) {
        self.left.store(self.header_bytes, Ordering::Relaxed);
    }

    /// The reader has found the next field.
    pub(super) fn leave(&self) {
        self.left.store(UNBOUNDED, Ordering::Relaxed);
    }

    /// Reads from the end of the form to the end of the body: nothing more may come, except the end of a compressed
    /// body.
    ///
    /// # Errors
    /// There are more bytes, or the end is damaged or missing.
    pub(super) async fn end(&self, pause: Duration) -> Result<(), Problem> {
        let mut left = self.header_bytes;
        loop {
            let next = std::future::poll_fn(|context| next_of(&self.chunks, context));
            match next_within(next, pause).await? {
                None => return Ok(()),
                Some(Err(fault)) => return Err(broken(&fault)),
                Some(Ok(chunk)) if chunk.len() <= left => left -= chunk.len(),
                Some(Ok(_)) => {
                    let limit = self.header_bytes;
                    let detail = format!(
                        "more than {limit} bytes come after the form; end the body with its last boundary"
                    );
                    return Err(Problem::new(ProblemType::MalformedRequest, detail));
                }
            }
        }
    }

    /// Continues to read like [`Incoming::swallow`], after the form's reader has stopped.
    pub(super) async fn swallow(&self) {
        swallowed(stream::poll_fn(|context| next_of(&self.chunks, context))).await;
    }
}

/// Takes all items that come within a moment. The content of a small compressed body is always ready, so other tasks
/// get their turn between two items.
async fn swallowed<T, E>(mut rest: impl Stream<Item = Result<T, E>> + Unpin) {
    let end = Instant::now() + SWALLOW;
    while let Some(left) = end.checked_duration_since(Instant::now()) {
        match tokio::time::timeout(left, rest.next()).await {
            Ok(Some(Ok(_))) => tokio::task::yield_now().await,
            _ => return,
        }
    }
}

/// The next item, if it comes in time.
async fn next_within<T>(next: impl Future<Output = T>, pause: Duration) -> Result<T, Problem> {
    within(pause, next).await.ok_or_else(|| too_slow(pause))
}

fn next_of(
    chunks: &Mutex<Fuse<BodyDataStream>>,
    context: &mut Context<'_>,
) -> Poll<Option<Result<Bytes, axum::Error>>> {
    chunks.lock().unwrap_or_else(PoisonError::into_inner).poll_next_unpin(context)
}

/// The bytes between two fields of a form exceed the limit of a header.
#[derive(Debug, Clone, Copy, Error)]
#[error("the header of a field is too long")]
struct FieldHeaderTooLong;

/// A text that is collected reserves memory in steps of this size. Its first step is part of what every request
/// reserves \[bytes\].
const PAID_AT_ONCE: u64 = 64 << 10;

/// The memory that a text has reserved so far while it arrives.
#[derive(Debug, Default)]
pub(super) struct PaidAsItGrows {
    /// Bytes of the text beyond its first step.
    bytes: u64,
}

impl PaidAsItGrows {
    /// Reserves memory before the text has `length` bytes.
    ///
    /// # Errors
    /// There is no memory for it.
    pub(super) fn grow_to(&mut self, length: usize) -> Result<(), MemoryFault> {
        while length as u64 > PAID_AT_ONCE + self.bytes {
            // Twice the length, because a growing text is doubled and moved.
            memory::keep(2 * PAID_AT_ONCE)?;
            self.bytes += PAID_AT_ONCE;
        }
        Ok(())
    }
}

/// How long the rest of a refused body is still read, so that the client gets to read the refusal.
const SWALLOW: Duration = Duration::from_secs(1);

impl Incoming {
    /// A body with at most `pause_s` between two chunks.
    pub(super) fn new(body: Body, pause_s: f64) -> Self {
        Self { body, pause: Duration::from_secs_f64(pause_s) }
    }

    /// The next chunk.
    pub(super) async fn next(&mut self) -> Result<Option<Bytes>, Problem> {
        loop {
            if self.body.is_end_stream() {
                return Ok(None);
            }
            match next_within(self.body.frame(), self.pause).await? {
                None => return Ok(None),
                Some(Err(fault)) => {
                    let refusal = broken(&fault);
                    if refusal.kind() == ProblemType::BodyTooLarge {
                        Box::pin(self.swallow()).await;
                    }
                    return Err(refusal);
                }
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
        // Boxed: a refusal is rare, and otherwise every request would have the memory for it.
        let announced = content_length(headers);
        if announced.is_some_and(|length| length > limit) {
            return Err(Box::pin(self.refuse_length(limit)).await);
        }
        // A small body comes in one chunk, which is used as it is.
        let mut first = Bytes::new();
        let mut whole = BytesMut::new();
        let mut paid = PaidAsItGrows::default();
        while let Some(chunk) = self.next().await? {
            if (first.len().max(whole.len()) + chunk.len()) as u64 > limit {
                drop((first, whole));
                return Err(Box::pin(self.refuse_length(limit)).await);
            }
            if first.is_empty() {
                first = chunk;
                continue;
            }
            if whole.is_empty() {
                whole.extend_from_slice(&first);
            }
            if let Err(fault) = paid.grow_to(whole.len() + chunk.len()) {
                drop((first, whole));
                Box::pin(self.swallow()).await;
                return Err(fault.into());
            }
            whole.extend_from_slice(&chunk);
        }
        Ok(if whole.is_empty() { first } else { whole.freeze() })
    }

    /// Refuses a body that is too long, after reading some of the rest.
    pub(super) async fn refuse_length(&mut self, limit: u64) -> Problem {
        self.swallow().await;
        Problem::new(ProblemType::BodyTooLarge, format!("the body is larger than the limit of {limit} bytes"))
    }

    /// Continues to read for a moment and discards the bytes: a client that is still sending does not read the
    /// answer.
    pub(super) async fn swallow(&mut self) {
        swallowed(stream::poll_fn(|context| Pin::new(&mut self.body).poll_frame(context))).await;
    }

    /// The body for a reader that cuts it into fields and keeps the bytes that it cannot cut yet: one chunk at a
    /// time, and between two fields at most about as many bytes as a header may have.
    pub(super) fn into_form(self, header_bytes: usize) -> (Body, BetweenFields) {
        let chunks = Arc::new(Mutex::new(StreamExt::fuse(self.body.into_data_stream())));
        let left = Arc::new(AtomicUsize::new(header_bytes));
        let between = BetweenFields { left: Arc::clone(&left), header_bytes, chunks: Arc::clone(&chunks) };
        let mut rests = false;
        let stream = stream::poll_fn(move |context| {
            // The reader would continue to read as long as bytes arrive.
            if std::mem::take(&mut rests) {
                context.waker().wake_by_ref();
                return Poll::Pending;
            }
            if left.load(Ordering::Relaxed) == 0 {
                return Poll::Ready(Some(Err(axum::Error::new(FieldHeaderTooLong))));
            }
            let next = next_of(&chunks, context);
            if let Poll::Ready(Some(Ok(chunk))) = &next {
                rests = true;
                let taken = |left: usize| (left != UNBOUNDED).then(|| left.saturating_sub(chunk.len()));
                let _changed = left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, taken);
            }
            next
        });
        (Body::from_stream(stream), between)
    }
}

/// Number of bytes that the header announces, if it counts the content itself.
pub(super) fn content_length(headers: &HeaderMap) -> Option<u64> {
    if headers.contains_key(CONTENT_ENCODING) {
        return None;
    }
    headers.get(CONTENT_LENGTH)?.to_str().ok()?.parse().ok()
}

/// The content type of most bodies, recognised before it is taken apart.
const JSON: &str = "application/json";

/// Essence of the content type, lower case: `text/csv` for `Text/CSV; charset=utf-8`.
pub(super) fn media_type(headers: &HeaderMap) -> Option<Cow<'_, str>> {
    let value = headers.get(CONTENT_TYPE)?;
    if value == JSON {
        return Some(JSON.into());
    }
    let essence = value.to_str().unwrap_or("unreadable/unreadable").split(';').next()?.trim();
    if essence.bytes().any(|byte| byte.is_ascii_uppercase()) {
        return Some(essence.to_ascii_lowercase().into());
    }
    (!essence.is_empty()).then_some(essence.into())
}

fn too_slow(pause: Duration) -> Problem {
    let detail = format!("no byte of the body arrived for {} s; send the request again", pause.as_secs_f64());
    Problem::new(ProblemType::RequestTimeout, detail)
}

/// The refusal of a body that does not arrive completely.
fn broken(fault: &axum::Error) -> Problem {
    tracing::debug!(error = %fault, "a body broke off");
    unreadable(fault).unwrap_or_else(|| Problem::new(ProblemType::MalformedRequest, "the body ends early"))
}

/// The refusal of a body that cannot be decompressed, if that was the cause.
pub(super) fn unreadable(fault: &(dyn Error + 'static)) -> Option<Problem> {
    CodingFault::within(fault).map(|fault| Problem::from(*fault))
}
