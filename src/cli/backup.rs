//! Backs up the data directory, and restores it.

use std::path::Path;

use super::CommandFault;
use super::migrate::block_on;
use super::settings::say;
use crate::config::Settings;
use crate::jobs::Sources;
use crate::store::{self, Manifest};

/// Backs up into `target`.
pub(super) fn back_up(settings: &Settings, target: &Path) -> Result<(), CommandFault> {
    of_a_file(
        settings,
        "backup",
        "pg_dump, or pg_basebackup with an archive of its log, and then copy the data directory",
    )?;
    let created_at = Sources::real().timestamp();
    let manifest = block_on(async { Ok(store::back_up(&settings.data_dir, target, created_at).await?) })?;
    say(&format!("{} holds {}", target.display(), told(&manifest)))
}

/// Restores `backup` into the data directory.
pub(super) fn restore(settings: &Settings, backup: &Path) -> Result<(), CommandFault> {
    of_a_file(settings, "restore", "pg_restore, and copy the data directory of the same backup back")?;
    let manifest = block_on(async { Ok(store::restore(backup, &settings.data_dir).await?) })?;
    say(&format!("{} holds {} of {}", settings.data_dir.display(), told(&manifest), manifest.created_at))
}

/// Refuses a database on a server, and says what to use there.
fn of_a_file(settings: &Settings, command: &'static str, instead: &'static str) -> Result<(), CommandFault> {
    match &settings.database {
        None => Ok(()),
        Some(_) => Err(CommandFault::OfTheServer { command, instead }),
    }
}

fn told(manifest: &Manifest) -> String {
    let Manifest { schema, rows, files, .. } = manifest;
    let bytes: u64 = files.values().map(|file| file.bytes).sum();
    let rows: u64 = rows.values().sum();
    format!("{rows} rows of schema {schema} in {} files, {bytes} bytes, every digest verified", files.len())
}
