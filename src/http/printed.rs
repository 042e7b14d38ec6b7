//! Answers that are printed at once but sent slowly. Small answers stay in memory. Large ones leave while they are
//! printed; for a client that reads slowly they wait in a file without a name, so that it holds no memory.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use axum::body::{Body, HttpBody};
use axum::response::Response;
use bytes::Bytes;
use http::HeaderValue;
use http::header::CONTENT_LENGTH;
use tokio::sync::{Semaphore, oneshot};

use super::AppState;
use super::file_body::FileBody;
use super::flow::{ClientLeft, Flow, Printer};
use super::problem::Problem;
use crate::config::Settings;
use crate::jobs::KinematicsFault;
use crate::jobs::memory::{self, Account, REQUEST_BYTES};
use crate::process::Stop;
use crate::side_by_side::{OneAfterAnother, SideBySide};

/// Answers up to this length stay in memory if there is room for them \[bytes\].
const IN_MEMORY: usize = 1 << 20;
/// Answers up to this length are sent when they are complete \[bytes\].
const SENT_WHOLE: usize = 256 << 10;
/// Memory of an answer that leaves while it is printed \[bytes\].
const QUEUE: usize = 512 << 10;
/// Answers up to this length are covered by the memory that every request reserves \[bytes\].
const PAID_ALREADY: u64 = 64 << 10;
/// Answers up to this length reserve no memory after they are made \[bytes\].
const TRIFLE: u64 = 1 << 10;
/// Memory with which an answer begins \[bytes\].
const SMALL_ANSWER: usize = 512;

/// An answer that is being printed. `H` is what its head needs to know.
#[derive(Debug)]
pub(super) struct Printed<H> {
    settings: Arc<Settings>,
    account: Option<Account>,
    /// The head, until it leaves.
    head: Option<H>,
    /// Takes the head and the body once they may leave.
    begin: Option<oneshot::Sender<(H, Flow)>>,
    text: Vec<u8>,
    printer: Option<Printer>,
    /// The body of a long answer that must not leave before it is complete.
    kept: Option<Flow>,
    length: u64,
}

/// What leaves: what the head needs to know, the body, and its length if that is known.
pub(super) struct Leaving<H> {
    pub(super) head: H,
    pub(super) body: Body,
    pub(super) length: Option<u64>,
    /// Whether the answer is still being printed.
    pub(super) is_printing: bool,
}

/// Why an answer is not printed to its end.
#[derive(Debug)]
pub(super) enum Unprinted {
    /// It is refused.
    Refused(Problem),
    /// It cannot be written.
    Unwritten(io::Error),
}

impl From<Problem> for Unprinted {
    fn from(problem: Problem) -> Self {
        Self::Refused(problem)
    }
}

impl From<KinematicsFault> for Unprinted {
    fn from(fault: KinematicsFault) -> Self {
        Self::Refused(fault.into())
    }
}

impl From<io::Error> for Unprinted {
    fn from(fault: io::Error) -> Self {
        Self::Unwritten(fault)
    }
}

impl From<Unprinted> for Problem {
    fn from(fault: Unprinted) -> Self {
        match fault {
            Unprinted::Refused(problem) => problem,
            Unprinted::Unwritten(fault) => fault.into(),
        }
    }
}

/// The answer is still being printed: its computation releases the memory that it holds.
#[derive(Debug, Clone, Copy)]
pub(super) struct StillPrinting;

/// A trifling answer, printed on this thread.
///
/// # Errors
/// Those of `work`, or the answer is too long.
pub(super) fn print_here<H>(
    app: &AppState,
    work: impl FnOnce(&dyn SideBySide, &Stop<'_>, &mut Printed<H>) -> Result<(), Unprinted>,
) -> Result<Leaving<H>, Problem> {
    let mut printed = Printed::new(app, None);
    work(&OneAfterAnother, &|| std::ops::ControlFlow::Continue(()), &mut printed)?;
    printed.whole()
}

/// An answer that `work` prints on a computing thread. `work` calls [`Printed::may_leave`] before it prints.
///
/// # Errors
/// Those of `work` before the answer leaves; no place to compute is free; the answer is too long.
pub(super) async fn print_computed<H: Send + 'static>(
    app: &AppState,
    work: impl FnOnce(&dyn SideBySide, &Stop<'_>, &mut Printed<H>) -> Result<(), Unprinted> + Send + 'static,
) -> Result<Leaving<H>, Problem> {
    let (begin, begun) = oneshot::channel();
    let (mut printed, compute) = (Printed::new(app, Some(begin)), app.compute.clone());
    let mut computing = Box::pin(async move {
        let printing = compute.run_in_parts(move |threads, stop| {
            let done = work(threads, stop, &mut printed);
            printed.end(done)
        });
        printing.await
    });
    tokio::select! {
        biased;
        Ok((head, flow)) = begun => {
            // With the body, the computation is dropped, which stops it.
            let body = Body::new(Held { body: Body::new(flow), _held: computing });
            Ok(Leaving { head, body, length: None, is_printing: true })
        }
        whole = &mut computing => {
            // An answer that has left comes by the other arm.
            whole??.ok_or_else(|| Problem::internal(&"an answer has left without its body"))
        }
    }
}

impl<H> Printed<H> {
    /// An empty answer, limited to the largest length of a result.
    fn new(app: &AppState, begin: Option<oneshot::Sender<(H, Flow)>>) -> Self {
        Self {
            settings: Arc::clone(&app.settings),
            account: memory::account(),
            head: None,
            begin,
            text: Vec::new(),
            printer: None,
            kept: None,
            length: 0,
        }
    }

    /// Gives the head of the answer. From now on, the answer may leave before it is complete, unless its length of up
    /// to `most_bytes` may exceed the limit.
    pub(super) fn may_leave(&mut self, head: H, most_bytes: u64) {
        self.head = Some(head);
        if most_bytes > self.settings.max_result_bytes {
            self.begin = None;
        }
    }

    /// Lets the answer leave if it may; otherwise it continues in a file.
    fn flow(&mut self) -> io::Result<()> {
        let paid = || self.account.as_ref().is_none_or(|account| account.keep(QUEUE as u64).is_ok());
        let queue_bytes = if self.begin.is_some() && paid() { QUEUE } else { 0 };
        let (printer, flow) = Flow::new(&spool(&self.settings), queue_bytes);
        match (self.begin.take(), self.head.take()) {
            (Some(begin), Some(head)) => {
                begin.send((head, flow)).map_err(|_left| io::Error::other(ClientLeft))?;
            }
            (_, head) => (self.head, self.kept) = (head, Some(flow)),
        }
        self.printer.insert(printer).write_all(&std::mem::take(&mut self.text))
    }

    /// The answer, which is complete.
    fn whole(self) -> Result<Leaving<H>, Problem> {
        let Some(head) = self.head else { return Err(Problem::internal(&"an answer has no head")) };
        let body = match (self.printer, self.kept) {
            (Some(printer), Some(kept)) => {
                printer.end();
                Body::new(kept)
            }
            _ => Body::from(self.text),
        };
        Ok(Leaving { head, body, length: Some(self.length), is_printing: false })
    }

    /// Ends the answer after its work is `done`. `None` if it has left already.
    fn end(mut self, done: Result<(), Unprinted>) -> Result<Option<Leaving<H>>, Problem> {
        let has_left = self.printer.is_some() && self.kept.is_none();
        if !has_left {
            done?;
            return self.whole().map(Some);
        }
        let left_bytes = match (done, self.printer.take()) {
            (Ok(()), Some(printer)) => printer.end(),
            (Err(Unprinted::Unwritten(fault)), _) if ClientLeft::caused(&fault) => 0,
            (Err(fault), _) => {
                tracing::error!(?fault, "an answer broke off");
                0
            }
            (Ok(()), None) => 0,
        };
        if let Some(account) = &self.account {
            account.keep_only(REQUEST_BYTES + left_bytes as u64);
        }
        Ok(None)
    }
}

impl<H> Write for Printed<H> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.length += bytes.len() as u64;
        let limit = self.settings.max_result_bytes;
        if self.length > limit {
            let detail =
                format!("the answer is larger than the limit of {limit} bytes; ask for less at once");
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, detail));
        }
        if let Some(printer) = &mut self.printer {
            return printer.write(bytes);
        }
        if self.text.capacity() == 0 {
            self.text.reserve(bytes.len().max(SMALL_ANSWER));
        }
        self.text.extend_from_slice(bytes);
        if self.text.len() > SENT_WHOLE {
            self.flow()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn spool(settings: &Settings) -> PathBuf {
    settings.data_dir.join("spool")
}

/// The answer, which reserves the memory that it holds until the client has taken it.
#[expect(clippy::manual_async_fn, reason = "an async function would store the answer twice")]
pub(super) fn settled(
    app: &AppState,
    account: Account,
    response: Response,
) -> impl Future<Output = Response> {
    async move {
        let length = response.body().size_hint().exact();
        match length {
            Some(length) if length <= TRIFLE => return response,
            Some(length) if length <= PAID_ALREADY => account.keep_only(REQUEST_BYTES),
            Some(length) => {
                account.keep_only(REQUEST_BYTES);
                if length > IN_MEMORY as u64 || account.keep(length).is_err() {
                    // The work may have been stored. So the answer is not refused if memory is missing; it waits on the
                    // disk.
                    return Box::pin(on_disk(app, account, response)).await;
                }
            }
            None if response.extensions().get::<StillPrinting>().is_some() => {}
            // A file, or events: the result of the computation is not in memory any more.
            None => account.keep_only(REQUEST_BYTES),
        }
        held(account, response)
    }
}

fn held(account: Account, response: Response) -> Response {
    response.map(|body| Body::new(Held { body, _held: account }))
}

/// Moves an answer into a file.
async fn on_disk(app: &AppState, account: Account, response: Response) -> Response {
    /// Number of answers that are moved at the same time.
    static MOVING: Semaphore = Semaphore::const_new(4);
    let (mut parts, body) = response.into_parts();
    let _turn = MOVING.acquire().await;
    let Ok(text) = axum::body::to_bytes(body, usize::MAX).await else {
        return axum::response::IntoResponse::into_response(Problem::internal(&"an answer broke off"));
    };
    let (directory, copy) = (spool(&app.settings), text.clone());
    let written = tokio::task::spawn_blocking(move || in_file(&directory, &copy)).await;
    let length = text.len();
    let body = match written.unwrap_or_else(|panicked| Err(io::Error::other(panicked))) {
        Ok(body) => body,
        Err(fault) => {
            tracing::warn!(error = %fault, "an answer cannot be written to a file and stays in memory");
            Body::from(text)
        }
    };
    parts.headers.insert(CONTENT_LENGTH, HeaderValue::from(length));
    held(account, Response::from_parts(parts, body))
}

fn in_file(directory: &Path, text: &Bytes) -> io::Result<Body> {
    let mut file = tempfile::tempfile_in(directory)?;
    file.write_all(text)?;
    Ok(Body::new(FileBody::new(file)))
}

/// A body that holds something until it is taken or dropped: memory, or the computation that prints it.
struct Held<T> {
    body: Body,
    _held: T,
}

impl<T: Unpin> HttpBody for Held<T> {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: std::pin::Pin<&mut Self>,
        context: &mut std::task::Context<'_>,
    ) -> std::task::Poll<Option<Result<hyper::body::Frame<Bytes>, axum::Error>>> {
        std::pin::Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> hyper::body::SizeHint {
        self.body.size_hint()
    }
}
