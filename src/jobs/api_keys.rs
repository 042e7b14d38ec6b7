//! API keys: how the service creates a key, and how it recognises the key of a request.

use std::collections::{BTreeSet, HashMap};
use std::fmt::Write;
use std::sync::Arc;

use jiff::Timestamp;
use subtle::ConstantTimeEq;
use thiserror::Error;

use super::{Sources, time_bound};
use crate::store::{ApiKeyRow, sha256_hex};
use crate::wire::{ApiKeyDocument, ApiKeyRequest, Fault, FaultList, Scope};

/// The prefix of every key, so that people and scanners recognise it.
const PREFIX: &str = "trn_";
/// Random bytes of a key's id, which is not secret.
const ID_BYTES: usize = 6;
/// Random bytes of a key's secret: 256 bits.
const SECRET_BYTES: usize = 32;

/// A key that was just created.
#[derive(Debug)]
pub struct IssuedKey {
    /// The row to store.
    pub row: ApiKeyRow,
    /// The whole key, for its user; it is not stored.
    pub key: String,
}

/// Why no key was created.
#[derive(Debug, Error)]
pub enum IssueFault {
    /// The request is not valid.
    #[error("{}", .0.iter().map(|fault| format!("{}: {}", fault.pointer, fault.detail)).collect::<Vec<_>>().join("; "))]
    Invalid(Vec<Fault>),
    /// The system provides no random numbers.
    #[error("the system provides no random numbers: {0}")]
    NoRandomness(getrandom::Error),
}

/// Creates a key.
///
/// # Errors
/// Every fault of the request, or a system without random numbers.
pub fn issue_key(request: &ApiKeyRequest, sources: &Sources) -> Result<IssuedKey, IssueFault> {
    let mut faults = FaultList::default();
    request.check(&mut faults);
    let created_at = sources.timestamp();
    let expires_at = match request.expires_at.as_deref().map(|text| time_bound("/expires_at", text)) {
        None => None,
        Some(Ok(end)) => {
            if end <= created_at {
                faults.push(|| {
                    Fault::new(
                        "/expires_at",
                        format!("{end} is not in the future; give a later time, or leave it out"),
                    )
                });
            }
            Some(end)
        }
        Some(Err(fault)) => {
            faults.push(|| fault);
            None
        }
    };
    faults.into_result().map_err(IssueFault::Invalid)?;
    let id = random_hex::<ID_BYTES>()?;
    let secret = random_hex::<SECRET_BYTES>()?;
    let document = ApiKeyDocument {
        id,
        name: request.name.clone(),
        scopes: request.scopes.clone(),
        machines: request.machines.clone(),
        created_at,
        expires_at,
        revoked_at: None,
        last_used_at: None,
    };
    let key = format!("{PREFIX}{}_{secret}", document.id);
    Ok(IssuedKey { row: ApiKeyRow { document, secret_sha256: sha256_hex(secret.as_bytes()) }, key })
}

fn random_hex<const BYTES: usize>() -> Result<String, IssueFault> {
    let mut bytes = [0; BYTES];
    getrandom::fill(&mut bytes).map_err(IssueFault::NoRandomness)?;
    let mut text = String::with_capacity(2 * BYTES);
    for byte in bytes {
        // Writing into a string cannot fail.
        let _written = write!(text, "{byte:02x}");
    }
    Ok(text)
}

/// Id and secret of a key's text.
fn parts_of_key(text: &str) -> Option<(&str, &str)> {
    text.strip_prefix(PREFIX)?.split_once('_')
}

/// The id in a key's text. It does not check whether this service has such a key.
#[must_use]
pub fn key_id_of(text: &str) -> Option<&str> {
    parts_of_key(text).map(|(id, _secret)| id)
}

/// All keys, ready for look-up.
#[derive(Debug, Default)]
pub struct KeyRing {
    keys: HashMap<String, HeldKey>,
}

/// The data of a key that requests are checked against.
#[derive(Debug)]
pub struct HeldKey {
    /// Its id.
    pub id: Arc<str>,
    /// Its scopes.
    pub scopes: Arc<BTreeSet<Scope>>,
    /// The only machines that the key reaches; `None` for all.
    pub machines: Option<Arc<BTreeSet<String>>>,
    secret_sha256: String,
    expires_at: Option<String>,
    revoked_at: Option<String>,
}

/// Why a key is not valid.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum KeyRefusal {
    /// It is not, and never was, a key of this service.
    #[error("this service does not know the key")]
    Unknown,
    /// It was revoked.
    #[error("the key was revoked at {at}")]
    Revoked {
        /// Time of the revocation.
        at: String,
    },
    /// The key has expired.
    #[error("the key expired at {at}")]
    Expired {
        /// Time of the expiry.
        at: String,
    },
}

impl KeyRing {
    /// The ring with these keys.
    #[must_use]
    pub fn of(rows: Vec<ApiKeyRow>) -> Self {
        let held = |ApiKeyRow { document, secret_sha256 }| {
            let id: Arc<str> = document.id.as_str().into();
            let key = HeldKey {
                id,
                scopes: Arc::new(document.scopes),
                machines: document.machines.map(Arc::new),
                secret_sha256,
                expires_at: document.expires_at,
                revoked_at: document.revoked_at,
            };
            (document.id, key)
        };
        Self { keys: rows.into_iter().map(held).collect() }
    }

    /// Whether no key was ever created: the service is open then. A service whose keys were all revoked stays closed.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.keys.is_empty()
    }

    /// Whether a client that was admitted with this key, or without a key, would still be admitted.
    #[must_use]
    pub fn still_opens(&self, id: Option<&str>, now: impl FnOnce() -> Timestamp) -> bool {
        let Some(id) = id else { return self.is_empty() };
        self.keys.get(id).is_some_and(|key| {
            let ended = || key.expires_at.as_ref().is_some_and(|at| super::timestamp(now()) >= *at);
            key.revoked_at.is_none() && !ended()
        })
    }

    /// The key with this text. A client without the secret learns nothing about the key, neither from the answer nor
    /// from its time.
    ///
    /// # Errors
    /// The key is unknown, or no longer valid.
    pub fn find(&self, text: &str, now: impl FnOnce() -> Timestamp) -> Result<&HeldKey, KeyRefusal> {
        let (id, secret) = parts_of_key(text).ok_or(KeyRefusal::Unknown)?;
        let digest = sha256_hex(secret.as_bytes());
        let held = self.keys.get(id);
        let kept = held.map_or("", |key| key.secret_sha256.as_str());
        if !bool::from(digest.as_bytes().ct_eq(kept.as_bytes())) {
            return Err(KeyRefusal::Unknown);
        }
        let key = held.ok_or(KeyRefusal::Unknown)?;
        if let Some(at) = key.revoked_at.clone() {
            return Err(KeyRefusal::Revoked { at });
        }
        if let Some(at) = key.expires_at.clone()
            && super::timestamp(now()) >= at
        {
            return Err(KeyRefusal::Expired { at });
        }
        Ok(key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request() -> ApiKeyRequest {
        ApiKeyRequest {
            name: "MES".to_owned(),
            scopes: [Scope::Read].into(),
            machines: None,
            expires_at: Some("2099-01-01T00:00:00Z".to_owned()),
        }
    }

    fn at(text: &str) -> Timestamp {
        text.parse().unwrap()
    }

    #[test]
    fn a_key_opens_with_its_whole_text_and_with_nothing_else() {
        let IssuedKey { row, key } = issue_key(&request(), &Sources::real()).unwrap();
        let (id, secret) = (row.document.id.clone(), key.rsplit('_').next().unwrap().to_owned());
        assert_eq!((id.len(), secret.len()), (12, 64));
        assert!(!format!("{row:?}").contains(&secret));
        let ring = KeyRing::of(vec![row]);
        let now = || at("2098-12-31T23:59:59.999Z");
        assert_eq!(&*ring.find(&key, now).unwrap().id, id);
        let other = issue_key(&request(), &Sources::real()).unwrap();
        let other_secret = other.key.rsplit('_').next().unwrap();
        for wrong in [
            String::new(),
            id.clone(),
            secret.clone(),
            format!("trn_{id}"),
            format!("trn_{id}_"),
            format!("trn_{id}_{}", &secret[1..]),
            format!("trn_{id}_{secret}0"),
            format!("trn_{id}_{}", secret.to_uppercase() + "A"),
            format!("trn_{id}_{other_secret}"),
            format!("TRN_{id}_{secret}"),
            format!("trn__{secret}"),
            other.key.clone(),
        ] {
            assert_eq!(ring.find(&wrong, now).unwrap_err(), KeyRefusal::Unknown, "{wrong}");
        }
    }

    #[test]
    fn a_key_ends_at_its_time_and_at_its_revocation() {
        let IssuedKey { mut row, key } = issue_key(&request(), &Sources::real()).unwrap();
        let ring = KeyRing::of(vec![row.clone()]);
        let end = "2099-01-01T00:00:00.000Z".to_owned();
        assert_eq!(ring.find(&key, || at(&end)).unwrap_err(), KeyRefusal::Expired { at: end.clone() });
        row.document.revoked_at = Some("2026-01-01T00:00:00.000Z".to_owned());
        let ring = KeyRing::of(vec![row]);
        assert!(!ring.is_empty());
        assert!(matches!(ring.find(&key, || at(&end)), Err(KeyRefusal::Revoked { .. })));
        // A client without the secret does not learn that the key was revoked.
        let guess = format!("{}0", &key[..key.len() - 1]);
        assert!(guess == key || ring.find(&guess, || at(&end)).unwrap_err() == KeyRefusal::Unknown);
    }

    #[test]
    fn everything_that_is_wrong_with_a_key_is_named_at_once() {
        let wrong = ApiKeyRequest {
            name: " ".to_owned(),
            scopes: [Scope::Admin].into(),
            machines: Some(["a".to_owned(), "A!".to_owned()].into()),
            expires_at: Some("1999-01-01T00:00:00Z".to_owned()),
        };
        let Err(IssueFault::Invalid(faults)) = issue_key(&wrong, &Sources::real()) else { panic!("issued") };
        let pointers: Vec<_> = faults.iter().map(|fault| fault.pointer.as_str()).collect();
        assert_eq!(pointers, ["/name", "/machines", "/machines/0", "/expires_at"]);
        let nothing = ApiKeyRequest { scopes: BTreeSet::new(), machines: Some(BTreeSet::new()), ..request() };
        assert!(
            matches!(issue_key(&nothing, &Sources::real()), Err(IssueFault::Invalid(two)) if two.len() == 2)
        );
    }
}
