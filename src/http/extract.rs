//! Extractors that answer with problems where axum's own extractors would answer with text.

use axum::extract::{FromRequest, FromRequestParts, Request};
use axum::response::{IntoResponse, Response};
use http::header::CONTENT_TYPE;
use http::request::Parts;
use http::{HeaderValue, StatusCode};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::AppState;
use super::body::{Incoming, media_type};
use super::problem::{Problem, ProblemType};
use crate::jobs::memory;
use crate::wire::{Unreadable, read_json, read_query};

/// A JSON document, in or out.
#[derive(Debug)]
pub(super) struct Json<T>(pub(super) T);

/// Query parameters as one document.
#[derive(Debug)]
pub(super) struct Query<T>(pub(super) T);

/// Parts of the path.
#[derive(Debug)]
pub(super) struct Path<T>(pub(super) T);

/// Bodies above this length are parsed in the pool (bytes).
const PARSED_AT_ONCE: usize = 64 * 1024;

impl<T: DeserializeOwned + Send + 'static> FromRequest<AppState> for Json<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, app: &AppState) -> Result<Self, Problem> {
        Ok(Self(read_document(request, app, read_json).await?))
    }
}

/// A JSON document by a reader of its own.
///
/// # Errors
/// The body is not JSON or cannot be read.
#[expect(clippy::manual_async_fn, reason = "an async function would store the request twice")]
pub(super) fn read_document<T: Send + 'static>(
    mut request: Request,
    app: &AppState,
    read: fn(&[u8]) -> Result<T, Unreadable>,
) -> impl Future<Output = Result<T, Problem>> {
    async move {
        let kind = media_type(request.headers());
        if !kind.as_deref().is_some_and(is_json) {
            let found = kind.as_deref().unwrap_or("none");
            let detail = format!("send application/json, not {found}");
            return Err(Problem::new(ProblemType::UnsupportedMediaType, detail));
        }
        let body = std::mem::take(request.body_mut());
        let mut incoming = Incoming::new(body, app.settings.body_pause_timeout_s);
        let text = incoming.whole(request.headers(), app.settings.max_json_bytes).await?;
        let document = if text.len() > PARSED_AT_ONCE {
            memory::keep(parsed_bytes(&text))?;
            // Boxed because it is rare: otherwise its memory would be part of every request's.
            Box::pin(app.compute.run(move |_stop| read(&text))).await?
        } else {
            read(&text)
        };
        Ok(document?)
    }
}

/// Memory that a document needs for each of its values, including a row of numbers in a list that grows by doubling:
/// measured as 8 to 30 over every operation \[bytes\].
const VALUE_BYTES: u64 = 24;

/// An upper bound of the memory for the document of a JSON text, with its strings \[bytes\].
pub(super) fn parsed_bytes(text: &[u8]) -> u64 {
    let values = memchr::memchr3_iter(b',', b'[', b'{', text).count();
    text.len() as u64 + values as u64 * VALUE_BYTES
}

/// Whether a media type is JSON.
pub(super) fn is_json(essence: &str) -> bool {
    essence == "application/json" || (essence.starts_with("application/") && essence.ends_with("+json"))
}

impl<T: Serialize> IntoResponse for Json<T> {
    fn into_response(self) -> Response {
        match serde_json::to_vec(&self.0) {
            Ok(body) => json_response(body),
            Err(fault) => Problem::internal(&fault).into_response(),
        }
    }
}

/// A response of JSON text.
pub(super) fn json_response(body: impl Into<axum::body::Body>) -> Response {
    let mut response = (StatusCode::OK, body.into()).into_response();
    response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static("application/json"));
    response
}

impl<T: DeserializeOwned> FromRequestParts<AppState> for Query<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _app: &AppState) -> Result<Self, Problem> {
        Ok(Self(read_query(parts.uri.query().unwrap_or_default())?))
    }
}

impl<T: DeserializeOwned + Send> FromRequestParts<AppState> for Path<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &AppState) -> Result<Self, Problem> {
        match axum::extract::Path::<T>::from_request_parts(parts, app).await {
            Ok(axum::extract::Path(path)) => Ok(Self(path)),
            Err(fault) => Err(Problem::new(ProblemType::MalformedRequest, fault.body_text())),
        }
    }
}
