//! Ends connections that send nothing. The first bytes of a client show which protocol it uses. Until then no timer
//! of a protocol runs, and a client that sends no byte, or only the start of HTTP/2's preface, would hold its place
//! for ever. So would an HTTP/2 client that sends no request, or takes nothing of its answers.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use axum_server::accept::Accept;
use futures::future::BoxFuture;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep, sleep};

use super::streams::{Followed, Streams};

/// The first bytes that an HTTP/2 client sends (RFC 9113 §3.4).
const PREFACE: &[u8] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
/// How often an HTTP/2 connection is checked within the shorter of its times: it may stay longer by this part.
const LOOKS: u32 = 8;

/// How long the service waits for a client.
#[derive(Debug, Clone, Copy)]
pub struct Patience {
    /// For the first bytes; with HTTP/2 also for any byte while no request is open.
    pub silence: Duration,
    /// With HTTP/2: for the client to take some of an answer.
    pub answer_pause: Duration,
}

/// Accepts what another acceptor accepts, waits only a limited time until the protocol is known, and ends HTTP/2
/// connections that the client has left.
#[derive(Debug, Clone)]
pub struct FirstBytes<A> {
    inner: A,
    patience: Patience,
}

impl<A> FirstBytes<A> {
    /// Waits as long as `patience` says.
    #[must_use]
    pub fn within(patience: Patience, inner: A) -> Self {
        Self { inner, patience }
    }
}

impl<A, I, S> Accept<I, S> for FirstBytes<A>
where
    A: Accept<I, S>,
    A::Future: Send + 'static,
{
    type Stream = Heard<A::Stream>;
    type Service = Followed<A::Service>;
    type Future = BoxFuture<'static, io::Result<(Self::Stream, Self::Service)>>;

    fn accept(&self, stream: I, service: S) -> Self::Future {
        let (accepted, patience) = (self.inner.accept(stream, service), self.patience);
        Box::pin(async move {
            let (stream, service) = accepted.await?;
            let streams = Streams::new();
            let end = Box::pin(sleep(patience.silence));
            let heard = Heard {
                stream,
                patience,
                streams: Arc::clone(&streams),
                spoken: Spoken::Unknown { matched: 0, end },
            };
            Ok((heard, Followed::new(service, streams)))
        })
    }
}

/// A connection whose traffic is watched.
#[derive(Debug)]
pub struct Heard<T> {
    stream: T,
    patience: Patience,
    streams: Arc<Streams>,
    spoken: Spoken,
}

/// The protocol, as far as it is known.
#[derive(Debug)]
enum Spoken {
    /// This many bytes match the preface so far; and the time at which the wait ends.
    Unknown { matched: usize, end: Pin<Box<Sleep>> },
    /// HTTP/1.1, which has its own timers.
    One,
    /// HTTP/2, and the time of the next check.
    Two { look: Pin<Box<Sleep>> },
}

impl<T> Heard<T> {
    /// Checks the bytes that have arrived: the protocol is known with the first byte that is not the preface's, or
    /// with the whole preface.
    fn hear(&mut self, bytes: &[u8]) {
        let Spoken::Unknown { matched, .. } = &mut self.spoken else { return };
        let left = PREFACE.get(*matched..).unwrap_or_default();
        let same = left.iter().zip(bytes).take_while(|(one, other)| one == other).count();
        *matched += same;
        if *matched == PREFACE.len() {
            self.spoken = Spoken::Two { look: Box::pin(sleep(self.pause_of_looks())) };
        } else if same < bytes.len() {
            self.spoken = Spoken::One;
        }
    }

    fn pause_of_looks(&self) -> Duration {
        self.patience.silence.min(self.patience.answer_pause) / LOOKS
    }

    /// Whether the service stops waiting for the client.
    fn is_left(&mut self, cx: &mut Context<'_>) -> bool {
        let (pause, patience) = (self.pause_of_looks(), self.patience);
        match &mut self.spoken {
            Spoken::Unknown { end, .. } => end.as_mut().poll(cx).is_ready(),
            Spoken::One => false,
            Spoken::Two { look } => {
                while look.as_mut().poll(cx).is_ready() {
                    if self.streams.are_left(patience.silence, patience.answer_pause) {
                        return true;
                    }
                    look.as_mut().reset(Instant::now() + pause);
                }
                false
            }
        }
    }
}

impl<T: AsyncRead + Unpin> AsyncRead for Heard<T> {
    fn poll_read(self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let this = self.get_mut();
        let before = buf.filled().len();
        let read = Pin::new(&mut this.stream).poll_read(cx, buf);
        if read.is_pending() && this.is_left(cx) {
            return Poll::Ready(Err(io::ErrorKind::TimedOut.into()));
        }
        let came = buf.filled().get(before..).unwrap_or_default();
        match this.spoken {
            Spoken::Unknown { .. } => this.hear(came),
            Spoken::Two { .. } if !came.is_empty() => this.streams.hear(),
            Spoken::One | Spoken::Two { .. } => {}
        }
        read
    }
}

impl<T: AsyncWrite + Unpin> AsyncWrite for Heard<T> {
    fn poll_write(self: Pin<&mut Self>, cx: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.get_mut().stream).poll_write(cx, bytes)
    }

    fn poll_flush(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().stream).poll_flush(cx)
    }

    fn poll_shutdown(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().stream).poll_shutdown(cx)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_write_vectored(
        self: Pin<&mut Self>,
        cx: &mut Context<'_>,
        bufs: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.get_mut().stream).poll_write_vectored(cx, bufs)
    }
}
