//! The database for a command that may run while the service runs. If no service has the directory, the
//! command takes its lock and updates the database to the newest schema. If a service has it, the command
//! writes beside it, in the service's schema.

use std::path::Path;

use super::StartFault;
use super::rights::keep_private;
use super::serve::on_a_local_disk;
use crate::jobs::OpenFault;
use crate::store::{DATABASE_NAME, DirectoryLock, LockFault, Store};

/// The database of an existing directory, and the lock if it was free: hold it to the end.
///
/// # Errors
/// The directory or the database cannot be used.
pub(super) async fn open(directory: &Path) -> Result<(Store, Option<DirectoryLock>), StartFault> {
    on_a_local_disk(directory)?;
    let file = directory.join(DATABASE_NAME);
    let (store, lock) = match DirectoryLock::take(directory) {
        Ok(lock) => {
            keep_private(directory);
            (Store::open(&file, 1).await, Some(lock))
        }
        Err(LockFault::Taken(_)) => (Store::open_beside(&file).await, None),
        Err(fault) => return Err(fault.into()),
    };
    Ok((store.map_err(OpenFault::from)?, lock))
}
