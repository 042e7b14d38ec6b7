//! What both directions share: a body of JSON or CSV in, rows out.

use axum::body::Body;
use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use futures::stream;
use http::header::CONTENT_TYPE;
use http::request::Parts;
use http::{HeaderMap, HeaderName, HeaderValue};

use crate::http::AppState;
use crate::http::body::{Incoming, media_type};
use crate::http::extract::is_json;
use crate::http::problem::{Problem, ProblemType};
use crate::wire::RowFault;

/// Media types of an answer.
pub(super) const ANSWERS: &[&str] = &["application/json", CSV];
/// Media type of a table.
pub(super) const CSV: &str = "text/csv";
/// The revision that was computed on, where the body has no place for it.
const REVISION: HeaderName = HeaderName::from_static("trunnion-machine-revision");

/// Rows printed at a time.
const ROWS_AT_ONCE: usize = 2048;

/// Whether the body is a table; neither JSON nor CSV is refused.
pub(super) fn is_table(headers: &HeaderMap) -> Result<bool, Problem> {
    match media_type(headers).as_deref() {
        Some(CSV) => Ok(true),
        Some(kind) if is_json(kind) => Ok(false),
        found => {
            let found = found.unwrap_or("none");
            let detail = format!("the operation takes application/json and text/csv, not {found}");
            Err(Problem::new(ProblemType::UnsupportedMediaType, detail))
        }
    }
}

/// The representations, the form of the request first.
pub(super) fn offers(table: bool) -> &'static [&'static str] {
    if table { &[CSV, "application/json"] } else { ANSWERS }
}

/// Feeds a body to a reader of rows, chunk by chunk.
pub(super) async fn feed(
    app: &AppState,
    parts: &Parts,
    body: Body,
    mut take: impl FnMut(&[u8]) -> Result<(), RowFault>,
) -> Result<(), Problem> {
    let limit = app.settings.max_body_bytes;
    let mut incoming = Incoming::new(body, app.settings.body_pause_timeout_s);
    if crate::http::body::content_length(&parts.headers).is_some_and(|length| length > limit) {
        return Err(incoming.refuse_length(limit).await);
    }
    let mut length = 0;
    while let Some(chunk) = incoming.next().await? {
        length += chunk.len() as u64;
        if length > limit {
            return Err(incoming.refuse_length(limit).await);
        }
        if let Err(fault) = take(&chunk) {
            incoming.swallow().await;
            return Err(fault.into());
        }
    }
    Ok(())
}

/// Longest number in a cell with the comma behind it (bytes).
const CELL: usize = 25;

/// Refuses an answer of so many bytes over the limit.
pub(super) fn within(app: &AppState, length: u64) -> Result<(), Problem> {
    let limit = app.settings.max_result_bytes;
    if length <= limit {
        return Ok(());
    }
    let detail = format!("the answer can have {length} bytes, {limit} are allowed");
    Err(Problem::new(ProblemType::ResultTooLarge, detail))
}

/// The most bytes that so many rows can have under this header.
pub(super) fn most_bytes(header: &[u8], rows: usize) -> u64 {
    let cells = header.split(|byte| *byte == b',').count();
    (rows as u64).saturating_mul((cells * CELL) as u64).saturating_add(header.len() as u64)
}

/// Rows as a stream, printed when the client takes them.
pub(super) fn rows<T: Send + 'static>(
    revision: i64,
    header: Vec<u8>,
    rows: Vec<T>,
    mut print: impl FnMut(&mut Vec<u8>, usize, &T) + Send + 'static,
) -> Response {
    let mut first = Some(header);
    let mut next = 0;
    let chunks = stream::iter(std::iter::from_fn(move || {
        let mut text = first.take().unwrap_or_default();
        let begin = next;
        next = rows.len().min(begin + ROWS_AT_ONCE);
        for (offset, row) in rows.get(begin..next).unwrap_or_default().iter().enumerate() {
            print(&mut text, begin + offset, row);
        }
        (!text.is_empty()).then(|| Ok::<_, std::convert::Infallible>(Bytes::from(text)))
    }));
    let mut response = Body::from_stream(chunks).into_response();
    response
        .headers_mut()
        .insert(CONTENT_TYPE, HeaderValue::from_static("text/csv; charset=utf-8; header=present"));
    response.headers_mut().insert(REVISION, HeaderValue::from(revision));
    response
}
