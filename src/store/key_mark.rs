//! A file that changes whenever another process has changed the API keys, so that the service that runs can tell
//! without asking the database at every request.

use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

const FILE: &str = "keys.changed";

/// Which state of the file was seen; equal ones mean that nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KeyMark {
    inode: u64,
    length: u64,
    modified_s: i64,
    modified_ns: i64,
}

impl KeyMark {
    /// The file as it is now; none where there is none.
    #[must_use]
    pub fn of(directory: &Path) -> Option<Self> {
        let file = std::fs::metadata(directory.join(FILE)).ok()?;
        Some(Self {
            inode: file.ino(),
            length: file.len(),
            modified_s: file.mtime(),
            modified_ns: file.mtime_nsec(),
        })
    }
}

/// Says that the keys have changed. `turn` is a text never used before.
///
/// # Errors
/// The file cannot be written.
pub fn mark_key_change(directory: &Path, turn: &str) -> io::Result<()> {
    let file = tempfile::NamedTempFile::new_in(directory)?;
    // The inode of the last file is not free before this one has its own.
    std::fs::write(file.path(), turn)?;
    file.persist(directory.join(FILE)).map_err(|fault| fault.error)?;
    Ok(())
}
