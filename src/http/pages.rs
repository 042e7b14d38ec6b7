//! Requests from pages of other sites. A service without keys trusts every program on its computer, and a browser is
//! one of them: any page could make it send requests here. Headers of browsers show such requests.

use std::net::{IpAddr, SocketAddrV4};

use axum::extract::Request;
use http::header::{HOST, ORIGIN};
use http::uri::Authority;
use http::{HeaderMap, HeaderName, Method};

use super::problem::{Problem, ProblemType};

/// Header in which a browser says from which site a request comes.
const FETCH_SITE: HeaderName = HeaderName::from_static("sec-fetch-site");

/// Refuses requests that a page of another site sends to a service without keys on a loopback address.
///
/// There are two checks. First, a foreign name may resolve to a loopback address (DNS rebinding), and then the page
/// would count as belonging to this site. So the service answers only to addresses, to `localhost` and to names
/// without a dot, which nobody can register. Second, a request that is not a plain read must not come from a page of
/// another site (Fetch Metadata; for older browsers, `Origin`).
///
/// # Errors
/// The request comes from a page of another site.
pub(super) fn from_here(request: &Request) -> Result<(), Problem> {
    let authority = request.uri().authority().map(Authority::as_str);
    let host = text(request.headers(), &HOST).or(authority);
    if let Some(host) = host.filter(|host| !is_this_computer(host)) {
        let detail = format!(
            "without API keys the service answers only to IP addresses and to localhost, not to the name {host:?}"
        );
        return Err(Problem::new(ProblemType::ForeignPage, detail));
    }
    if request.method() == Method::GET || request.method() == Method::HEAD {
        return Ok(());
    }
    let foreign = match (text(request.headers(), &FETCH_SITE), text(request.headers(), &ORIGIN)) {
        (Some(site), _) => site != "same-origin" && site != "none",
        (None, Some(origin)) => origin.split_once("://").map(|(_, of)| of) != host,
        (None, None) => false,
    };
    if foreign {
        let detail = "without API keys the service accepts nothing from a page of another site";
        return Err(Problem::new(ProblemType::ForeignPage, detail));
    }
    Ok(())
}

/// A header's value; empty if it is not text.
fn text<'a>(headers: &'a HeaderMap, name: &HeaderName) -> Option<&'a str> {
    headers.get(name).map(|value| value.to_str().unwrap_or_default())
}

/// Whether an authority is an address or a name that belongs to this computer (`localhost`: RFC 6761 §6.3).
fn is_this_computer(authority: &str) -> bool {
    // An IPv4 address with a port is the most common form, and quick to check.
    if authority.parse::<SocketAddrV4>().is_ok() {
        return true;
    }
    let name = match authority.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        Some((inside, _port)) => inside,
        None => authority.split_once(':').map_or(authority, |(name, _port)| name),
    };
    let name = name.trim_end_matches('.');
    let last = name.rsplit_once('.').map(|(_, last)| last);
    last.is_none_or(|last| last.eq_ignore_ascii_case("localhost")) || name.parse::<IpAddr>().is_ok()
}

#[cfg(test)]
mod tests {
    use super::is_this_computer;

    #[test]
    fn addresses_and_localhost_are_this_computer() {
        for here in [
            "127.0.0.1:8080",
            "127.0.0.1",
            "[::1]:8080",
            "[::1]",
            "localhost:1",
            "LocalHost",
            "a.localhost.",
            "mill-3:80",
        ] {
            assert!(is_this_computer(here), "{here}");
        }
        for other in
            ["evil.example:8080", "localhost.evil.example", "127.0.0.1.evil.example", "evil.xlocalhost"]
        {
            assert!(!is_this_computer(other), "{other}");
        }
    }
}
