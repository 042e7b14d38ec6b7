//! One process for each data directory.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why the directory could not be taken.
#[derive(Debug, Error)]
pub enum LockFault {
    /// Another process has it.
    #[error("another trunnion uses the data directory {0}")]
    Taken(PathBuf),
    /// The lock file could not be opened or locked.
    #[error("the lock file {path} cannot be used: {source}")]
    Unusable {
        /// Path of the lock file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
}

/// Held as long as the process uses the directory; the system frees it when the process ends in any way.
#[derive(Debug)]
pub struct DirectoryLock {
    _file: File,
}

impl DirectoryLock {
    /// Whether another process has the directory; the lock file is only looked at.
    #[must_use]
    pub fn is_taken(directory: &Path) -> bool {
        File::open(directory.join("trunnion.lock"))
            .is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
    }

    /// Takes the directory.
    ///
    /// # Errors
    /// Another process has it, or the lock file cannot be used.
    pub fn take(directory: &Path) -> Result<Self, LockFault> {
        let path = directory.join("trunnion.lock");
        let unusable = |source| LockFault::Unusable { path: path.clone(), source };
        let file = File::options().create(true).write(true).truncate(false).open(&path).map_err(unusable)?;
        match file.try_lock() {
            Ok(()) => Ok(Self { _file: file }),
            Err(TryLockError::WouldBlock) => Err(LockFault::Taken(directory.to_owned())),
            Err(TryLockError::Error(source)) => Err(LockFault::Unusable { path, source }),
        }
    }
}
