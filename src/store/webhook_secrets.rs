//! The secrets that sign webhooks: the newest, and the earlier ones that still sign for some time.

use super::audit::{Actor, Change, audit};
use super::error::Doing;
use super::keys::unless_key_taken;
use super::{KeyUse, Store, StoreError};
use crate::wire::{AuditAction, WebhookSecret};

/// A secret as it is stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WebhookSecretRow {
    /// The secret.
    pub secret: WebhookSecret,
    /// Time at which the secret was created.
    pub created_at: String,
    /// Time until which it signs; `None` for the newest.
    pub signs_until: Option<String>,
}

row! {
    struct StoredSecret {
        secret: String,
        created_at: String,
        signs_until: Option<String>,
    }
}

impl Store {
    /// Every stored secret, newest first.
    ///
    /// # Errors
    /// The database failed.
    pub async fn webhook_secrets(&self) -> Result<Vec<WebhookSecretRow>, StoreError> {
        let rows = sql!(
            self.db,
            all(StoredSecret),
            "SELECT secret, created_at, signs_until FROM webhook_secrets ORDER BY seq DESC"
        )
        .doing("reading the secrets of webhooks")?;
        Ok(rows
            .into_iter()
            .map(|row| WebhookSecretRow {
                secret: WebhookSecret(row.secret),
                created_at: row.created_at,
                signs_until: row.signs_until,
            })
            .collect())
    }

    /// Stores the first secret; if there already is one, nothing is stored.
    ///
    /// # Errors
    /// The database failed.
    pub async fn add_first_webhook_secret(
        &self,
        secret: &WebhookSecret,
        now: &str,
        by: &Actor,
    ) -> Result<(), StoreError> {
        let (secret, now, by) = (secret.0.clone(), now.to_owned(), by.clone());
        self.write("storing the first secret of webhooks", |tx| {
            Box::pin(async move {
                let added = sql!(
                    tx,
                    execute,
                    "INSERT INTO webhook_secrets (secret, created_at)
                     SELECT $1, $2 WHERE NOT EXISTS (SELECT 1 FROM webhook_secrets)",
                    secret,
                    now
                )?;
                if added == 0 {
                    return Ok(());
                }
                audit(tx, &by, about(&now, AuditAction::WebhookSecretCreated)).await
            })
        })
        .await
    }

    /// Stores a new secret; the earlier ones sign until `signs_until` at most, and those that no longer sign are
    /// removed. `false` if the request's key was used in the meantime; nothing changes then.
    ///
    /// # Errors
    /// The database failed.
    pub async fn rotate_webhook_secret(
        &self,
        secret: &WebhookSecret,
        now: &str,
        signs_until: &str,
        used: Option<&KeyUse>,
        by: &Actor,
    ) -> Result<bool, StoreError> {
        let (secret, now, signs_until) = (secret.0.clone(), now.to_owned(), signs_until.to_owned());
        // A clock that is corrected does not make its key old.
        let made_at = used.map_or(now.as_str(), |used| now.as_str().max(&used.not_before)).to_owned();
        let (used, by) = (used.cloned(), by.clone());
        let rotated = self
            .write("storing a new secret of webhooks", |tx| {
                Box::pin(async move {
                    if let Some(KeyUse { since, .. }) = &used {
                        sql!(
                            tx,
                            execute,
                            "UPDATE webhook_secrets SET idempotency_key = NULL WHERE created_at < $1",
                            since
                        )?;
                    }
                    sql!(
                        tx,
                        execute,
                        "DELETE FROM webhook_secrets WHERE signs_until <= $1 AND idempotency_key IS NULL",
                        now
                    )?;
                    sql!(
                        tx,
                        execute,
                        "UPDATE webhook_secrets SET signs_until = $1 WHERE signs_until IS NULL",
                        signs_until
                    )?;
                    let (key, fingerprint) = used.map(|used| (used.key, used.fingerprint)).unzip();
                    sql!(
                        tx,
                        execute,
                        "INSERT INTO webhook_secrets (secret, created_at, idempotency_key, fingerprint)
                         VALUES ($1, $2, $3, $4)",
                        secret,
                        made_at,
                        key,
                        fingerprint
                    )?;
                    audit(tx, &by, about(&now, AuditAction::WebhookSecretRotated)).await
                })
            })
            .await;
        unless_key_taken(rotated)
    }

    /// Whether a secret was created under this key: by the same request, or (`false`) by another.
    ///
    /// # Errors
    /// The database failed.
    pub async fn webhook_secret_made_by(&self, used: &KeyUse) -> Result<Option<bool>, StoreError> {
        let row: Option<Option<String>> = sql!(
            self.db,
            optional(_),
            "SELECT fingerprint FROM webhook_secrets WHERE idempotency_key = $1 AND created_at >= $2",
            used.key,
            used.since
        )
        .doing("reading an idempotency key")?;
        Ok(row.map(|fingerprint| fingerprint.as_ref() == Some(&used.fingerprint)))
    }
}

fn about(at: &str, action: AuditAction) -> Change<'_> {
    let resource = "/v1/webhooks/secret".to_owned();
    Change { at, action, machine_id: None, resource, revisions: (None, None) }
}
