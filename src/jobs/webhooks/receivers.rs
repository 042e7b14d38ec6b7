//! Allowed receivers: the internet, and the receivers that the operator allows.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr};

use thiserror::Error;

use super::address::is_public;
use crate::config::AllowedReceiver;
use crate::wire::{CallbackUrl, Host};

/// The allowed receivers.
#[derive(Debug, Clone, Default)]
pub struct Receivers {
    allowed: Vec<AllowedReceiver>,
}

/// The address is not allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("not a public address; the operator of the service can allow it with the setting webhook_allow")]
pub struct NotAllowed;

impl Receivers {
    /// The internet and these receivers.
    #[must_use]
    pub fn new(allowed: Vec<AllowedReceiver>) -> Self {
        Self { allowed }
    }

    /// Whether webhooks may be sent to this address, as far as that is known without looking up its name.
    ///
    /// # Errors
    /// They may not.
    pub fn admit(&self, url: &CallbackUrl) -> Result<(), NotAllowed> {
        let may = match &url.host {
            Host::Address(address) => self.has_address(*address),
            // These names lead to this computer everywhere (RFC 6761 §6.3); others are looked up at the call.
            Host::Name(name) if is_local(name) => {
                let loopback = [Ipv4Addr::LOCALHOST.into(), Ipv6Addr::LOCALHOST.into()];
                self.has_name(name) || loopback.into_iter().any(|address| self.has_address(address))
            }
            Host::Name(_) => true,
        };
        if may { Ok(()) } else { Err(NotAllowed) }
    }

    /// The allowed addresses among those that were found for a host.
    pub(super) fn of(&self, host: &Host, mut found: Vec<IpAddr>) -> Vec<IpAddr> {
        let by_name = matches!(host, Host::Name(name) if self.has_name(name));
        found.retain(|address| by_name || self.has_address(*address));
        found
    }

    fn has_address(&self, address: IpAddr) -> bool {
        is_public(address) || self.allowed.iter().any(|receiver| receiver.has_address(address))
    }

    fn has_name(&self, name: &str) -> bool {
        self.allowed.iter().any(|receiver| receiver.has_name(name))
    }
}

fn is_local(name: &str) -> bool {
    ["localhost", "localhost.localdomain", "ip6-localhost", "ip6-loopback"].contains(&name)
        || name.ends_with(".localhost")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn receivers(allowed: &[&str]) -> Receivers {
        Receivers::new(allowed.iter().map(|text| text.parse().unwrap()).collect())
    }

    fn admits(receivers: &Receivers, url: &str) -> bool {
        receivers.admit(&url.parse().unwrap()).is_ok()
    }

    #[test]
    fn nothing_private_is_called_unless_it_is_allowed() {
        let strict = receivers(&[]);
        for url in ["https://mes.example.com", "http://9.9.9.9:8080/x", "http://[2606:4700::1111]/"] {
            assert!(admits(&strict, url), "{url}");
        }
        for url in [
            "http://127.0.0.1",
            "http://127.0.0.1./",
            "http://10.1.2.3",
            "http://[::1]",
            "http://[::ffff:9.9.9.9]",
            "http://localhost",
            "http://LocalHost./",
            "http://a.localhost",
        ] {
            assert!(!admits(&strict, url), "{url}");
        }
        let plant = receivers(&["10.0.0.0/8", "mes.plant", "127.0.0.0/8"]);
        assert!(admits(&plant, "http://10.1.2.3") && admits(&plant, "http://localhost:9"));
        assert!(admits(&plant, "http://[::ffff:10.1.2.3]") && !admits(&plant, "http://192.168.1.1"));
    }

    #[test]
    fn of_the_addresses_of_a_name_only_those_that_may_be_called_are_kept() {
        let found = || -> Vec<IpAddr> {
            ["10.0.0.1", "9.9.9.9", "::1", "169.254.169.254"].map(|text| text.parse().unwrap()).into()
        };
        let host = Host::Name("mes.plant".to_owned());
        let public: Vec<IpAddr> = vec!["9.9.9.9".parse().unwrap()];
        assert_eq!(receivers(&[]).of(&host, found()), public);
        assert_eq!(receivers(&["mes.plant"]).of(&host, found()), found());
        assert_eq!(receivers(&["*.plant"]).of(&host, found()), found());
        assert_eq!(receivers(&["other"]).of(&host, found()), public);
        assert_eq!(receivers(&["::1"]).of(&host, found()).len(), 2);
    }
}
