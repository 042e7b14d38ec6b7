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
    file: Option<File>,
    _directory: File,
}

impl DirectoryLock {
    /// Whether another process has the directory; the locks are only checked.
    #[must_use]
    pub fn is_taken(directory: &Path) -> bool {
        [directory.join(LOCK_FILE), directory.to_owned()].iter().any(|path| {
            File::open(path).is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
        })
    }

    /// Locks the directory.
    ///
    /// # Errors
    /// Another process has it, or the lock file cannot be used.
    pub fn take(directory: &Path) -> Result<Self, LockFault> {
        // The directory first: a process that meets a service whose file was removed leaves no new file.
        let mut lock = Self::take_without_file(directory)?;
        let path = directory.join(LOCK_FILE);
        let file = File::options().create(true).write(true).truncate(false).open(&path);
        lock.file = Some(locked(file, &path, directory)?);
        Ok(lock)
    }

    /// Locks a directory that has to stay empty: no lock file is made.
    ///
    /// # Errors
    /// Another process has it, or it cannot be opened.
    pub fn take_without_file(directory: &Path) -> Result<Self, LockFault> {
        let opened = locked(File::open(directory), directory, directory)?;
        Ok(Self { file: None, _directory: opened })
    }
}

fn locked(opened: std::io::Result<File>, path: &Path, directory: &Path) -> Result<File, LockFault> {
    let unusable = |source| LockFault::Unusable { path: path.to_owned(), source };
    let file = opened.map_err(unusable)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(LockFault::Taken(directory.to_owned())),
        Err(TryLockError::Error(source)) => Err(unusable(source)),
    }
}

/// Name of the lock file.
pub(super) const LOCK_FILE: &str = "trunnion.lock";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_removed_lock_file_lets_nobody_in() {
        let folder = tempfile::TempDir::new().expect("a directory");
        let held = DirectoryLock::take(folder.path()).expect("free");
        std::fs::remove_file(folder.path().join(LOCK_FILE)).expect("removed");
        assert!(matches!(DirectoryLock::take(folder.path()), Err(LockFault::Taken(_))));
        assert!(DirectoryLock::is_taken(folder.path()));
        assert!(!folder.path().join(LOCK_FILE).exists(), "who was refused left a file");
        drop(held);
        assert!(!DirectoryLock::is_taken(folder.path()));
        assert!(DirectoryLock::take(folder.path()).is_ok());
    }

    #[test]
    fn the_file_alone_keeps_others_out_as_earlier_versions_hold_it() {
        let folder = tempfile::TempDir::new().expect("a directory");
        let earlier = File::create(folder.path().join(LOCK_FILE)).expect("a file");
        earlier.try_lock().expect("free");
        assert!(matches!(DirectoryLock::take(folder.path()), Err(LockFault::Taken(_))));
        assert!(DirectoryLock::is_taken(folder.path()));
    }
}
