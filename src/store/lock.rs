//! One process for each data directory.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Why the directory could not be locked.
#[derive(Debug, Error)]
pub enum LockFault {
    /// Another process has it.
    #[error(
        "another trunnion uses the data directory {0}; stop it first, or name another directory with --data-dir"
    )]
    Taken(PathBuf),
    /// The lock file could not be opened or locked.
    #[error("the lock file {path} cannot be used: {source}")]
    Unusable {
        /// Path of the lock file.
        path: PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
}

/// Held as long as the process uses the directory; the system releases it when the process ends in any way. There are
/// two locks: one of a file, as earlier versions use, and one of the directory itself, which stays locked if the file
/// is removed.
#[derive(Debug)]
pub struct DirectoryLock {
    _file: File,
    _directory: File,
}

impl DirectoryLock {
    /// Whether another process has the directory; the locks are only checked.
    #[must_use]
    pub fn is_taken(directory: &Path) -> bool {
        [directory.join(FILE), directory.to_owned()].iter().any(|path| {
            File::open(path).is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
        })
    }

    /// Locks the directory.
    ///
    /// # Errors
    /// Another process has it, or the lock file cannot be used.
    pub fn take(directory: &Path) -> Result<Self, LockFault> {
        let locked = |file: File, path: &Path| match file.try_lock() {
            Ok(()) => Ok(file),
            Err(TryLockError::WouldBlock) => Err(LockFault::Taken(directory.to_owned())),
            Err(TryLockError::Error(source)) => Err(LockFault::Unusable { path: path.to_owned(), source }),
        };
        let unusable = |path: &Path| {
            let path = path.to_owned();
            move |source| LockFault::Unusable { path, source }
        };
        // The directory first: a process that meets a service whose file was removed leaves no new file.
        let opened = File::open(directory).map_err(unusable(directory))?;
        let opened = locked(opened, directory)?;
        let path = directory.join(FILE);
        let file = File::options().create(true).write(true).truncate(false).open(&path);
        let file = locked(file.map_err(unusable(&path))?, &path)?;
        Ok(Self { _file: file, _directory: opened })
    }
}

/// Name of the lock file.
const FILE: &str = "trunnion.lock";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_removed_lock_file_lets_nobody_in() {
        let folder = tempfile::TempDir::new().expect("a directory");
        let held = DirectoryLock::take(folder.path()).expect("free");
        std::fs::remove_file(folder.path().join(FILE)).expect("removed");
        assert!(matches!(DirectoryLock::take(folder.path()), Err(LockFault::Taken(_))));
        assert!(DirectoryLock::is_taken(folder.path()));
        assert!(!folder.path().join(FILE).exists(), "who was refused left a file");
        drop(held);
        assert!(!DirectoryLock::is_taken(folder.path()));
        assert!(DirectoryLock::take(folder.path()).is_ok());
    }

    #[test]
    fn the_file_alone_keeps_others_out_as_earlier_versions_hold_it() {
        let folder = tempfile::TempDir::new().expect("a directory");
        let earlier = File::create(folder.path().join(FILE)).expect("a file");
        earlier.try_lock().expect("free");
        assert!(matches!(DirectoryLock::take(folder.path()), Err(LockFault::Taken(_))));
        assert!(DirectoryLock::is_taken(folder.path()));
    }
}
