//! The id of a request.

use http::HeaderValue;
use uuid::Uuid;

/// The id that the service gives a request, as a header of its answer.
#[derive(Debug, Clone)]
pub(super) struct RequestId(HeaderValue);

impl RequestId {
    /// This fresh one.
    pub(super) fn new(fresh: Uuid) -> Self {
        let text = HeaderValue::from_str(fresh.hyphenated().encode_lower(&mut Uuid::encode_buffer()));
        Self(text.unwrap_or_else(|_| HeaderValue::from_static("none")))
    }

    /// The header.
    pub(super) fn header(&self) -> HeaderValue {
        self.0.clone()
    }

    /// The id.
    pub(super) fn as_str(&self) -> &str {
        self.0.to_str().unwrap_or_default()
    }
}
