//! An end for connections that say nothing. Which protocol a client speaks is told by its first bytes; until then no
//! timer of a protocol runs, and who sends no byte, or the first of HTTP/2's preface alone, would hold its place for ever.

use std::io;
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use axum_server::accept::Accept;
use futures::future::BoxFuture;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::Sleep;

/// What an HTTP/2 client sends first (RFC 9113 §3.4).
const PREFACE: &[u8] = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

/// Accepts what another acceptor does, and waits only so long until it is known which protocol is spoken.
#[derive(Debug, Clone)]
pub struct FirstBytes<A> {
    inner: A,
    patience: Duration,
}

impl<A> FirstBytes<A> {
    /// Waits as long as `patience`.
    #[must_use]
    pub fn within(patience: Duration, inner: A) -> Self {
        Self { inner, patience }
    }
}

impl<A, I, S> Accept<I, S> for FirstBytes<A>
where
    A: Accept<I, S>,
    A::Future: Send + 'static,
{
    type Stream = Heard<A::Stream>;
    type Service = A::Service;
    type Future = BoxFuture<'static, io::Result<(Self::Stream, Self::Service)>>;

    fn accept(&self, stream: I, service: S) -> Self::Future {
        let (accepted, patience) = (self.inner.accept(stream, service), self.patience);
        Box::pin(async move {
            let (stream, service) = accepted.await?;
            let end = Some(Box::pin(tokio::time::sleep(patience)));
            Ok((Heard { stream, matched: 0, end }, service))
        })
    }
}

/// A connection whose first bytes are waited for.
#[derive(Debug)]
pub struct Heard<T> {
    stream: T,
    /// Bytes so far that are those of the preface.
    matched: usize,
    /// Runs until it is known which protocol is spoken.
    end: Option<Pin<Box<Sleep>>>,
}

impl<T> Heard<T> {
    /// Looks at what has arrived: the protocol is known with the first byte that is not the preface's, or with all of it.
    fn hear(&mut self, bytes: &[u8]) {
        let left = PREFACE.get(self.matched..).unwrap_or_default();
        let same = left.iter().zip(bytes).take_while(|(one, other)| one == other).count();
        self.matched += same;
        if same < bytes.len() || self.matched == PREFACE.len() {
            self.end = None;
        }
    }
}

impl<T: AsyncRead + Unpin> AsyncRead for Heard<T> {
    fn poll_read(self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let this = self.get_mut();
        let before = buf.filled().len();
        let read = Pin::new(&mut this.stream).poll_read(cx, buf);
        let Some(end) = &mut this.end else { return read };
        if read.is_pending() {
            return end.as_mut().poll(cx).map(|()| Err(io::ErrorKind::TimedOut.into()));
        }
        this.hear(buf.filled().get(before..).unwrap_or_default());
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
