//! A limit on open connections: a further one is closed at once, before a byte of it is read. A connection also ends
//! if its client takes nothing of its answer.

use std::io;
use std::pin::Pin;
use std::task::{Context, Poll};
use std::time::Duration;

use axum_server::accept::Accept;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::Sleep;

use crate::meter::{self, Entered};
use crate::shares::{Held, Quota, Share, Shares, Who};

/// Accepts connections up to a limit.
#[derive(Debug, Clone)]
pub struct Cap {
    places: Shares,
    pause: Duration,
}

impl Cap {
    /// At most `connections` at a time, of which one address may have a share. A connection is closed if its client
    /// takes nothing of its answer for `pause`.
    #[must_use]
    pub fn new(connections: usize, share: Share, pause: Duration) -> Self {
        Self { places: Shares::new(Quota::Connections, connections as u64, share), pause }
    }
}

/// A connection that holds its place.
#[derive(Debug)]
pub struct Placed {
    /// The place becomes free before the client can see the end.
    _place: Held,
    stream: TcpStream,
    pause: Duration,
    /// Runs while the client takes nothing.
    stalled: Option<Pin<Box<Sleep>>>,
    _open: Entered<'static>,
}

impl Placed {
    fn new(stream: TcpStream, pause: Duration, place: Held) -> Self {
        Self { stream, pause, stalled: None, _place: place, _open: meter::CONNECTIONS.enter() }
    }

    /// The result of a write; a pause that is too long is a fault.
    fn written(&mut self, cx: &mut Context<'_>, written: Poll<io::Result<usize>>) -> Poll<io::Result<usize>> {
        if let Poll::Ready(written) = written {
            self.stalled = None;
            if let Ok(count) = written {
                meter::BYTES_OUT.add(count as u64);
            }
            return Poll::Ready(written);
        }
        let pause = self.pause;
        let stalled = self.stalled.get_or_insert_with(|| Box::pin(tokio::time::sleep(pause)));
        stalled.as_mut().poll(cx).map(|()| Err(io::ErrorKind::TimedOut.into()))
    }
}

impl<S> Accept<TcpStream, S> for Cap {
    type Stream = Placed;
    type Service = S;
    type Future = std::future::Ready<io::Result<(Placed, S)>>;

    fn accept(&self, stream: TcpStream, service: S) -> Self::Future {
        let who = stream.peer_addr().map_or(Who::Others, |peer| Who::at(peer.ip()));
        let accepted = match self.places.take(&who, 1) {
            Ok(place) => stream.set_nodelay(true).map(|()| (Placed::new(stream, self.pause, place), service)),
            Err(refused) => Err(io::Error::other(refused)),
        };
        std::future::ready(accepted)
    }
}

impl AsyncRead for Placed {
    fn poll_read(self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let before = buf.filled().len();
        let read = Pin::new(&mut self.get_mut().stream).poll_read(cx, buf);
        // A read without bytes changes no count: all threads share it.
        if buf.filled().len() > before {
            meter::BYTES_IN.add((buf.filled().len() - before) as u64);
        }
        read
    }
}

impl AsyncWrite for Placed {
    fn poll_write(self: Pin<&mut Self>, cx: &mut Context<'_>, buf: &[u8]) -> Poll<io::Result<usize>> {
        let this = self.get_mut();
        let written = Pin::new(&mut this.stream).poll_write(cx, buf);
        this.written(cx, written)
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
        let this = self.get_mut();
        let written = Pin::new(&mut this.stream).poll_write_vectored(cx, bufs);
        this.written(cx, written)
    }
}
