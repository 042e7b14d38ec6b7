//! API keys from the command line, on the data directory itself.
//!
//! A first key can be made before the first start. Beside a service that runs, the command writes one short transaction, and
//! a mark that the service looks at before the next request.

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

/// What can be done with keys.
#[derive(Debug, Clone, PartialEq, Eq, Subcommand)]
pub enum KeysCommand {
    /// Make a key and print it, this once
    Create {
        /// Who or what will carry it
        #[arg(long)]
        name: String,
        /// What it allows: any of read, compute, machines, calibrations, admin
        #[arg(long, value_delimiter = ',', required = true)]
        scopes: Vec<Scope>,
        /// The only machines it reaches; without it, all
        #[arg(long, value_delimiter = ',')]
        machines: Option<Vec<String>>,
        /// When it ends, as 2027-01-01T00:00:00Z; without it, never
        #[arg(long)]
        expires_at: Option<String>,
    },
    /// List every key ever made, without its secret
    List,
    /// Revoke a key
    Revoke {
        /// Its id, the part between trn_ and the next _
        id: String,
    },
}

/// Why a command about keys failed.
#[derive(Debug, Error)]
pub enum KeysFault {
    /// No key was made.
    #[error(transparent)]
    Issue(#[from] IssueFault),
    /// The database could not be used.
    #[error("the database cannot be used: {0}")]
    Store(#[from] StoreError),
    /// The new key could not be stored.
    #[error("the key that was printed opens nothing, it could not be stored: {0}")]
    NotStored(StoreError),
    /// The random id of the new key is that of another.
    #[error("the key that was printed opens nothing, it would have had the id of another: try again")]
    SameId,
    /// No such key.
    #[error("there is no key {id}")]
    NotFound {
        /// The id given.
        id: String,
    },
    /// The change is made, but a service that runs may see it a second later.
    #[error("done, but the running service could not be told: {0}")]
    Mark(std::io::Error),
    /// What was to be printed was not; a key that nobody has seen is not stored.
    #[error("standard output cannot be written, and nothing was done: {0}")]
    Print(std::io::Error),
}

impl KeysFault {
    /// Whether what was asked for is at fault.
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
        // Held to the end.
        let (store, _lock) = beside::open(directory).await?;
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
            // A key that was stored first and then not printed would be alive with nobody to have it.
            put(&format!("{key}\n")).map_err(KeysFault::Print)?;
            if !store.add_api_key(&row, None, &actor).await.map_err(KeysFault::NotStored)? {
                return Err(KeysFault::SameId);
            }
            let id = &row.document.id;
            let _nobody_reads = writeln!(std::io::stderr(), "key {id}: shown this once, and stored nowhere");
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

/// One line for each key, columns parted by tabs.
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
