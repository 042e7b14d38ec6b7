//! API keys from the command line, on the data directory itself.
//!
//! A first key can be created before the first start. While a service runs, the command writes one short
//! transaction, and a mark that the service checks before the next request.

use std::io::Write;
use std::path::Path;

use clap::Subcommand;
use thiserror::Error;

use super::settings::put;
use super::{StartFault, beside};
use crate::config::Settings;
use crate::jobs::{IssueFault, IssuedKey, Sources, issue_key};
use crate::store::{Actor, ApiKeyRow, Store, StoreError, make_directory, mark_key_change};
use crate::wire::{ApiKeyDocument, ApiKeyRequest, AuditOrigin, Scope};

/// The commands for keys.
#[derive(Debug, Clone, PartialEq, Eq, Subcommand)]
pub enum KeysCommand {
    /// Create a key and print it; it is shown only once
    Create {
        /// A name for people: who or what will use the key
        #[arg(long)]
        name: String,
        /// Scopes of the key: any of read, compute, machines, calibrations, admin
        #[arg(long, value_delimiter = ',', required = true)]
        scopes: Vec<Scope>,
        /// The only machines that the key reaches; without it, all machines
        #[arg(long, value_delimiter = ',')]
        machines: Option<Vec<String>>,
        /// Expiry of the key, such as 2027-01-01T00:00:00Z; without it, the key never expires
        #[arg(long)]
        expires_at: Option<String>,
    },
    /// List all keys, without their secrets
    List,
    /// Revoke a key
    Revoke {
        /// Id of the key, the part between trn_ and the next _
        id: String,
    },
}

/// Why a command about keys failed.
#[derive(Debug, Error)]
pub enum KeysFault {
    /// No key was created.
    #[error(transparent)]
    Issue(#[from] IssueFault),
    /// The database could not be used.
    #[error("the database cannot be used: {0}")]
    Store(#[from] StoreError),
    /// The new key could not be stored.
    #[error("the printed key is not valid, because it could not be stored: {0}")]
    NotStored(StoreError),
    /// The random id of the new key already belongs to another key.
    #[error("the printed key is not valid, because its id already belongs to another key: try again")]
    SameId,
    /// No such key.
    #[error("there is no key {id}")]
    NotFound {
        /// The given id.
        id: String,
    },
    /// The change is stored, but a running service may see it a second later.
    #[error("done, but the running service could not be notified: {0}")]
    Mark(std::io::Error),
    /// The output could not be printed; a key that nobody has seen is not stored.
    #[error("standard output cannot be written, so nothing was done: {0}")]
    Print(std::io::Error),
}

impl KeysFault {
    /// Whether the request itself is at fault.
    pub(super) fn is_refusal(&self) -> bool {
        matches!(self, Self::Issue(IssueFault::Invalid(_)) | Self::NotFound { .. })
    }
}

/// Does what the command says.
pub(super) fn run(settings: &Settings, command: &KeysCommand) -> Result<(), StartFault> {
    let runtime =
        tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(StartFault::Process)?;
    runtime.block_on(async {
        let directory = &settings.data_dir;
        if matches!(command, KeysCommand::Create { .. }) {
            make_directory(directory)
                .map_err(|source| StartFault::DataDirectory { path: directory.clone(), source })?;
        }
        // Held to the end of the command.
        let (store, _lock) = beside::open(settings).await?;
        let done = work(&store, directory, command).await;
        store.close().await;
        Ok(done?)
    })
}

async fn work(store: &Store, directory: &Path, command: &KeysCommand) -> Result<(), KeysFault> {
    let (sources, actor) = (Sources::real(), Actor::without_request(AuditOrigin::CommandLine));
    let mark = || mark_key_change(directory, &sources.ids.next().to_string()).map_err(KeysFault::Mark);
    match command {
        KeysCommand::Create { name, scopes, machines, expires_at } => {
            let request = ApiKeyRequest {
                name: name.clone(),
                scopes: scopes.iter().copied().collect(),
                machines: machines.as_ref().map(|machines| machines.iter().cloned().collect()),
                expires_at: expires_at.clone(),
            };
            let IssuedKey { row, key } = issue_key(&request, &sources)?;
            // If the key were stored first and the print failed, a valid key would exist that nobody has.
            put(&format!("{key}\n")).map_err(KeysFault::Print)?;
            if !store.add_api_key(&row, None, &actor).await.map_err(KeysFault::NotStored)? {
                return Err(KeysFault::SameId);
            }
            let id = &row.document.id;
            let _nobody_reads = writeln!(std::io::stderr(), "key {id}: it is shown only once and not stored");
            mark()
        }
        KeysCommand::List => put(&table(&store.every_api_key().await?)).map_err(KeysFault::Print),
        KeysCommand::Revoke { id } => {
            let revoked = store.revoke_api_key(id, &sources.timestamp(), &actor).await?;
            revoked.ok_or_else(|| KeysFault::NotFound { id: id.clone() })?;
            mark()
        }
    }
}

/// One line for each key; tabs separate the columns.
fn table(keys: &[ApiKeyRow]) -> String {
    let mut text = "id\tscopes\tmachines\tcreated\texpires\trevoked\tlast used\tname\n".to_owned();
    for ApiKeyRow { document: key, .. } in keys {
        let ApiKeyDocument { id, name, scopes, machines, created_at, .. } = key;
        let scopes: Vec<_> = scopes.iter().map(|scope| scope.as_str()).collect();
        let machines = machines.as_ref().map_or_else(
            || "all".to_owned(),
            |machines| machines.iter().cloned().collect::<Vec<_>>().join(","),
        );
        let or_none = |time: &Option<String>| time.clone().unwrap_or_else(|| "-".to_owned());
        let [expires, revoked, used] = [&key.expires_at, &key.revoked_at, &key.last_used_at].map(or_none);
        let line = [id, &scopes.join(","), &machines, created_at, &expires, &revoked, &used, name]
            .map(String::as_str)
            .join("\t");
        text.push_str(&line);
        text.push('\n');
    }
    text
}
