//! The secret of webhooks on the command line. It works while the service runs, because the service reads the
//! secret for every delivery.

use clap::Subcommand;
use thiserror::Error;

use super::settings::say;
use super::{CommandFault, StartFault, beside};
use crate::config::Settings;
use crate::jobs::{SECRET_OVERLAP_S, Sources, new_webhook_secret};
use crate::store::{Actor, Store, StoreError};
use crate::wire::AuditOrigin;

/// The commands for webhooks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Subcommand)]
pub enum WebhooksCommand {
    /// Print the secret that receivers verify deliveries with
    Secret,
    /// Create a new secret and print it; the previous secret signs too for 24 hours
    Rotate,
}

/// Why a command about webhooks failed.
#[derive(Debug, Error)]
pub enum WebhooksFault {
    /// The database could not be used.
    #[error("the database cannot be used: {0}")]
    Store(#[from] StoreError),
    /// The system provides no random numbers.
    #[error("the system provides no random numbers: {0}")]
    NoRandomness(#[from] getrandom::Error),
    /// The secret could not be printed.
    #[error(transparent)]
    Print(#[from] CommandFault),
}

/// Does what the command says.
pub(super) fn run(settings: &Settings, command: WebhooksCommand) -> Result<(), StartFault> {
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(StartFault::Process)?;
    runtime.block_on(async {
        let (store, _lock) = beside::open(settings).await?;
        let done = work(&store, command).await;
        store.close().await;
        Ok(done?)
    })
}

async fn work(store: &Store, command: WebhooksCommand) -> Result<(), WebhooksFault> {
    let (sources, actor) = (Sources::real(), Actor::without_request(AuditOrigin::CommandLine));
    let now = sources.timestamp();
    if store.webhook_secrets().await?.is_empty() {
        store.add_first_webhook_secret(&new_webhook_secret()?, &now, &actor).await?;
    } else if command == WebhooksCommand::Rotate {
        let secret = new_webhook_secret()?;
        // If the secret were stored first and the print failed, a further rotation would push the old secrets
        // out.
        say(&secret.0)?;
        // Only a request with an idempotency key could have stored it before.
        let _rotated = store
            .rotate_webhook_secret(&secret, &now, &sources.timestamp_after(SECRET_OVERLAP_S), None, &actor)
            .await?;
        return Ok(());
    }
    match store.webhook_secrets().await?.first() {
        Some(newest) => Ok(say(&newest.secret.0)?),
        None => Err(StoreError::NoSecret.into()),
    }
}
