//! The open requests of an HTTP/2 connection, and how long its client keeps it waiting. One socket carries many
//! requests, and bytes move on it whatever happens to a single request: a stream's window stays closed for as long as
//! its client wants. HTTP/1.1 has its own timer for a connection without a request, and there a pause of the socket
//! is a pause of the answer.

use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::Duration;

use axum::body::{Body, Bytes, HttpBody};
use axum::response::Response;
use futures::future::{BoxFuture, Either};
use http::{Request, Version};
use hyper::body::{Frame, SizeHint};
use tokio::time::Instant;
use tower::Service;

/// Most bytes of an answer that are handed on at a time \[bytes\]: the client must take them within the pause.
const PART_BYTES: usize = 16 << 10;

/// Requests of one connection.
#[derive(Debug)]
pub(super) struct Streams {
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// Requests whose answer is not complete.
    open: usize,
    /// Parts of answers that were handed on and are not yet on the socket.
    parts: usize,
    /// Time of the last received bytes.
    heard: Instant,
    /// Time when a part last reached the socket, or when the first of the present parts was handed on, or when the
    /// last request ended.
    moved: Instant,
}

impl Streams {
    pub(super) fn new() -> Arc<Self> {
        let now = Instant::now();
        Arc::new(Self { state: Mutex::new(State { open: 0, parts: 0, heard: now, moved: now }) })
    }

    /// Bytes were received.
    pub(super) fn hear(&self) {
        self.state().heard = Instant::now();
    }

    /// Whether the client has sent nothing for `idle` without an open request, or has taken nothing of its answers
    /// for `pause`. The answers share the line: as long as one of them moves, the client has not left.
    pub(super) fn are_left(&self, idle: Duration, pause: Duration) -> bool {
        let state = self.state();
        if state.open == 0 {
            state.moved.max(state.heard).elapsed() >= idle
        } else {
            state.parts > 0 && state.moved.elapsed() >= pause
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// One request, until its whole answer is on the socket, or until it was given up.
#[derive(Debug)]
struct Open {
    streams: Arc<Streams>,
}

impl Open {
    fn new(streams: &Arc<Streams>) -> Arc<Self> {
        streams.state().open += 1;
        Arc::new(Self { streams: Arc::clone(streams) })
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        let mut state = self.streams.state();
        state.open -= 1;
        state.moved = Instant::now();
    }
}

/// A part of an answer. It ends when it was written to the socket, or with its stream.
#[derive(Debug)]
struct Part {
    bytes: Bytes,
    open: Arc<Open>,
}

impl Part {
    fn new(bytes: Bytes, open: &Arc<Open>) -> Self {
        let mut state = open.streams.state();
        if state.parts == 0 {
            state.moved = Instant::now();
        }
        state.parts += 1;
        drop(state);
        Self { bytes, open: Arc::clone(open) }
    }
}

impl AsRef<[u8]> for Part {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        let mut state = self.open.streams.state();
        state.parts -= 1;
        state.moved = Instant::now();
    }
}

/// The service of one connection; it follows the requests if they come by HTTP/2.
#[derive(Debug, Clone)]
pub struct Followed<S> {
    service: S,
    streams: Arc<Streams>,
}

impl<S> Followed<S> {
    pub(super) fn new(service: S, streams: Arc<Streams>) -> Self {
        Self { service, streams }
    }
}

impl<S, B> Service<Request<B>> for Followed<S>
where
    S: Service<Request<B>, Response = Response>,
    S::Future: Send + 'static,
{
    type Response = Response;
    type Error = S::Error;
    type Future = Either<S::Future, BoxFuture<'static, Result<Response, S::Error>>>;

    fn poll_ready(&mut self, cx: &mut Context<'_>) -> Poll<Result<(), S::Error>> {
        self.service.poll_ready(cx)
    }

    fn call(&mut self, request: Request<B>) -> Self::Future {
        if request.version() != Version::HTTP_2 {
            return Either::Left(self.service.call(request));
        }
        let open = Open::new(&self.streams);
        let answered = self.service.call(request);
        Either::Right(Box::pin(async move {
            let answer = answered.await?;
            Ok(answer.map(|body| Body::new(Answer { body, left: Bytes::new(), open })))
        }))
    }
}

/// The body of an answer, in parts.
#[derive(Debug)]
struct Answer {
    body: Body,
    /// The rest of the body's last chunk.
    left: Bytes,
    open: Arc<Open>,
}

impl HttpBody for Answer {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        let this = self.get_mut();
        if this.left.is_empty() {
            match Pin::new(&mut this.body).poll_frame(cx) {
                Poll::Ready(Some(Ok(frame))) => match frame.into_data() {
                    Ok(data) => this.left = data,
                    Err(trailers) => return Poll::Ready(Some(Ok(trailers))),
                },
                other => return other,
            }
        }
        let bytes = this.left.split_to(this.left.len().min(PART_BYTES));
        Poll::Ready(Some(Ok(Frame::data(Bytes::from_owner(Part::new(bytes, &this.open))))))
    }

    fn is_end_stream(&self) -> bool {
        self.left.is_empty() && self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        let (left, inner) = (self.left.len() as u64, self.body.size_hint());
        let mut hint = SizeHint::new();
        hint.set_lower(inner.lower() + left);
        if let Some(upper) = inner.upper() {
            hint.set_upper(upper + left);
        }
        hint
    }
}
