//! Headers of every answer that protect it in a browser: its type, who may frame it, what may run in it, who may
//! cache it.

use axum::response::Response;
use http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, ETAG, REFERRER_POLICY, STRICT_TRANSPORT_SECURITY,
    VARY, X_CONTENT_TYPE_OPTIONS,
};
use http::{HeaderName, HeaderValue};

/// No scripts, no loading, no framing.
const OF_DATA: HeaderValue = HeaderValue::from_static(
    "default-src 'none'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
);
/// The same for figures and reports, which contain their styles and figures.
const OF_PAGES: HeaderValue = HeaderValue::from_static(
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
);
/// The pages of the interface's description run their own scripts and send requests to this service.
const OF_DOCS: HeaderValue = HeaderValue::from_static(
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; font-src 'self'; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
);
/// The page runs only its own scripts and styles, sends requests only to this service, and shows figures that it
/// fetched.
const OF_THE_PAGE: HeaderValue = HeaderValue::from_static(
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
);
/// For a year, a browser uses only TLS for this service.
const FOR_A_YEAR: HeaderValue = HeaderValue::from_static("max-age=31536000");
const RESOURCE_POLICY: HeaderName = HeaderName::from_static("cross-origin-resource-policy");

/// Adds the protecting headers to an answer. `route` is the pattern that the request matched.
pub(super) fn guard_answer(response: &mut Response, route: Option<&str>, tls: bool) {
    let is_docs = route.is_some_and(|route| route.starts_with("/docs"));
    let is_page = route.is_some_and(|route| route == "/" || route.starts_with("/page/"));
    let status = response.status();
    let headers = response.headers_mut();
    let kind = headers.get(CONTENT_TYPE).map_or(&b""[..], HeaderValue::as_bytes);
    let policy = if is_docs && status.is_success() {
        OF_DOCS
    } else if is_page && status.is_success() && !kind.starts_with(b"application/json") {
        OF_THE_PAGE
    } else if kind.starts_with(b"text/html") || kind.starts_with(b"image/svg+xml") {
        OF_PAGES
    } else {
        OF_DATA
    };
    headers.insert(CONTENT_SECURITY_POLICY, policy);
    headers.insert(X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff"));
    headers.insert(REFERRER_POLICY, HeaderValue::from_static("no-referrer"));
    headers.insert(RESOURCE_POLICY, HeaderValue::from_static("same-origin"));
    if tls {
        headers.insert(STRICT_TRANSPORT_SECURITY, FOR_A_YEAR);
    }
    if !headers.contains_key(CACHE_CONTROL) {
        // A client may cache an answer with a tag, but must revalidate it before use; nothing else is cached.
        let is_kept = headers.contains_key(ETAG);
        let kept = if is_kept { "private, no-cache" } else { "no-store" };
        headers.insert(CACHE_CONTROL, HeaderValue::from_static(kept));
        // Most answers have several representations, and each has its own tag.
        if is_kept && !headers.contains_key(VARY) {
            headers.insert(VARY, HeaderValue::from_static("accept"));
        }
    }
}

#[cfg(test)]
mod tests {
    use axum::body::Body;
    use http::StatusCode;

    use super::*;

    fn guarded(kind: &'static str, tag: Option<&'static str>, route: &str, tls: bool) -> Response {
        let answer = Response::builder().status(StatusCode::OK).header(CONTENT_TYPE, kind);
        let answer = match tag {
            Some(tag) => answer.header(ETAG, tag),
            None => answer,
        };
        let mut answer = answer.body(Body::empty()).unwrap();
        guard_answer(&mut answer, Some(route), tls);
        answer
    }

    #[test]
    fn what_may_run_goes_by_what_is_shown() {
        for (kind, route, policy) in [
            ("application/json", "/v1/jobs", &OF_DATA),
            ("image/svg+xml", "/v1/jobs/{id}/plot", &OF_PAGES),
            ("text/html; charset=utf-8", "/problems", &OF_PAGES),
            ("text/html", "/docs/", &OF_DOCS),
            ("text/html; charset=utf-8", "/", &OF_THE_PAGE),
            ("text/javascript", "/page/{name}", &OF_THE_PAGE),
            ("application/json", "/", &OF_DATA),
        ] {
            let answer = guarded(kind, None, route, false);
            assert_eq!(answer.headers()[CONTENT_SECURITY_POLICY], policy, "{route}");
            assert!(policy.to_str().unwrap().contains("frame-ancestors 'none'"));
            assert!(!answer.headers().contains_key(STRICT_TRANSPORT_SECURITY));
        }
        assert!(
            guarded("application/json", None, "/v1/jobs", true)
                .headers()
                .contains_key(STRICT_TRANSPORT_SECURITY)
        );
    }

    #[test]
    fn what_has_a_tag_is_asked_for_again_and_nothing_else_is_kept() {
        let tagged = guarded("a/b", Some("\"x\""), "/", false);
        assert_eq!(
            (&tagged.headers()[CACHE_CONTROL], &tagged.headers()[VARY]),
            (&HeaderValue::from_static("private, no-cache"), &HeaderValue::from_static("accept"))
        );
        let untagged = guarded("a/b", None, "/", false);
        assert_eq!(untagged.headers()[CACHE_CONTROL], "no-store");
        assert!(!untagged.headers().contains_key(VARY));
    }
}
