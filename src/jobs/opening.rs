//! Opens a data directory: migrates the database, removes left-over files, stores the first machine.

use super::webhooks::new_webhook_secret;
use super::{OpenFault, Sources};
use crate::config::Settings;
use crate::store::{Actor, Blobs, NewRevision, Store, sha256_hex};
use crate::wire::{AuditOrigin, MachineProfile, example_machine};

/// Opens database and files; a store that never held a machine gets the example machine.
///
/// # Errors
/// The part that cannot be used.
pub async fn open_data_directory(
    settings: &Settings,
    sources: &Sources,
) -> Result<(Store, Blobs), OpenFault> {
    // The database comes first: if it is lost, the files beside it are not touched.
    let instance = sources.ids.next().to_string();
    let store = Store::open_as_set(settings, settings.store_readers, &instance).await?;
    if let Some((at, time)) = store.server_time() {
        sources.clock.hear(at, time);
    }
    let blobs = store.keeping(Blobs::open(&settings.data_dir)?);
    let store = store.noting_damage_in(blobs.soundness());
    // Files of several services are removed while these run.
    if !blobs.are_copies() {
        let removed = blobs.sweep(&store.named_blobs().await?)?;
        if removed > 0 {
            tracing::info!(removed_files = removed, "removed files that no job names");
        }
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
        // Of several services, one is the first; the others find the machine.
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
