//! Addresses that the service is asked to call.

use std::str::FromStr;

use crate::wire::{CallbackUrl, Host, path_segment};

/// An address that is taken means the same host, port and path to another reader: a check of the one must not be passed
/// round by the other.
pub fn address(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let segment = path_segment(text);
    let joined = url::Url::parse("http://h/a/").and_then(|base| base.join(&format!("./{segment}")));
    if !text.is_empty() && text != "." && text != ".." {
        let joined = joined.expect("a segment of a path");
        let last = joined.path_segments().and_then(Iterator::last).unwrap_or_default();
        assert_eq!(joined.path_segments().map(Iterator::count), Some(2), "{text:?} became {joined}");
        assert_eq!(percent_decoded(last), text.as_bytes(), "{text:?} became {last}");
    }
    let Ok(ours) = CallbackUrl::from_str(text) else { return };
    let theirs = url::Url::parse(text).expect("an address that we take is one");
    let host = match &ours.host {
        Host::Name(name) => name.clone(),
        Host::Address(address) if address.is_ipv6() => format!("[{address}]"),
        Host::Address(address) => address.to_string(),
    };
    let other = theirs.host_str().unwrap_or_default().trim_end_matches('.').to_owned();
    assert_eq!(host, other, "{text}");
    assert_eq!(Some(ours.port), theirs.port_or_known_default(), "{text}");
    assert_eq!(ours.is_https, theirs.scheme() == "https", "{text}");
    assert_eq!(theirs.username(), "", "{text}");
}

fn percent_decoded(text: &str) -> Vec<u8> {
    let mut out = Vec::new();
    let mut bytes = text.bytes();
    while let Some(byte) = bytes.next() {
        if byte == b'%' {
            let digits = [bytes.next().expect("a digit"), bytes.next().expect("a digit")];
            out.push(u8::from_str_radix(std::str::from_utf8(&digits).expect("digits"), 16).expect("digits"));
        } else {
            out.push(byte);
        }
    }
    out
}
