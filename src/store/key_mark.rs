//! A file that changes whenever another process has changed the API keys, so that a running service notices it
//! without asking the database at every request.

use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

const FILE: &str = "keys.changed";

/// How long a check of the mark is valid: at a full load of small calls, a check at each call took a twentieth of the
/// time. A command that changes the keys returns only after this time, so that every later request sees the change.
pub const KEY_MARK_TRUSTED: Duration = Duration::from_millis(1);

/// The state of the file at a check; equal states mean that nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KeyMark {
    inode: u64,
    length: u64,
    modified_s: i64,
    modified_ns: i64,
}

impl KeyMark {
    /// Path of the file in this data directory.
    #[must_use]
    pub fn place(directory: &Path) -> PathBuf {
        directory.join(FILE)
    }

    /// The present file at this path; `None` if the path has no file.
    #[must_use]
    pub fn at(place: &Path) -> Option<Self> {
        let file = std::fs::metadata(place).ok()?;
        Some(Self {
            inode: file.ino(),
            length: file.len(),
            modified_s: file.mtime(),
            modified_ns: file.mtime_nsec(),
        })
    }
}

/// Marks that the keys have changed, and waits until a running service has made its next check. `turn` is a text that
/// was never used before.
///
/// # Errors
/// The file cannot be written.
pub fn mark_key_change(directory: &Path, turn: &str) -> io::Result<()> {
    let file = tempfile::NamedTempFile::new_in(directory)?;
    // The inode of the last file is not free before this file has its own.
    std::fs::write(file.path(), turn)?;
    file.persist(KeyMark::place(directory)).map_err(|fault| fault.error)?;
    std::thread::sleep(KEY_MARK_TRUSTED);
    Ok(())
}
