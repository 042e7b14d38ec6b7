//! The database for a command that may run while the service runs. If no service has the directory, the
//! command takes its lock and updates the database to the newest schema. If a service has it, the command
//! writes beside it, in the service's schema.

use super::StartFault;
use super::rights::keep_private;
use super::serve::on_a_local_disk;
use crate::config::Settings;
use crate::jobs::{OpenFault, Sources};
use crate::store::{DirectoryLock, LockFault, Store, StoreError};

/// The database of the settings, whose directory exists, and the lock if it was free: hold it to the end.
///
/// # Errors
/// The directory or the database cannot be used.
pub(super) async fn open(settings: &Settings) -> Result<(Store, Option<DirectoryLock>), StartFault> {
    let directory = &settings.data_dir;
    on_a_local_disk(directory)?;
    let (store, lock) = match DirectoryLock::take(directory) {
        Ok(lock) => {
            keep_private(directory);
            let instance = Sources::real().ids.next().to_string();
            let store = match Store::open_for_command_as_set(settings, &instance).await {
                // The service that has the database has another directory.
                Err(StoreError::InUse { .. }) => Store::open_beside_as_set(settings).await,
                store => store,
            };
            (store, Some(lock))
        }
        Err(LockFault::Taken(_)) => (Store::open_beside_as_set(settings).await, None),
        Err(fault) => return Err(fault.into()),
    };
    Ok((store.map_err(OpenFault::from)?, lock))
}
