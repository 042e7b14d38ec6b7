//! Backs up the data directory, and restores it.

use std::path::Path;

use super::CommandFault;
use super::doctor;
use super::migrate::block_on;
use super::settings::say;
use crate::config::{DatabaseAddress, FilesIn, Settings};
use crate::jobs::Sources;
use crate::store::{self, Manifest};

/// Backs up into `target`.
pub(super) fn back_up(settings: &Settings, target: &Path) -> Result<(), CommandFault> {
    if let Some(address) = &settings.database {
        return of_the_server(settings, address, target);
    }
    let created_at = Sources::real().timestamp();
    let manifest = block_on(async { Ok(store::back_up(&settings.data_dir, target, created_at).await?) })?;
    say(&format!("{} holds {}", target.display(), told(&manifest)))
}

/// Restores `backup` into the data directory.
pub(super) fn restore(settings: &Settings, backup: &Path) -> Result<(), CommandFault> {
    if settings.database.is_some() {
        let instead = match &settings.files {
            FilesIn::Directory => "pg_restore, and copy the data directory of the same backup back",
            FilesIn::Postgres => "pg_restore: the files are in the database",
            FilesIn::Objects(_) => "pg_restore, and copy the files of the same backup back into the bucket",
        };
        return Err(CommandFault::OfTheServer { command: "restore", instead });
    }
    let manifest = block_on(async { Ok(store::restore(backup, &settings.data_dir).await?) })?;
    say(&format!("{} holds {} of {}", settings.data_dir.display(), told(&manifest), manifest.created_at))
}

/// Reads everything on the server, so that no damage is copied unseen, and prints the commands that copy it. Nothing is
/// copied: the status says so to a script.
fn of_the_server(settings: &Settings, address: &DatabaseAddress, target: &Path) -> Result<(), CommandFault> {
    let faults = doctor::server_is_read(settings, address)?;
    if faults > 0 {
        say(&format!("{faults} of the checks failed: a copy would have the same faults"))?;
    }
    let (target, data_dir) = (target.display(), settings.data_dir.display());
    say(
        "copy it with these commands, as the user of the database, and with --schema if the plant has one of its own:",
    )?;
    say(&format!("mkdir {target}"))?;
    say(&format!("pg_dump --format=custom --file {target}/trunnion.dump --dbname {address}"))?;
    match &settings.files {
        FilesIn::Directory => say(&format!("cp --recursive --no-clobber {data_dir} {target}/data"))?,
        FilesIn::Postgres => {}
        FilesIn::Objects(bucket) => {
            let at = settings.files_endpoint.as_ref().map(|endpoint| format!(" --endpoint-url {endpoint}"));
            say(&format!("aws s3 sync{} {bucket} {target}/files", at.unwrap_or_default()))?;
        }
    }
    Err(CommandFault::OfTheServer { command: "backup", instead: "the commands above, or pg_basebackup" })
}

fn told(manifest: &Manifest) -> String {
    let Manifest { schema, rows, files, .. } = manifest;
    let bytes: u64 = files.values().map(|file| file.bytes).sum();
    let rows: u64 = rows.values().sum();
    format!("{rows} rows of schema {schema} in {} files, {bytes} bytes, every digest verified", files.len())
}
