//! The transfer coding of a body: none, or `chunked`. A proxy that reads another coding would see other requests than
//! the service.

use axum::extract::Request;
use http::header::TRANSFER_ENCODING;

use super::problem::{Problem, ProblemType};

/// Refuses a body with a transfer coding other than a single `chunked` (RFC 9112 §6.1). If a request also has
/// `Content-Length`, the layer below drops that field and closes the connection after the answer.
///
/// # Errors
/// `Transfer-Encoding` names another coding.
pub(super) fn chunked_or_plain(request: &Request) -> Result<(), Problem> {
    let mut codings = request.headers().get_all(TRANSFER_ENCODING).iter();
    let Some(coding) = codings.next() else { return Ok(()) };
    if codings.next().is_some() || !coding.as_bytes().trim_ascii().eq_ignore_ascii_case(b"chunked") {
        return Err(Problem::new(
            ProblemType::MalformedRequest,
            "the body has a transfer coding other than chunked; name its coding in Content-Encoding",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use axum::body::Body;

    use super::*;

    fn has_chunked_or_plain(fields: &[(&str, &str)]) -> bool {
        let request =
            fields.iter().fold(Request::builder(), |request, (name, value)| request.header(*name, *value));
        chunked_or_plain(&request.body(Body::empty()).unwrap()).is_ok()
    }

    #[test]
    fn the_only_coding_is_one_chunked() {
        for fields in [
            &[][..],
            &[("content-length", "7")],
            &[("transfer-encoding", "chunked")],
            &[("transfer-encoding", " Chunked ")],
        ] {
            assert!(has_chunked_or_plain(fields), "{fields:?}");
        }
        for fields in [
            &[("transfer-encoding", "gzip, chunked")][..],
            &[("transfer-encoding", "chunked, chunked")],
            &[("transfer-encoding", "gzip"), ("transfer-encoding", "chunked")],
            &[("transfer-encoding", "identity")],
            &[("transfer-encoding", "")],
        ] {
            assert!(!has_chunked_or_plain(fields), "{fields:?}");
        }
    }
}
