//! The part that both directions share: a body of JSON or CSV in, rows out.

use std::io;

use axum::body::{Body, HttpBody};
use axum::response::{IntoResponse, Response};
use http::header::{CONTENT_LENGTH, CONTENT_TYPE};
use http::request::Parts;
use http::{HeaderMap, HeaderName, HeaderValue};

use crate::http::AppState;
use crate::http::body::{Incoming, media_type};
use crate::http::extract::is_json;
use crate::http::printed::{Leaving, StillPrinting};
use crate::http::problem::{Problem, ProblemType};
use crate::jobs::{PoseTable, memory};
use crate::wire::{
    Fault, JointRows, JointWords, KinematicsOptions, LONGEST_NUMBER, NoParameters, RowFault, read_query,
};

/// Media types of an answer.
pub(super) const ANSWERS: &[&str] = &["application/json", CSV];
/// Media type of a table.
pub(super) const CSV: &str = "text/csv";
/// The revision that was used, for a body that has no member for it.
const REVISION: HeaderName = HeaderName::from_static("trunnion-machine-revision");

/// Whether the body is a table; a body that is neither JSON nor CSV is refused.
pub(super) fn is_table(headers: &HeaderMap) -> Result<bool, Problem> {
    match media_type(headers).as_deref() {
        Some(CSV) => Ok(true),
        Some(kind) if is_json(kind) => Ok(false),
        found => {
            let found = found.unwrap_or("none");
            let detail = format!("send application/json or text/csv, not {found}");
            Err(Problem::new(ProblemType::UnsupportedMediaType, detail))
        }
    }
}

/// The representations, the form of the request first.
pub(super) fn offers(table: bool) -> &'static [&'static str] {
    if table { &[CSV, "application/json"] } else { ANSWERS }
}

/// Refuses query parameters beside a JSON body, which has the options itself.
///
/// # Errors
/// There are query parameters.
pub(super) fn no_options(query: &str) -> Result<(), Problem> {
    if query.is_empty() {
        return Ok(());
    }
    let Err(fault) = read_query::<NoParameters>(query) else { return Ok(()) };
    if read_query::<KinematicsOptions>(query).is_err() {
        return Err(fault.into());
    }
    let name = query.split(['=', '&', '.']).next().unwrap_or_default();
    let detail =
        format!("with a JSON body the options are members of the body; move {name} from the query into it");
    Err(Problem::invalid(ProblemType::InvalidRequest, vec![Fault::new(format!("/{name}"), detail)]))
}

/// Rows of a table that are being received.
pub(super) trait Rows {
    /// Memory of one more row while their list grows \[bytes\].
    fn row_bytes(&self) -> usize;

    /// Takes the next bytes.
    fn take(&mut self, chunk: &[u8]) -> Result<(), RowFault>;

    /// Moves rows to the disk, if there are more than should stay in memory.
    fn settle(&mut self) -> impl Future<Output = io::Result<()>> + Send {
        std::future::ready(Ok(()))
    }
}

impl Rows for JointRows {
    fn row_bytes(&self) -> usize {
        2 * size_of::<JointWords>()
    }

    fn take(&mut self, chunk: &[u8]) -> Result<(), RowFault> {
        self.feed(chunk)
    }
}

impl Rows for PoseTable {
    fn row_bytes(&self) -> usize {
        Self::row_bytes(self)
    }

    fn take(&mut self, chunk: &[u8]) -> Result<(), RowFault> {
        self.feed(chunk)
    }

    fn settle(&mut self) -> impl Future<Output = io::Result<()>> + Send {
        Self::settle(self)
    }
}

/// Feeds a body to a reader of rows, chunk by chunk.
pub(super) async fn feed(
    app: &AppState,
    parts: &Parts,
    body: Body,
    rows: &mut (impl Rows + Send),
) -> Result<(), Problem> {
    let limit = app.settings.max_body_bytes;
    let mut incoming = Incoming::new(body, app.settings.body_pause_timeout_s);
    if crate::http::body::content_length(&parts.headers).is_some_and(|length| length > limit) {
        return Err(incoming.refuse_length(limit).await);
    }
    let (mut length, mut unpaid) = (0, 0);
    while let Some(chunk) = incoming.next().await? {
        length += chunk.len() as u64;
        if length > limit {
            return Err(incoming.refuse_length(limit).await);
        }
        // Memory for rows is reserved as they arrive, for many rows at a time.
        unpaid += memchr::memchr_iter(b'\n', &chunk).count() * rows.row_bytes();
        let taken = if unpaid > PAID_AT_ONCE {
            memory::keep(std::mem::take(&mut unpaid) as u64).map_err(Problem::from)
        } else {
            Ok(())
        };
        let taken = taken.and_then(|()| Ok(rows.take(&chunk)?));
        drop(chunk);
        let settled = match taken {
            Ok(()) => rows.settle().await.map_err(Problem::from),
            refused => refused,
        };
        if let Err(refusal) = settled {
            incoming.swallow().await;
            return Err(refusal);
        }
    }
    Ok(())
}

/// Memory for rows is reserved in steps of this size \[bytes\].
const PAID_AT_ONCE: usize = 64 << 10;

/// Longest cell: a number, with the comma after it \[bytes\].
const CELL: usize = LONGEST_NUMBER + 1;

/// Refuses an answer that is longer than the limit.
pub(super) fn within(limit: u64, length: u64) -> Result<(), Problem> {
    if length <= limit {
        return Ok(());
    }
    let detail = format!("the answer may need {length} bytes, but the limit is {limit}; send fewer rows");
    Err(Problem::new(ProblemType::ResultTooLarge, detail))
}

/// The largest number of bytes that this many rows can have with this header.
pub(super) fn most_bytes(header: &[u8], rows: usize) -> u64 {
    let cells = header.split(|byte| *byte == b',').count();
    (rows as u64).saturating_mul((cells * CELL) as u64).saturating_add(header.len() as u64)
}

/// The answer of a table.
pub(super) fn table<H>(revision: i64, leaving: Leaving<H>) -> (Response, H) {
    let kind = HeaderValue::from_static("text/csv; charset=utf-8; header=present");
    let (mut response, head) = answer(kind, leaving);
    response.headers_mut().insert(REVISION, HeaderValue::from(revision));
    (response, head)
}

/// The answer of a document.
pub(super) fn document<H>(leaving: Leaving<H>) -> Response {
    answer(HeaderValue::from_static("application/json"), leaving).0
}

/// Fields of an answer's header, with those that are added to every answer.
const HEADERS: usize = 12;

fn answer<H>(kind: HeaderValue, leaving: Leaving<H>) -> (Response, H) {
    let Leaving { head, body, length, is_printing } = leaving;
    let mut response = body.into_response();
    response.headers_mut().reserve(HEADERS);
    response.headers_mut().insert(CONTENT_TYPE, kind);
    // The HTTP library adds the length of an answer in memory.
    if let Some(length) = length
        && response.body().size_hint().exact().is_none()
    {
        response.headers_mut().insert(CONTENT_LENGTH, HeaderValue::from(length));
    }
    if is_printing {
        response.extensions_mut().insert(StillPrinting);
    }
    (response, head)
}
