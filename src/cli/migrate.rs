//! Updates the database of a data directory to the newest schema, or moves the directory to a server.

use super::CommandFault;
use super::rights::keep_private;
use super::settings::say;
#[cfg(feature = "scale-out")]
use crate::config::FilesIn;
use crate::config::{DatabaseAddress, Settings};
use crate::jobs::Sources;
#[cfg(not(feature = "scale-out"))]
use crate::store::StoreError;
use crate::store::{DATABASE_NAME, DatabaseFile, DirectoryLock, Store, make_directory, own_schema};
#[cfg(feature = "scale-out")]
use crate::store::{Moved, move_to_server};

/// Migrates the database while it holds the directory alone.
pub(super) fn run(settings: &Settings) -> Result<(), CommandFault> {
    let data_dir = &settings.data_dir;
    let unusable = |source| CommandFault::File { doing: "making", path: data_dir.clone(), source };
    make_directory(data_dir).map_err(unusable)?;
    let lock = DirectoryLock::take(data_dir)?;
    keep_private(data_dir);
    if settings.database.is_some() {
        let instance = Sources::real().ids.next().to_string();
        block_on(async {
            Store::open_for_command_as_set(settings, &instance).await?.close().await;
            Ok(())
        })?;
        return say("the database has the newest schema of this version");
    }
    let database = data_dir.join(DATABASE_NAME);
    let before = block_on(async {
        let mut before = None;
        if database.is_file() {
            let mut file = DatabaseFile::open(&database).await?;
            before = file.schema().await?;
            file.close().await;
        }
        let store = Store::open(&database, 1).await?;
        store.close().await;
        Ok(before)
    })?;
    drop(lock);
    let after = own_schema();
    say(&match before {
        Some(before) if before == after => format!("the database already has schema {after}"),
        Some(before) => format!("the database had schema {before} and now has schema {after}"),
        None => format!("a new database with schema {after}"),
    })
}

/// Moves the data directory to an empty database at this address, while it holds both alone.
#[cfg(feature = "scale-out")]
pub(super) fn to_server(settings: &Settings, address: &DatabaseAddress) -> Result<(), CommandFault> {
    let data_dir = &settings.data_dir;
    let lock = DirectoryLock::take(data_dir)?;
    keep_private(data_dir);
    let instance = Sources::real().ids.next().to_string();
    let moved = block_on(async { Ok(Box::pin(move_to_server(settings, address, &instance)).await?) })?;
    drop(lock);
    let Moved { rows, files, file_bytes, left, was_complete } = moved;
    if was_complete {
        say(&format!("an earlier run had moved everything to {address}; every row and file was compared"))?;
    } else {
        say(&format!(
            "{rows} rows and {files} files ({file_bytes} bytes) were compared and now belong to {address}"
        ))?;
    }
    say(&format!("the database file is kept as {}", left.display()))?;
    let place = data_dir.display();
    say(&match &settings.files {
        FilesIn::Directory => {
            format!("the files stay in {place}: the service needs this directory and database = {address}")
        }
        FilesIn::Postgres => {
            format!("the files are in the database; those here are kept in {place}/blobs.migrated")
        }
        FilesIn::Objects(bucket) => {
            format!("the files are in {bucket}; those here are kept in {place}/blobs.migrated")
        }
    })
}

/// The same in a binary without servers.
#[cfg(not(feature = "scale-out"))]
pub(super) fn to_server(_settings: &Settings, _address: &DatabaseAddress) -> Result<(), CommandFault> {
    Err(StoreError::NoServers.into())
}

/// Runs a task that waits for the database.
pub(super) fn block_on<T>(work: impl Future<Output = Result<T, CommandFault>>) -> Result<T, CommandFault> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    runtime.map_err(CommandFault::Process)?.block_on(work)
}
