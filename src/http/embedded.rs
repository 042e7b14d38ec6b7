//! Files that are in the binary, compressed: a fifth of their length.

use std::io::{self, Read};
use std::sync::OnceLock;

use axum::response::{IntoResponse, Response};
use bytes::Bytes;
use flate2::read::GzDecoder;
use http::header::{ACCEPT_ENCODING, CONTENT_ENCODING, CONTENT_TYPE, VARY};
use http::{HeaderMap, HeaderValue};

/// A file in the binary.
#[derive(Debug)]
pub(super) struct Embedded {
    kind: &'static str,
    gzip: &'static [u8],
    /// Without compression, once a client has asked for that.
    plain: OnceLock<Bytes>,
}

impl Embedded {
    /// A file of this media type, compressed with gzip.
    pub(super) const fn new(kind: &'static str, gzip: &'static [u8]) -> Self {
        Self { kind, gzip, plain: OnceLock::new() }
    }

    /// The file without compression.
    ///
    /// # Errors
    /// The binary is damaged.
    pub(super) fn plain(&self) -> io::Result<Bytes> {
        if let Some(plain) = self.plain.get() {
            return Ok(plain.clone());
        }
        let mut plain = Vec::new();
        GzDecoder::new(self.gzip).read_to_end(&mut plain)?;
        Ok(self.plain.get_or_init(|| plain.into()).clone())
    }

    /// The file, compressed if the client takes that.
    ///
    /// # Errors
    /// The binary is damaged.
    pub(super) fn answer(&self, headers: &HeaderMap) -> io::Result<Response> {
        let compressed = takes_gzip(headers);
        let bytes = if compressed { Bytes::from_static(self.gzip) } else { self.plain()? };
        let mut response = bytes.into_response();
        response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(self.kind));
        response.headers_mut().insert(VARY, HeaderValue::from_static("accept-encoding"));
        if compressed {
            response.headers_mut().insert(CONTENT_ENCODING, HeaderValue::from_static("gzip"));
        }
        Ok(response)
    }
}

/// The file of this name that the build has compressed.
macro_rules! embedded {
    ($kind:expr, $name:literal) => {
        $crate::http::embedded::Embedded::new($kind, include_bytes!(concat!(env!("OUT_DIR"), "/", $name)))
    };
}
pub(super) use embedded;

/// Whether the client takes gzip (RFC 9110 §12.5.3). A header that cannot be read, or none, is answered without it.
fn takes_gzip(headers: &HeaderMap) -> bool {
    let values = headers.get_all(ACCEPT_ENCODING).iter().filter_map(|value| value.to_str().ok());
    let mut gzip = None;
    let mut any = None;
    for coding in values.flat_map(|value| value.split(',')) {
        let (name, parameters) = coding.split_once(';').unwrap_or((coding, ""));
        let quality = parameters.trim().strip_prefix("q=").map_or(Some(1.0), |text| text.trim().parse().ok());
        let taken = quality.is_some_and(|quality: f64| quality > 0.0);
        match name.trim().to_ascii_lowercase().as_str() {
            "gzip" | "x-gzip" => gzip = Some(taken),
            "*" => any = Some(taken),
            _ => {}
        }
    }
    gzip.or(any).unwrap_or(false)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gzip_is_sent_only_to_those_who_take_it() {
        for (value, taken) in [
            ("gzip", true),
            ("br, GZIP;q=0.5", true),
            ("gzip;q=0", false),
            ("gzip; q=0.0, *", false),
            ("*", true),
            ("*;q=0, gzip", true),
            ("identity", false),
            ("gzip;q=x", false),
            ("", false),
        ] {
            let headers = HeaderMap::from_iter([(ACCEPT_ENCODING, HeaderValue::from_static(value))]);
            assert_eq!(takes_gzip(&headers), taken, "{value:?}");
        }
        assert!(!takes_gzip(&HeaderMap::new()));
    }
}
