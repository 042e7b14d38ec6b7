//! The host name of a request: it has exactly one. With two, a proxy in front of the service and the service itself
//! could use different ones.

use axum::extract::Request;
use http::Version;
use http::header::HOST;
use http::uri::Authority;

use super::problem::{Problem, ProblemType};

/// Refuses a request without one clear host (RFC 9112 §3.2, RFC 9113 §8.3.1).
///
/// # Errors
/// An HTTP/1.1 request without `Host`; `Host` twice; a `Host` that is not a host with an optional port, or that names
/// a user, or that contradicts the authority in the request's target.
pub(super) fn one_host(request: &Request) -> Result<(), Problem> {
    let refuse = |detail: &str| Err(Problem::new(ProblemType::MalformedRequest, detail));
    let target = request.uri().authority();
    let mut fields = request.headers().get_all(HOST).iter();
    let Some(field) = fields.next() else {
        return if request.version() == Version::HTTP_11 && target.is_none() {
            refuse("the request has no Host field; HTTP/1.1 needs one")
        } else {
            Ok(())
        };
    };
    if fields.next().is_some() {
        return refuse("the request has several Host fields; send one");
    }
    // A target without an authority has an empty one.
    if field.is_empty() && target.is_none() {
        return Ok(());
    }
    if target.is_none() && is_plain(field.as_bytes()) {
        return Ok(());
    }
    let Ok(host) = Authority::try_from(field.as_bytes()) else {
        return refuse("the Host field is not a host with an optional port");
    };
    if host.as_str().contains(',') {
        return refuse("the Host field names several hosts; send one");
    }
    let behind = host.as_str().strip_prefix(host.host()).unwrap_or_default();
    if behind.len() > 1 && host.port_u16().is_none() && !host.as_str().contains('@') {
        return refuse("the port of the Host field is not a number up to 65535");
    }
    if host.as_str().contains('@') {
        return refuse("the Host field names a user; send only the host and its port");
    }
    if target.is_some_and(|target| !target.as_str().eq_ignore_ascii_case(host.as_str())) {
        return refuse("the Host field and the address of the request name different hosts");
    }
    Ok(())
}

/// Whether this is a plain name or an IPv4 address, and perhaps a port. Nearly every host is, and needs no further check.
fn is_plain(host: &[u8]) -> bool {
    let mut parts = host.splitn(2, |byte| *byte == b':');
    let name = parts.next().unwrap_or_default();
    let port = parts.next();
    let is_port = |port: &[u8]| {
        (1..=5).contains(&port.len())
            && port.iter().all(u8::is_ascii_digit)
            && port.iter().fold(0, |number, digit| 10 * number + u32::from(digit - b'0')) <= u16::MAX.into()
    };
    !name.is_empty()
        && name.iter().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'-'))
        && port.is_none_or(is_port)
}

#[cfg(test)]
mod tests {
    use axum::body::Body;

    use super::*;

    fn asked(version: Version, target: &str, hosts: &[&str]) -> bool {
        let request = Request::builder().version(version).uri(target);
        let request = hosts.iter().fold(request, |request, host| request.header(HOST, *host));
        one_host(&request.body(Body::empty()).unwrap()).is_ok()
    }

    #[test]
    fn a_request_has_exactly_one_host() {
        for (target, hosts) in [
            ("/", &["127.0.0.1:8080"][..]),
            ("/", &["[::1]:8080"]),
            ("/", &["mill-3.plant.example:65535"]),
            ("/", &["mill-3:"]),
            ("/", &[""]),
            ("http://mill-3/v1", &["mill-3"]),
            ("http://MILL-3/v1", &["mill-3"]),
        ] {
            assert!(asked(Version::HTTP_11, target, hosts), "{target} {hosts:?}");
        }
        for (target, hosts) in [
            ("/", &[][..]),
            ("/", &["mill-3", "mill-3"]),
            ("/", &["mill-3", "evil"]),
            ("/", &["user@mill-3"]),
            ("/", &["mill 3"]),
            ("/", &["mill-3/x"]),
            ("/", &["mill-3,evil"]),
            ("/", &["mill-3:8080,evil"]),
            ("/", &["mill-3:99999"]),
            ("/", &["mill-3:65536"]),
            ("/", &["mill-3:80:80"]),
            ("/", &["mill-3:8 0"]),
            ("/", &["m\u{fc}hle"]),
            ("http://mill-3/", &["evil"]),
            ("http://mill-3/", &[""]),
        ] {
            assert!(!asked(Version::HTTP_11, target, hosts), "{target} {hosts:?}");
        }
        assert!(asked(Version::HTTP_2, "http://mill-3/", &[]));
        assert!(!asked(Version::HTTP_2, "http://mill-3/", &["evil"]));
        assert!(asked(Version::HTTP_10, "/", &[]));
    }
}
