//! The address that gets the message about a job's end. It is parsed once, strictly: a text that one reader
//! takes for a name and another for an address is refused.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};
use std::str::FromStr;

use thiserror::Error;

/// Longest address \[bytes\].
const MAX_URL: usize = 2048;
/// Longest name of a host \[bytes\] (RFC 1035 §2.3.4).
const MAX_NAME: usize = 253;
/// Longest part of such a name between two dots.
const MAX_LABEL: usize = 63;

/// A host.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Host {
    /// A name, lower case, without the dot at its end.
    Name(String),
    /// An address.
    Address(IpAddr),
}

/// A valid address for webhooks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CallbackUrl {
    /// Whether the connection uses TLS.
    pub is_https: bool,
    /// Host to call.
    pub host: Host,
    /// Port to call.
    pub port: u16,
    /// Host and port as they were written.
    pub authority: String,
    /// Path and query; begins with a slash.
    pub path_and_query: String,
}

/// Why an address cannot be called.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum CallbackFault {
    /// No scheme.
    #[error("not an absolute address; begin it with https://")]
    Relative,
    /// The scheme is not supported.
    #[error("only http and https addresses can be called")]
    Scheme,
    /// Too long.
    #[error("longer than {MAX_URL} bytes")]
    Length,
    /// A fragment.
    #[error("an address with a fragment (#…) cannot be called; remove the fragment")]
    Fragment,
    /// A user name or a password.
    #[error("an address with a user name or a password is not accepted; remove them")]
    User,
    /// A character that an address must not have.
    #[error("not an address: percent-encode characters outside ASCII, spaces and similar characters")]
    Characters,
    /// No host.
    #[error("the host is missing, or it is neither a name nor an IP address")]
    Host,
    /// A number that some readers take for an IP address.
    #[error("an IPv4 address is written as four decimal numbers without leading zeros")]
    Number,
    /// The port is not valid.
    #[error("a port is a number between 1 and 65535")]
    Port,
}

impl FromStr for CallbackUrl {
    type Err = CallbackFault;

    fn from_str(url: &str) -> Result<Self, CallbackFault> {
        let (scheme, rest) = url.split_once("://").ok_or(CallbackFault::Relative)?;
        let is_https = match scheme.to_ascii_lowercase().as_str() {
            "http" => false,
            "https" => true,
            _ => return Err(CallbackFault::Scheme),
        };
        if url.len() > MAX_URL {
            return Err(CallbackFault::Length);
        }
        if url.contains('#') {
            return Err(CallbackFault::Fragment);
        }
        let (authority, rest) = rest.split_at(rest.find(['/', '?']).unwrap_or(rest.len()));
        if authority.contains('@') {
            return Err(CallbackFault::User);
        }
        if !url.bytes().all(|byte| byte.is_ascii_graphic() && !b"\"<>\\^`{|}".contains(&byte)) {
            return Err(CallbackFault::Characters);
        }
        let (host, port) = host_and_port(authority)?;
        let port = match port {
            None if is_https => 443,
            None => 80,
            Some(digits) => port_of(digits).ok_or(CallbackFault::Port)?,
        };
        let slash = if rest.starts_with('/') { "" } else { "/" };
        Ok(Self {
            is_https,
            host,
            port,
            authority: authority.to_owned(),
            path_and_query: format!("{slash}{rest}"),
        })
    }
}

fn port_of(digits: &str) -> Option<u16> {
    let plain = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    digits.parse().ok().filter(|port| plain && *port > 0)
}

fn host_and_port(authority: &str) -> Result<(Host, Option<&str>), CallbackFault> {
    if let Some(rest) = authority.strip_prefix('[') {
        let (inside, port) = rest.split_once(']').ok_or(CallbackFault::Host)?;
        let address: Ipv6Addr = inside.parse().map_err(|_not_one| CallbackFault::Host)?;
        let port = match port.strip_prefix(':') {
            None if port.is_empty() => None,
            None => return Err(CallbackFault::Host),
            Some(port) => Some(port),
        };
        return Ok((Host::Address(address.into()), port));
    }
    let (host, port) = match authority.split_once(':') {
        None => (authority, None),
        Some((host, port)) => (host, Some(port)),
    };
    Ok((named(host)?, port))
}

/// A host without brackets.
fn named(text: &str) -> Result<Host, CallbackFault> {
    let name = text.strip_suffix('.').unwrap_or(text).to_ascii_lowercase();
    let letter = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_';
    let is_label = |label: &str| (1..=MAX_LABEL).contains(&label.len()) && label.bytes().all(letter);
    if name.len() > MAX_NAME || !name.split('.').all(is_label) {
        return Err(CallbackFault::Host);
    }
    // Many readers take a name that ends in a number for an address, in one of many forms (0x7f.1,
    // 017700000001, 2130706433).
    let last = name.rsplit('.').next().unwrap_or_default();
    let hexadecimal = last.strip_prefix("0x").is_some_and(|rest| rest.bytes().all(|b| b.is_ascii_hexdigit()));
    if hexadecimal || last.bytes().all(|byte| byte.is_ascii_digit()) {
        let address: Ipv4Addr = name.parse().map_err(|_other_form| CallbackFault::Number)?;
        return Ok(Host::Address(address.into()));
    }
    Ok(Host::Name(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(url: &str) -> Result<CallbackUrl, CallbackFault> {
        url.parse()
    }

    #[test]
    fn an_address_is_taken_apart() {
        let url = read("HTTPS://MES.Example.com.:8443?line=4&x=%20").unwrap();
        assert!(url.is_https);
        assert_eq!(url.host, Host::Name("mes.example.com".to_owned()));
        assert_eq!((url.port, url.authority.as_str()), (8443, "MES.Example.com.:8443"));
        assert_eq!(url.path_and_query, "/?line=4&x=%20");
        let plain = read("http://10.0.0.7/x").unwrap();
        assert_eq!((plain.port, plain.path_and_query.as_str()), (80, "/x"));
        assert_eq!(plain.host, Host::Address([10, 0, 0, 7].into()));
        assert_eq!(read("https://a").unwrap().port, 443);
        assert_eq!(read("http://[::1]:9/").unwrap().host, Host::Address(Ipv6Addr::LOCALHOST.into()));
    }

    #[test]
    fn only_addresses_that_can_be_called_are_taken() {
        for (url, fault) in [
            ("", CallbackFault::Relative),
            ("mes.example.com", CallbackFault::Relative),
            ("/jobs", CallbackFault::Relative),
            ("ftp://mes.example.com", CallbackFault::Scheme),
            ("http://", CallbackFault::Host),
            ("http:///x", CallbackFault::Host),
            ("http://:80", CallbackFault::Host),
            ("http://a..b", CallbackFault::Host),
            ("http://.a", CallbackFault::Host),
            ("http://a%2eb", CallbackFault::Host),
            ("http://a:0", CallbackFault::Port),
            ("http://a:", CallbackFault::Port),
            ("http://a:+80", CallbackFault::Port),
            ("http://a:65536", CallbackFault::Port),
            ("http://a:x", CallbackFault::Port),
            ("http://user:word@a", CallbackFault::User),
            ("http://a@b", CallbackFault::User),
            ("http://a/#end", CallbackFault::Fragment),
            ("http://a/b c", CallbackFault::Characters),
            ("http://a\\b", CallbackFault::Characters),
            ("http://[::1", CallbackFault::Host),
            ("http://[::1]x", CallbackFault::Host),
            ("http://[fe80::1%25eth0]/", CallbackFault::Host),
            ("http://[g]/", CallbackFault::Host),
            ("http://\u{e4}.example", CallbackFault::Characters),
            ("http://a\nb", CallbackFault::Characters),
        ] {
            assert_eq!(read(url), Err(fault), "{url}");
        }
        assert_eq!(read(&format!("http://a/{}", "x".repeat(MAX_URL))), Err(CallbackFault::Length));
        assert_eq!(read(&format!("http://{}/", "x".repeat(64))), Err(CallbackFault::Host));
    }

    #[test]
    fn a_number_is_an_address_in_one_form_only() {
        for host in
            ["2130706433", "0x7f000001", "017700000001", "127.1", "0177.0.0.1", "0x7f.0.0.1", "1.2.3.04"]
        {
            assert_eq!(read(&format!("http://{host}/")), Err(CallbackFault::Number), "{host}");
            assert_eq!(read(&format!("http://{host}./")), Err(CallbackFault::Number), "{host}.");
        }
        assert_eq!(read("http://127.0.0.1.:80").unwrap().host, Host::Address([127, 0, 0, 1].into()));
        assert!(matches!(read("http://line4.plant").unwrap().host, Host::Name(_)));
    }
}
