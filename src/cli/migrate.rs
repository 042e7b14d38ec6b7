//! Updates the database of a data directory to the newest schema.

use super::CommandFault;
use super::rights::keep_private;
use super::settings::say;
use crate::config::Settings;
use crate::jobs::Sources;
use crate::store::{DATABASE_NAME, DatabaseFile, DirectoryLock, Store, make_directory, own_schema};

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

/// Runs a task that waits for the database.
pub(super) fn block_on<T>(work: impl Future<Output = Result<T, CommandFault>>) -> Result<T, CommandFault> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    runtime.map_err(CommandFault::Process)?.block_on(work)
}
