//! An answer that leaves while it is printed.
//!
//! The printer puts pieces into a short queue, and the connection takes them from there. A client that reads quickly
//! gets its answer without a detour by the disk. The printer waits for a slow client only briefly. Then it writes the
//! rest into a file without a name, so that a client that reads nothing holds neither memory nor a computing thread.

use std::collections::VecDeque;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};
use std::time::{Duration, Instant};

use axum::body::HttpBody;
use bytes::Bytes;
use hyper::body::Frame;
use thiserror::Error;

use super::file_body::FileBody;

/// Largest length of a piece \[bytes\]. Memory of this size is used again; larger memory would be given back to the
/// system each time.
const PIECE: usize = 64 << 10;
/// How long a printer waits for a client that takes nothing. No pieces add more patience than this.
const MOST_PATIENCE: Duration = Duration::from_millis(20);
/// Patience that each piece adds. It covers a client that takes 256 MiB a second, which is one on the same computer or
/// network. A slower one would hold a computing thread for longer than its answer takes to print.
const PATIENCE_OF_A_PIECE: Duration = Duration::from_micros(250);

/// The side that prints. If it is dropped before [`Printer::end`], the answer breaks off.
#[derive(Debug)]
pub(super) struct Printer {
    shared: Arc<Shared>,
    spool: PathBuf,
    file: Option<File>,
    queue_bytes: usize,
    patience: Duration,
}

/// The side that is sent: an answer's body.
#[derive(Debug)]
pub(super) struct Flow {
    shared: Arc<Shared>,
    file: Option<FileBody>,
}

/// Why nothing more is printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the client has left")]
pub(super) struct ClientLeft;

impl ClientLeft {
    /// Whether this is the cause of a fault.
    pub(super) fn caused(fault: &io::Error) -> bool {
        fault.get_ref().is_some_and(<dyn std::error::Error + Send + Sync>::is::<Self>)
    }
}

#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    /// Notified when the client has taken a piece, and when it has left.
    taken: Condvar,
}

#[derive(Debug, Default)]
struct State {
    pieces: VecDeque<Bytes>,
    queued_bytes: usize,
    rest: Rest,
    client: Option<Waker>,
    client_left: bool,
}

/// What comes after the pieces in the queue.
#[derive(Debug, Default)]
enum Rest {
    /// It is not known yet.
    #[default]
    Printing,
    /// Nothing.
    Nothing,
    /// A file.
    File(File),
    /// The printer failed.
    Broken,
}

impl Shared {
    fn state(&self) -> MutexGuard<'_, State> {
        // The state is consistent at every moment, even after a panic.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Flow {
    /// The body of an answer whose queue holds `queue_bytes`. What does not fit goes into a file in `spool`. Without
    /// a queue the printer does not wait.
    pub(super) fn new(spool: &Path, queue_bytes: usize) -> (Printer, Self) {
        let shared = Arc::new(Shared::default());
        let printer = Printer {
            shared: Arc::clone(&shared),
            spool: spool.to_owned(),
            file: None,
            queue_bytes,
            patience: MOST_PATIENCE,
        };
        (printer, Self { shared, file: None })
    }
}

impl Printer {
    /// The answer is complete. Returns how much of it is still in memory \[bytes\]: something only if the disk fails.
    pub(super) fn end(mut self) -> usize {
        if self.file.is_none()
            && !self.waits_while(|state| !state.pieces.is_empty())
            && let Err(fault) = self.file()
            && !ClientLeft::caused(&fault)
        {
            tracing::warn!(error = %fault, "an answer cannot be written to a file and stays in memory");
            self.file = None;
        }
        let rest = self.file.take().map_or(Rest::Nothing, Rest::File);
        self.is_followed_by(rest);
        self.shared.state().queued_bytes
    }

    /// Waits while the queue is in this state. False if the patience ends before; a client that has left ends it.
    fn waits_while(&mut self, is_so: impl Fn(&State) -> bool) -> bool {
        let mut state = self.shared.state();
        while !state.client_left && is_so(&state) {
            if self.queue_bytes == 0 || self.patience.is_zero() {
                return false;
            }
            let began = Instant::now();
            let waited = self.shared.taken.wait_timeout(state, self.patience);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
            self.patience = self.patience.saturating_sub(began.elapsed());
        }
        true
    }

    fn is_followed_by(&self, rest: Rest) {
        let mut state = self.shared.state();
        if matches!(state.rest, Rest::Printing) {
            state.rest = rest;
        }
        let client = state.client.take();
        drop(state);
        client.into_iter().for_each(Waker::wake);
    }

    /// Puts a piece into the queue. False if there is no room for it within the patience that is left.
    fn offer(&mut self, piece: &[u8]) -> io::Result<bool> {
        let most_bytes = self.queue_bytes;
        if !self.waits_while(|state| state.queued_bytes + piece.len() > most_bytes) {
            return Ok(false);
        }
        let mut state = self.shared.state();
        if state.client_left {
            return Err(io::Error::other(ClientLeft));
        }
        if self.patience < MOST_PATIENCE {
            self.patience = (self.patience + PATIENCE_OF_A_PIECE).min(MOST_PATIENCE);
        }
        state.queued_bytes += piece.len();
        state.pieces.push_back(Bytes::copy_from_slice(piece));
        let client = state.client.take();
        drop(state);
        client.into_iter().for_each(Waker::wake);
        Ok(true)
    }

    /// The file. When it is made, the pieces that the client has not taken move into it: they hold no memory then. If
    /// they cannot be written, they stay where they were.
    fn file(&mut self) -> io::Result<&mut File> {
        let file = match &mut self.file {
            Some(file) => file,
            none => none.insert(tempfile::tempfile_in(&self.spool)?),
        };
        let mut state = self.shared.state();
        if state.client_left {
            return Err(io::Error::other(ClientLeft));
        }
        let untaken = std::mem::take(&mut state.pieces);
        state.queued_bytes = 0;
        drop(state);
        if let Err(fault) = untaken.iter().try_for_each(|piece| file.write_all(piece)) {
            let mut state = self.shared.state();
            state.queued_bytes = untaken.iter().map(Bytes::len).sum();
            state.pieces = untaken;
            return Err(fault);
        }
        Ok(file)
    }
}

impl Write for Printer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut rest = bytes;
        while self.file.is_none() && !rest.is_empty() {
            let (piece, after) = rest.split_at(rest.len().min(PIECE));
            if !self.offer(piece)? {
                break;
            }
            rest = after;
        }
        if !rest.is_empty() {
            self.file()?.write_all(rest)?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for Printer {
    fn drop(&mut self) {
        // After the end this changes nothing.
        self.is_followed_by(Rest::Broken);
    }
}

impl HttpBody for Flow {
    type Data = Bytes;
    type Error = io::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, io::Error>>> {
        if let Some(file) = &mut self.file {
            return Pin::new(file).poll_frame(context);
        }
        let mut state = self.shared.state();
        if let Some(piece) = state.pieces.pop_front() {
            state.queued_bytes -= piece.len();
            drop(state);
            self.shared.taken.notify_one();
            return Poll::Ready(Some(Ok(Frame::data(piece))));
        }
        match std::mem::take(&mut state.rest) {
            Rest::Printing => {
                state.client = Some(context.waker().clone());
                Poll::Pending
            }
            Rest::Nothing => {
                state.rest = Rest::Nothing;
                Poll::Ready(None)
            }
            Rest::File(file) => {
                state.rest = Rest::Nothing;
                drop(state);
                let mut body = FileBody::new(file);
                let first = Pin::new(&mut body).poll_frame(context);
                self.file = Some(body);
                first
            }
            Rest::Broken => {
                state.rest = Rest::Nothing;
                Poll::Ready(Some(Err(io::Error::other("the answer broke off"))))
            }
        }
    }
}

impl Drop for Flow {
    fn drop(&mut self) {
        let mut state = self.shared.state();
        state.client_left = true;
        state.pieces.clear();
        drop(state);
        self.shared.taken.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use http_body_util::BodyExt;
    use tempfile::TempDir;

    use super::*;

    const QUEUE: usize = 4 * PIECE;

    fn content() -> Vec<u8> {
        (0..=250).cycle().take(20 * PIECE + 17).collect()
    }

    #[tokio::test(flavor = "multi_thread", worker_threads = 2)]
    async fn a_client_that_reads_gets_every_byte_and_no_file_is_made() {
        let nowhere = Path::new("there is no such folder");
        let (mut printer, body) = Flow::new(nowhere, QUEUE);
        let printing = tokio::task::spawn_blocking(move || {
            printer.patience = Duration::from_mins(1);
            content().chunks(100_000).try_for_each(|text| printer.write_all(text)).unwrap();
            printer.end();
        });
        let read = body.collect().await.unwrap().to_bytes();
        assert!(read == content());
        printing.await.unwrap();
    }

    #[tokio::test]
    async fn a_client_that_reads_nothing_finds_the_rest_in_a_file() {
        let spool = TempDir::new().unwrap();
        for queue_bytes in [0, QUEUE] {
            let (mut printer, body) = Flow::new(spool.path(), queue_bytes);
            printer.write_all(&content()).unwrap();
            assert!(printer.file.is_some());
            assert!(printer.shared.state().pieces.is_empty());
            assert_eq!(printer.end(), 0);
            assert!(body.collect().await.unwrap().to_bytes() == content());
        }
    }

    #[tokio::test]
    async fn what_a_client_has_not_taken_at_the_end_is_in_a_file_or_stays_whole() {
        let spool = TempDir::new().unwrap();
        let nowhere = spool.path().join("there is no such folder");
        for (folder, left) in [(spool.path(), 0), (nowhere.as_path(), 3 * PIECE)] {
            let (mut printer, body) = Flow::new(folder, QUEUE);
            printer.write_all(&content()[..3 * PIECE]).unwrap();
            assert_eq!(printer.end(), left);
            assert!(body.collect().await.unwrap().to_bytes() == content()[..3 * PIECE]);
        }
    }

    #[tokio::test]
    async fn what_is_not_ended_breaks_off_after_what_was_printed() {
        let (mut printer, mut body) = Flow::new(Path::new("."), QUEUE);
        printer.write_all(b"begun").unwrap();
        drop(printer);
        assert_eq!(body.frame().await.unwrap().unwrap().into_data().unwrap(), "begun");
        body.frame().await.unwrap().unwrap_err();
    }

    #[test]
    fn nobody_prints_for_a_client_that_has_left() {
        for fill in [1, QUEUE] {
            let (mut printer, body) = Flow::new(Path::new("."), QUEUE);
            printer.write_all(&vec![0; fill]).unwrap();
            drop(body);
            let fault = printer.write_all(&content()).unwrap_err();
            assert!(ClientLeft::caused(&fault), "{fault}");
        }
    }
}
