//! Receivers of webhooks that are allowed although they are not public: networks and names.

use std::fmt;
use std::net::IpAddr;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A network (`10.0.0.0/8`, `fd12::/16`, a single address) or a name (`mes.plant.local`, `*.plant.local`).
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct AllowedReceiver {
    text: String,
    kind: Kind,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Kind {
    /// Addresses with these leading bits; IPv4 addresses are mapped to IPv6.
    Network { bits: u128, length: u32 },
    /// Exactly this name.
    Name(String),
    /// Every name with this ending, which begins with a dot.
    Below(String),
}

/// A text that is neither a network nor a name.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("neither a network such as 10.0.0.0/8 nor a name such as mes.plant.local or *.plant.local")]
pub struct NoReceiver;

/// Bits of an IPv6 address before the IPv4 address that it maps.
const MAPPED_PREFIX: u32 = 96;

fn bits(address: IpAddr) -> u128 {
    match address {
        IpAddr::V4(address) => address.to_ipv6_mapped().to_bits(),
        IpAddr::V6(address) => address.to_bits(),
    }
}

fn mask(length: u32) -> u128 {
    u128::MAX.checked_shl(128 - length.min(128)).unwrap_or(0)
}

impl FromStr for AllowedReceiver {
    type Err = NoReceiver;

    fn from_str(text: &str) -> Result<Self, NoReceiver> {
        let text = text.trim().to_ascii_lowercase();
        let kind = network(&text).or_else(|| name(&text)).ok_or(NoReceiver)?;
        Ok(Self { text, kind })
    }
}

fn network(text: &str) -> Option<Kind> {
    let (address, length) = match text.split_once('/') {
        Some((address, length)) => (address, Some(length.parse::<u32>().ok()?)),
        None => (text, None),
    };
    let address: IpAddr = address.trim_matches(['[', ']']).parse().ok()?;
    let (before, most) = if address.is_ipv4() { (MAPPED_PREFIX, 32) } else { (0, 128) };
    let length = length.unwrap_or(most);
    if length > most {
        return None;
    }
    let length = before + length;
    Some(Kind::Network { bits: bits(address) & mask(length), length })
}

fn name(text: &str) -> Option<Kind> {
    let (below, rest) = match text.strip_prefix("*.") {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let rest = rest.strip_suffix('.').unwrap_or(rest);
    let letter = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_';
    // A text that ends in a digit is a wrongly written network.
    let last = rest.rsplit('.').next()?;
    if last.bytes().all(|byte| byte.is_ascii_digit())
        || !rest.split('.').all(|label| !label.is_empty() && label.bytes().all(letter))
    {
        return None;
    }
    Some(if below { Kind::Below(format!(".{rest}")) } else { Kind::Name(rest.to_owned()) })
}

impl AllowedReceiver {
    /// Whether webhooks may be sent to this address.
    #[must_use]
    pub fn has_address(&self, address: IpAddr) -> bool {
        match self.kind {
            Kind::Network { bits: own, length } => bits(address) & mask(length) == own,
            Kind::Name(_) | Kind::Below(_) => false,
        }
    }

    /// Whether webhooks may be sent to this name (lower case, without a dot at its end), whatever its
    /// address.
    #[must_use]
    pub fn has_name(&self, name: &str) -> bool {
        match &self.kind {
            Kind::Network { .. } => false,
            Kind::Name(own) => own == name,
            Kind::Below(end) => name.ends_with(end.as_str()),
        }
    }
}

impl fmt::Display for AllowedReceiver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl TryFrom<String> for AllowedReceiver {
    type Error = NoReceiver;

    fn try_from(text: String) -> Result<Self, NoReceiver> {
        text.parse()
    }
}

impl From<AllowedReceiver> for String {
    fn from(receiver: AllowedReceiver) -> Self {
        receiver.text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn allowed(text: &str) -> AllowedReceiver {
        text.parse().unwrap()
    }

    #[test]
    fn a_network_has_its_addresses_and_no_others() {
        for (network, within, outside) in [
            ("10.0.0.0/8", "10.255.255.255", "11.0.0.0"),
            ("10.1.2.3/8", "10.0.0.0", "9.255.255.255"),
            ("192.168.7.4", "192.168.7.4", "192.168.7.5"),
            ("0.0.0.0/0", "255.1.2.3", "::1"),
            ("fd00::/8", "fdff::1", "fe00::"),
            ("::1", "::1", "::2"),
            ("::/0", "1.2.3.4", ""),
            ("10.0.0.0/8", "::ffff:10.1.1.1", "::10.1.1.1"),
        ] {
            assert!(allowed(network).has_address(within.parse().unwrap()), "{network} {within}");
            if !outside.is_empty() {
                assert!(!allowed(network).has_address(outside.parse().unwrap()), "{network} {outside}");
            }
        }
    }

    #[test]
    fn a_name_is_itself_and_a_star_is_what_stands_below() {
        assert!(allowed("MES.plant.local.").has_name("mes.plant.local"));
        assert!(!allowed("mes.plant.local").has_name("x.mes.plant.local"));
        assert!(allowed("*.plant.local").has_name("x.mes.plant.local"));
        assert!(!allowed("*.plant.local").has_name("plant.local"));
        assert!(!allowed("*.plant.local").has_name("anotherplant.local"));
        assert!(!allowed("mes").has_address([10, 0, 0, 1].into()));
        assert!(!allowed("10.0.0.1").has_name("10.0.0.1"));
    }

    #[test]
    fn what_is_neither_is_refused() {
        for text in [
            "",
            "10.0.0.0/33",
            "10.0.0/8",
            "::/129",
            "a b",
            "*",
            "*.",
            "a..b",
            "http://mes",
            "mes:80",
            "127.1",
        ] {
            assert_eq!(text.parse::<AllowedReceiver>(), Err(NoReceiver), "{text}");
        }
    }
}
