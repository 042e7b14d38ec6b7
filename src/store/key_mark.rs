//! A file that changes whenever another process has changed the API keys, so that the service that runs can tell
//! without asking the database at every request.

use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

const FILE: &str = "keys.changed";

/// How long what was seen of the mark is trusted without another look: at a full load of small calls a look at each was
/// a twentieth of their cost. Whoever changes the keys comes back only after so long, so that all that is asked of the
/// service from then on sees the change.
pub const KEY_MARK_TRUSTED: Duration = Duration::from_millis(1);

/// Which state of the file was seen; equal ones mean that nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct KeyMark {
    inode: u64,
    length: u64,
    modified_s: i64,
    modified_ns: i64,
}

impl KeyMark {
    /// Where the file of this data directory is.
    #[must_use]
    pub fn place(directory: &Path) -> PathBuf {
        directory.join(FILE)
    }

    /// The file at this place as it is now; none where there is none.
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

/// Says that the keys have changed, and waits until a service that runs has taken its next look. `turn` is a text never
/// used before.
///
/// # Errors
/// The file cannot be written.
pub fn mark_key_change(directory: &Path, turn: &str) -> io::Result<()> {
    let file = tempfile::NamedTempFile::new_in(directory)?;
    // The inode of the last file is not free before this one has its own.
    std::fs::write(file.path(), turn)?;
    file.persist(KeyMark::place(directory)).map_err(|fault| fault.error)?;
    std::thread::sleep(KEY_MARK_TRUSTED);
    Ok(())
}
