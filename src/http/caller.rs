//! The caller: the key that a request came with, its scopes, and the machines that it reaches. Handlers get it from
//! `request_facts`.

use std::collections::BTreeSet;
use std::sync::{Arc, LazyLock};

use super::problem::Problem;
use crate::jobs::HeldKey;
use crate::wire::Scope;

/// The caller; cheap to clone. Every request has one after it has passed the guard.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Caller {
    /// The key's id; `None` if the service has no keys and is open.
    pub key_id: Option<Arc<str>>,
    /// The scopes of the key.
    pub scopes: Arc<BTreeSet<Scope>>,
    /// The only machines that the key reaches; `None` for all.
    pub machines: Option<Arc<BTreeSet<String>>>,
}

impl Caller {
    /// Any caller, at a service without keys.
    #[must_use]
    pub fn anybody() -> Self {
        static EVERY: LazyLock<Arc<BTreeSet<Scope>>> = LazyLock::new(|| Arc::new(Scope::ALL.into()));
        Self { key_id: None, scopes: Arc::clone(&EVERY), machines: None }
    }

    /// A caller without a key that asks for an open operation, at a service with keys.
    #[must_use]
    pub fn nobody() -> Self {
        Self { key_id: None, scopes: Arc::default(), machines: Some(Arc::default()) }
    }

    /// The caller with this key.
    #[must_use]
    pub fn with(key: &HeldKey) -> Self {
        let HeldKey { id, scopes, machines, .. } = key;
        Self { key_id: Some(Arc::clone(id)), scopes: Arc::clone(scopes), machines: machines.clone() }
    }

    /// Whether the key has this scope.
    #[must_use]
    pub fn may(&self, scope: Scope) -> bool {
        self.scopes.contains(&scope)
    }

    /// Whether the key reaches this machine, whether or not the machine exists.
    #[must_use]
    pub fn reaches(&self, machine_id: &str) -> bool {
        self.machines.as_ref().is_none_or(|machines| machines.contains(machine_id))
    }

    /// The same as a refusal: a machine that the key does not reach does not exist for the caller.
    ///
    /// # Errors
    /// The key does not reach it.
    pub fn must_reach(&self, machine_id: &str) -> Result<(), Problem> {
        if self.reaches(machine_id) { Ok(()) } else { Err(Problem::machine_not_found(machine_id)) }
    }
}
