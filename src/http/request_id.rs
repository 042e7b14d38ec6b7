//! The id of a request.

use http::HeaderValue;
use uuid::Uuid;
use uuid::fmt::Hyphenated;

/// The id that the service gives a request, as text.
#[derive(Debug, Clone, Copy)]
pub(super) struct RequestId([u8; Hyphenated::LENGTH]);

impl RequestId {
    /// This fresh one.
    pub(super) fn new(fresh: Uuid) -> Self {
        let mut text = [0; Hyphenated::LENGTH];
        fresh.as_hyphenated().encode_lower(&mut text);
        Self(text)
    }

    /// The id as a header of the answer.
    pub(super) fn header(&self) -> HeaderValue {
        HeaderValue::from_bytes(&self.0).unwrap_or_else(|_| HeaderValue::from_static("none"))
    }

    /// The id.
    pub(super) fn as_str(&self) -> &str {
        std::str::from_utf8(&self.0).unwrap_or_default()
    }
}
