//! What an HTTP/2 connection has under way, and how long its client keeps it waiting. One socket carries many requests, and
//! pings go to and fro whatever becomes of them: that bytes move says nothing. HTTP/1.1 has a timer of its own for a
//! connection without a request, and a pause of its socket is a pause of its answer.

use std::collections::HashMap;
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

/// Most of an answer that is handed on at a time \[bytes\]: so much may still be on its way when the answer counts as taken.
const PART_BYTES: usize = 16 << 10;

/// Requests of one connection.
#[derive(Debug)]
pub(super) struct Streams {
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// Requests that are not answered to their end.
    open: usize,
    /// Since when there has been none.
    idle_since: Instant,
    /// Answers of which a part was handed on and no other asked for, and since when.
    waiting: HashMap<u64, Instant>,
    /// Number of the next request.
    next: u64,
}

impl Streams {
    pub(super) fn new() -> Arc<Self> {
        let state = State { open: 0, idle_since: Instant::now(), waiting: HashMap::new(), next: 0 };
        Arc::new(Self { state: Mutex::new(state) })
    }

    /// Whether the client has asked for nothing for as long as `idle`, or taken nothing of an answer for as long as `pause`.
    pub(super) fn are_left(&self, idle: Duration, pause: Duration) -> bool {
        let state = self.state();
        let over = |since: &Instant, most: Duration| since.elapsed() >= most;
        if state.open == 0 {
            over(&state.idle_since, idle)
        } else {
            state.waiting.values().any(|since| over(since, pause))
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// One request until its answer has been handed on whole, or it was given up.
#[derive(Debug)]
struct Open {
    streams: Arc<Streams>,
    number: u64,
}

impl Open {
    fn new(streams: &Arc<Streams>) -> Self {
        let mut state = streams.state();
        state.open += 1;
        state.next += 1;
        Self { streams: Arc::clone(streams), number: state.next }
    }

    /// A part was handed on: the client is waited for from now on.
    fn handed_on(&self) {
        self.streams.state().waiting.insert(self.number, Instant::now());
    }

    /// The client has taken what there was and waits for more.
    fn is_awaited(&self) {
        self.streams.state().waiting.remove(&self.number);
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        let mut state = self.streams.state();
        state.waiting.remove(&self.number);
        state.open -= 1;
        if state.open == 0 {
            state.idle_since = Instant::now();
        }
    }
}

/// The service of one connection, which follows its requests where they come by HTTP/2.
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
    /// Of what the body gave last.
    left: Bytes,
    open: Open,
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
            this.open.is_awaited();
            match Pin::new(&mut this.body).poll_frame(cx) {
                Poll::Ready(Some(Ok(frame))) => match frame.into_data() {
                    Ok(data) => this.left = data,
                    Err(trailers) => return Poll::Ready(Some(Ok(trailers))),
                },
                other => return other,
            }
        }
        this.open.handed_on();
        let part = this.left.split_to(this.left.len().min(PART_BYTES));
        Poll::Ready(Some(Ok(Frame::data(part))))
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
