//! API keys: create, list, revoke.

use std::collections::BTreeSet;

use super::audit::{Actor, Change, audit};
use super::error::Doing;
use super::keys::unless_key_taken;
use super::{Cursor, KeyUse, Page, Store, StoreError};
use crate::wire::{ApiKeyDocument, AuditAction, Scope};

/// A key about to be stored, or as the guard sees it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ApiKeyRow {
    /// The listed data of the key.
    pub document: ApiKeyDocument,
    /// SHA-256 of the secret, lower-case hex.
    pub secret_sha256: String,
}

row! {
    struct StoredKey {
        id: String,
        secret_sha256: String,
        name: String,
        scopes: String,
        machines: Option<String>,
        created_at: String,
        expires_at: Option<String>,
        revoked_at: Option<String>,
        last_used_at: Option<String>,
    }
}

row! {
    /// A key in a list.
    struct ListedKey {
        seq: i64,
        id: String,
        secret_sha256: String,
        name: String,
        scopes: String,
        machines: Option<String>,
        created_at: String,
        expires_at: Option<String>,
        revoked_at: Option<String>,
        last_used_at: Option<String>,
    }
}

row! {
    /// The key that a request has created.
    struct KeyOfRequest {
        id: String,
        fingerprint: Option<String>,
    }
}

impl StoredKey {
    fn read(self) -> Result<ApiKeyRow, StoreError> {
        let read = || -> Result<(BTreeSet<Scope>, Option<BTreeSet<String>>), serde_json::Error> {
            let machines = self.machines.as_deref().map(serde_json::from_str).transpose()?;
            Ok((serde_json::from_str(&self.scopes)?, machines))
        };
        let (scopes, machines) = read().map_err(|source| StoreError::Unreadable {
            what: "API key",
            key: self.id.clone(),
            source,
        })?;
        let document = ApiKeyDocument {
            id: self.id,
            name: self.name,
            scopes,
            machines,
            created_at: self.created_at,
            expires_at: self.expires_at,
            revoked_at: self.revoked_at,
            last_used_at: self.last_used_at,
        };
        Ok(ApiKeyRow { document, secret_sha256: self.secret_sha256 })
    }
}

impl Store {
    /// Every key that was ever created, oldest first; revoked and expired keys too.
    ///
    /// # Errors
    /// The database failed.
    pub async fn every_api_key(&self) -> Result<Vec<ApiKeyRow>, StoreError> {
        let rows = sql!(
            self.db,
            all(StoredKey),
            "SELECT id, secret_sha256, name, scopes, machines, created_at, expires_at, revoked_at, last_used_at
             FROM api_keys ORDER BY seq"
        )
        .doing("reading the API keys")?;
        rows.into_iter().map(StoredKey::read).collect()
    }

    /// One key.
    ///
    /// # Errors
    /// The database failed.
    pub async fn api_key(&self, id: &str) -> Result<Option<ApiKeyDocument>, StoreError> {
        let row = sql!(
            self.db,
            optional(StoredKey),
            "SELECT id, secret_sha256, name, scopes, machines, created_at, expires_at, revoked_at, last_used_at
             FROM api_keys WHERE id = $1",
            id
        )
        .doing("reading an API key")?;
        Ok(row.map(StoredKey::read).transpose()?.map(|row| row.document))
    }

    /// A page of keys, newest first.
    ///
    /// # Errors
    /// The database failed.
    pub async fn api_keys(
        &self,
        limit: u32,
        before: Option<Cursor>,
    ) -> Result<Page<ApiKeyDocument>, StoreError> {
        let (before, count) = (before.map_or(i64::MAX, |cursor| cursor.0), i64::from(limit) + 1);
        let rows = sql!(
            self.db,
            all(ListedKey),
            "SELECT seq, id, secret_sha256, name, scopes, machines, created_at, expires_at, revoked_at, last_used_at
             FROM api_keys WHERE seq < $1 ORDER BY seq DESC LIMIT $2",
            before,
            count
        )
        .doing("listing API keys")?;
        let read = rows.into_iter().map(|row| {
            let stored = StoredKey {
                id: row.id,
                secret_sha256: row.secret_sha256,
                name: row.name,
                scopes: row.scopes,
                machines: row.machines,
                created_at: row.created_at,
                expires_at: row.expires_at,
                revoked_at: row.revoked_at,
                last_used_at: row.last_used_at,
            };
            Ok((row.seq, stored.read()?.document))
        });
        Ok(Page::cut(read.collect::<Result<_, StoreError>>()?, limit))
    }

    /// The key that a request with an idempotency key has created; the inner value is `None` if it was another
    /// request.
    ///
    /// # Errors
    /// The database failed.
    pub async fn api_key_made_by(&self, used: &KeyUse) -> Result<Option<Option<ApiKeyDocument>>, StoreError> {
        let row = sql!(
            self.db,
            optional(KeyOfRequest),
            "SELECT id, fingerprint FROM api_keys WHERE idempotency_key = $1 AND created_at >= $2",
            used.key,
            used.since
        )
        .doing("reading an idempotency key")?;
        match row {
            None => Ok(None),
            Some(row) if row.fingerprint.as_ref() == Some(&used.fingerprint) => {
                Ok(Some(self.api_key(&row.id).await?))
            }
            Some(_) => Ok(Some(None)),
        }
    }

    /// Stores a key. `false` when its idempotency key was used in the meantime, in which case nothing is stored.
    ///
    /// # Errors
    /// The database failed.
    pub async fn add_api_key(
        &self,
        new: &ApiKeyRow,
        used: Option<&KeyUse>,
        actor: &Actor,
    ) -> Result<bool, StoreError> {
        let ApiKeyRow { document, secret_sha256 } = new.clone();
        let (used, actor) = (used.cloned(), actor.clone());
        let unprintable =
            |source| StoreError::Unreadable { what: "API key", key: new.document.id.clone(), source };
        let scopes = serde_json::to_string(&document.scopes).map_err(unprintable)?;
        let machines =
            document.machines.as_ref().map(serde_json::to_string).transpose().map_err(unprintable)?;
        let added = self
            .write("storing an API key", |tx| {
                Box::pin(async move {
                    if let Some(KeyUse { key, since, .. }) = &used {
                        sql!(
                            tx,
                            execute,
                            "UPDATE api_keys SET idempotency_key = NULL WHERE idempotency_key = $1 AND created_at < $2",
                            key,
                            since
                        )?;
                    }
                    let (key, fingerprint) = used.map(|used| (used.key, used.fingerprint)).unzip();
                    sql!(
                        tx,
                        execute,
                        "INSERT INTO api_keys (id, secret_sha256, name, scopes, machines, created_at, expires_at,
                             idempotency_key, fingerprint)
                         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9)",
                        document.id,
                        secret_sha256,
                        document.name,
                        scopes,
                        machines,
                        document.created_at,
                        document.expires_at,
                        key,
                        fingerprint
                    )?;
                    let change = about(&document.id, &document.created_at, AuditAction::KeyCreated);
                    audit(tx, &actor, change).await
                })
            })
            .await;
        unless_key_taken(added)
    }

    /// Revokes a key; a revoked key stays as it is. Returns the key afterwards, if there is one.
    ///
    /// # Errors
    /// The database failed.
    pub async fn revoke_api_key(
        &self,
        id: &str,
        now: &str,
        actor: &Actor,
    ) -> Result<Option<ApiKeyDocument>, StoreError> {
        let (key_id, at, actor) = (id.to_owned(), now.to_owned(), actor.clone());
        self.write("revoking an API key", |tx| {
            Box::pin(async move {
                let revoked = sql!(
                    tx,
                    execute,
                    "UPDATE api_keys SET revoked_at = $1 WHERE id = $2 AND revoked_at IS NULL",
                    at,
                    key_id
                )?;
                if revoked == 0 {
                    return Ok(());
                }
                audit(tx, &actor, about(&key_id, &at, AuditAction::KeyRevoked)).await
            })
        })
        .await?;
        self.api_key(id).await
    }

    /// The machine of a job; it decides whether a key reaches the job.
    ///
    /// # Errors
    /// The database failed.
    pub async fn machine_of_job(&self, id: &str) -> Result<Option<String>, StoreError> {
        sql!(self.db, optional(_), "SELECT machine_id FROM jobs WHERE id = $1", id)
            .doing("reading the machine of a job")
    }

    /// Records that a key was used.
    ///
    /// # Errors
    /// The database failed.
    pub async fn note_use_of_api_key(&self, id: &str, at: &str) -> Result<(), StoreError> {
        let (id, at) = (id.to_owned(), at.to_owned());
        self.write("recording the use of an API key", |tx| {
            Box::pin(async move {
                sql!(tx, execute, "UPDATE api_keys SET last_used_at = $1 WHERE id = $2", at, id)?;
                Ok(())
            })
        })
        .await
    }
}

fn about<'a>(id: &str, at: &'a str, action: AuditAction) -> Change<'a> {
    let resource = format!("/v1/keys/{id}");
    Change { at, action, machine_id: None, resource, revisions: (None, None) }
}
