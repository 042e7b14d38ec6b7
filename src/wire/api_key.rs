//! API keys: what each key may do, for which machines, and until when.

use std::collections::BTreeSet;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::{Fault, FaultList};
use crate::description::ToSchema;

/// What a key allows. No scope includes another scope.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scope {
    /// Reads everything except keys and the audit log.
    Read,
    /// Computes, and creates and cancels jobs.
    Compute,
    /// Stores and deletes machines.
    Machines,
    /// Stores what was measured on machines and tools, and applies it.
    Calibrations,
    /// Creates, lists and revokes keys; reads the audit log.
    Admin,
}

impl Scope {
    /// Every scope.
    pub const ALL: [Self; 5] = [Self::Read, Self::Compute, Self::Machines, Self::Calibrations, Self::Admin];

    /// The word on the wire.
    #[must_use]
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Compute => "compute",
            Self::Machines => "machines",
            Self::Calibrations => "calibrations",
            Self::Admin => "admin",
        }
    }
}

impl fmt::Display for Scope {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// The word is not a scope.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the scopes are read, compute, machines, calibrations and admin")]
pub struct NoScope;

impl FromStr for Scope {
    type Err = NoScope;

    fn from_str(word: &str) -> Result<Self, NoScope> {
        Self::ALL.into_iter().find(|scope| scope.as_str() == word).ok_or(NoScope)
    }
}

/// An API key to create.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ApiKeyRequest {
    /// A name for people: who or what uses the key.
    #[schema(min_length = 1, max_length = 200, example = "MES of hall 3")]
    pub name: String,
    /// The scopes of the key, at least one. A scope that is listed twice counts once.
    #[schema(value_type = Vec<Scope>, min_items = 1, example = json!(["read", "compute"]))]
    pub scopes: BTreeSet<Scope>,
    /// The only machines that the key reaches; leave it out for all machines. A key with `admin` has no such
    /// list, because `admin` covers every machine. A machine that is listed twice counts once.
    #[serde(default)]
    #[schema(value_type = Option<Vec<String>>, required = false, min_items = 1, max_items = 1000, example = json!(["example-ac-table"]))]
    pub machines: Option<BTreeSet<String>>,
    /// Time at which the key expires (RFC 3339); leave it out for a key that never expires.
    #[serde(default)]
    #[schema(required = false, format = DateTime, example = "2099-01-01T00:00:00Z")]
    pub expires_at: Option<String>,
}

/// Largest number of characters in a key's name.
const MAX_NAME: usize = 200;
/// Largest number of machines of a key.
const MAX_MACHINES: usize = 1000;

impl ApiKeyRequest {
    /// Checks everything except the expiry, which needs the current time.
    pub fn check(&self, faults: &mut FaultList) {
        let length = self.name.chars().count();
        if self.name.trim().is_empty() || length > MAX_NAME || self.name.chars().any(char::is_control) {
            let detail = format!("a name has 1 to {MAX_NAME} characters and no control characters");
            faults.push(|| Fault::new("/name", detail));
        }
        if self.scopes.is_empty() {
            faults.push(|| {
                Fault::new("/scopes", "a key without a scope allows nothing; name at least one scope")
            });
        }
        let Some(machines) = &self.machines else { return };
        if machines.is_empty() || machines.len() > MAX_MACHINES {
            let detail = format!("name 1 to {MAX_MACHINES} machines, or leave the list out to reach all");
            faults.push(|| Fault::new("/machines", detail));
        }
        if self.scopes.contains(&Scope::Admin) {
            let detail = "admin makes keys for every machine, so a key with this scope has no list";
            faults.push(|| Fault::new("/machines", detail));
        }
        for (index, machine_id) in machines.iter().enumerate() {
            if !is_slug(machine_id) {
                let detail = format!("{machine_id:?} is not a machine id");
                faults.push(|| Fault::new(format!("/machines/{index}"), detail));
            }
        }
    }
}

/// Whether the text can be the id of a machine.
#[must_use]
pub fn is_slug(machine_id: &str) -> bool {
    let word = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit();
    machine_id.len() <= 64
        && machine_id.bytes().all(|byte| word(byte) || byte == b'-')
        && machine_id.bytes().next().is_some_and(word)
}

/// A key as it is listed. The service does not store its secret.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = ApiKey)]
pub struct ApiKeyDocument {
    /// The part of the key that is not secret.
    #[schema(example = "5f1c2d4e9a07")]
    pub id: String,
    /// A name for people: who or what uses the key.
    #[schema(example = "MES of hall 3")]
    pub name: String,
    /// The scopes of the key.
    pub scopes: BTreeSet<Scope>,
    /// The only machines that the key reaches; null for all machines.
    pub machines: Option<BTreeSet<String>>,
    /// Time at which the key was created.
    pub created_at: String,
    /// Time at which the key expires; null for a key that never expires.
    pub expires_at: Option<String>,
    /// Time at which the key was revoked; null for a key that is still valid.
    pub revoked_at: Option<String>,
    /// Time of the last use, accurate to a few minutes.
    pub last_used_at: Option<String>,
}

/// A key that was just created.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[schema(as = NewApiKey)]
pub struct NewApiKeyDocument {
    /// Send it as `Authorization: Bearer …`. It is shown only once: null when the same request is answered
    /// again.
    #[schema(example = "trn_5f1c2d4e9a07_…")]
    pub key: Option<String>,
    /// The key as the list shows it.
    #[serde(flatten)]
    pub document: ApiKeyDocument,
}
