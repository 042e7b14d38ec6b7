//! Answers that are printed at once but sent slowly. Small answers stay in memory; large ones wait in a file without
//! a name, so that a client that reads nothing holds no memory.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use axum::body::{Body, HttpBody};
use axum::response::Response;
use bytes::Bytes;
use http::HeaderValue;
use http::header::CONTENT_LENGTH;
use tokio::sync::Semaphore;

use super::AppState;
use super::file_body::{CHUNK, FileBody};
use super::problem::Problem;
use crate::jobs::memory::{Account, REQUEST_BYTES};

/// Answers up to this length stay in memory if there is room for them \[bytes\].
const IN_MEMORY: usize = 1 << 20;
/// Answers up to this length are covered by the memory that every request reserves \[bytes\].
const PAID_ALREADY: u64 = 64 << 10;
/// Answers up to this length reserve no memory after they are made \[bytes\].
const TRIFLE: u64 = 1 << 10;
/// Memory with which an answer begins \[bytes\].
const SMALL_ANSWER: usize = 512;

/// An answer that is being printed.
#[derive(Debug)]
pub(super) struct Printed {
    app: AppState,
    text: Vec<u8>,
    file: Option<File>,
    length: u64,
    limit: u64,
}

impl Printed {
    /// An empty answer, limited to the largest length of a result.
    pub(super) fn new(app: &AppState) -> Self {
        Self {
            app: app.clone(),
            text: Vec::new(),
            file: None,
            length: 0,
            limit: app.settings.max_result_bytes,
        }
    }

    /// The answer's body, and its length.
    pub(super) fn into_body(mut self) -> io::Result<(Body, u64)> {
        if self.file.is_none() {
            return Ok((Body::from(self.text), self.length));
        }
        self.write_out()?;
        match self.file {
            Some(file) => Ok((Body::new(FileBody::new(file)), self.length)),
            None => Err(io::Error::other("an answer was lost")),
        }
    }

    fn write_out(&mut self) -> io::Result<()> {
        let file = match &mut self.file {
            Some(file) => file,
            None => self.file.insert(tempfile::tempfile_in(spool(&self.app))?),
        };
        file.write_all(&self.text)?;
        self.text.clear();
        Ok(())
    }
}

impl Write for Printed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.length += bytes.len() as u64;
        if self.length > self.limit {
            let detail =
                format!("the answer is larger than the limit of {} bytes; ask for less at once", self.limit);
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, detail));
        }
        if let (Some(file), true) = (&mut self.file, self.text.is_empty() && bytes.len() >= CHUNK) {
            file.write_all(bytes)?;
            return Ok(bytes.len());
        }
        if self.text.capacity() == 0 {
            self.text.reserve(bytes.len().max(SMALL_ANSWER));
        }
        self.text.extend_from_slice(bytes);
        if self.text.len() >= IN_MEMORY {
            self.write_out()?;
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn spool(app: &AppState) -> PathBuf {
    app.settings.data_dir.join("spool")
}

/// The answer, which reserves the memory that it holds until the client has taken it.
pub(super) async fn settled(app: &AppState, account: Account, response: Response) -> Response {
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
        // A file, or events: the result of the computation is not in memory any more.
        None => account.keep_only(REQUEST_BYTES),
    }
    held(account, response)
}

fn held(account: Account, response: Response) -> Response {
    response.map(|body| Body::new(Taken { body, _account: account }))
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
    let (directory, copy) = (spool(app), text.clone());
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

/// A body that reserves memory until it is taken.
struct Taken {
    body: Body,
    _account: Account,
}

impl HttpBody for Taken {
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
