//! Opens a data directory: migrates the database, removes left-over files, stores the first machine.

use thiserror::Error;

use super::Sources;
use super::webhooks::{TrustFault, new_webhook_secret};
use crate::config::Settings;
use crate::store::{Actor, BlobFault, Blobs, DATABASE_NAME, NewRevision, Store, StoreError, sha256_hex};
use crate::wire::{AuditOrigin, Fault, MachineProfile, example_machine};

/// Why a data directory cannot be used.
#[derive(Debug, Error)]
pub enum OpenFault {
    /// The database cannot be used.
    #[error("the database cannot be used: {0}")]
    Store(#[from] StoreError),
    /// The files cannot be used.
    #[error("the files cannot be used: {0}")]
    Blobs(#[from] BlobFault),
    /// The certificates for receivers of webhooks cannot be used.
    #[error(transparent)]
    Trust(#[from] TrustFault),
    /// The system provides no random numbers.
    #[error("the system provides no random numbers: {0}")]
    NoRandomness(getrandom::Error),
    /// The system cannot start a thread.
    #[error("the system cannot start a thread: {0}")]
    Thread(std::io::Error),
    /// The example profile is wrong: a fault of the service.
    #[error("the example machine has {} faults", .0.len())]
    Example(Vec<Fault>),
}

/// Opens database and files; a store that never held a machine gets the example machine.
///
/// # Errors
/// The part that cannot be used.
pub async fn open_data_directory(
    settings: &Settings,
    sources: &Sources,
) -> Result<(Store, Blobs), OpenFault> {
    // The database comes first: if it is lost, the files beside it are not touched.
    let store = Store::open(&settings.data_dir.join(DATABASE_NAME), settings.store_readers).await?;
    let blobs = Blobs::open(&settings.data_dir)?;
    let store = store.noting_damage_in(blobs.soundness());
    let removed = blobs.sweep(&store.named_blobs().await?)?;
    if removed > 0 {
        tracing::info!(removed_files = removed, "removed files that no job names");
    }
    if store.has_no_machine_yet().await?
        && let Some((machine_id, profile)) = example_machine()
    {
        let (profile, _machine) = profile.into_machine().map_err(OpenFault::Example)?;
        let sha256 = profile_sha256(&profile);
        let new = NewRevision {
            machine_id: machine_id.to_owned(),
            profile,
            sha256,
            calibration_id: None,
            created_at: sources.timestamp(),
        };
        // No other process has the directory, so no other machine can have come first.
        let _stored =
            store.put_machine(new, None, None, &Actor::without_request(AuditOrigin::Service)).await?;
    }
    if store.webhook_secrets().await?.is_empty() {
        let secret = new_webhook_secret().map_err(OpenFault::NoRandomness)?;
        let by = Actor::without_request(AuditOrigin::Service);
        store.add_first_webhook_secret(&secret, &sources.timestamp(), &by).await?;
    }
    Ok((store, blobs))
}

/// Digest of a normalised profile.
#[must_use]
pub fn profile_sha256(profile: &MachineProfile) -> String {
    // A checked profile contains only finite numbers and strings, which can always be printed.
    sha256_hex(&serde_json::to_vec(profile).unwrap_or_default())
}
