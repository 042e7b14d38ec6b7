//! Reads a stored file: it is opened without following links, and verified before its bytes are used.

use std::fs::{File, Metadata};
use std::io::{self, Read, Seek, SeekFrom};
use std::os::fd::OwnedFd;
use std::os::unix::fs::MetadataExt;
use std::path::Path;

use rustix::fs::{CWD, Mode, OFlags, openat};
use rustix::io::Errno;
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::Sha256Hex;
use super::blobs::hex;

/// Bytes read at a time.
const READ_AT_ONCE: usize = 1 << 18;

/// Stored data is damaged.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("the stored {what} {sha256} {damage}; restore it from a backup and run `trunnion doctor`")]
pub struct DamagedFile {
    /// The kind of the data.
    pub what: StoredThing,
    /// The digest under which it was stored.
    pub sha256: Sha256Hex,
    /// The damage.
    pub damage: Damage,
}

/// Kinds of data that are stored under a digest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StoredThing {
    /// A program, a surface or a table in a file of its own.
    File,
    /// A report in the database.
    Report,
    /// A document of the database with this name.
    Document(String),
}

impl std::fmt::Display for StoredThing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::File => "file",
            Self::Report => "report",
            Self::Document(name) => name,
        })
    }
}

/// The damage of stored data.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum Damage {
    /// It is missing.
    #[error("is missing")]
    Missing,
    /// A link, a folder or a device is in its place.
    #[error("is not a regular file any more, and links are not followed")]
    NoPlainFile,
    /// Its bytes have changed.
    #[error("has changed: its {length} bytes now have the SHA-256 {sha256}")]
    Other {
        /// Length found \[bytes\].
        length: u64,
        /// Digest found.
        sha256: Sha256Hex,
    },
    /// It was written to between its verification and the end of its use.
    #[error("was written to while it was used")]
    WrittenTo,
}

/// The state of a file: every write changes it, but renaming does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FileState {
    inode: (u64, u64),
    length: u64,
    modified: (i64, i64),
}

impl FileState {
    /// The state of an open file.
    ///
    /// # Errors
    /// The system does not report it.
    pub fn of(file: &File) -> io::Result<Self> {
        file.metadata().map(|found| Self::read(&found))
    }

    fn read(found: &Metadata) -> Self {
        Self {
            inode: (found.dev(), found.ino()),
            length: found.len(),
            modified: (found.mtime(), found.mtime_nsec()),
        }
    }
}

/// Opens a regular file below `root`, folder by folder, without following links. It does not wait: opening a pipe
/// would otherwise wait for its writer.
///
/// # Errors
/// The file is missing (`NotFound`), something else is in its place ([`is_no_plain_file`]), or it cannot be opened.
pub(super) fn open_below(root: &Path, folders: &[&str], name: &str) -> io::Result<File> {
    let (directory, plain) = (OFlags::DIRECTORY, OFlags::NONBLOCK);
    let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
    let mut folder: OwnedFd = openat(CWD, root, flags | directory, Mode::empty())?;
    for next in folders {
        folder = openat(&folder, *next, flags | directory, Mode::empty())?;
    }
    let file = File::from(openat(&folder, name, flags | plain, Mode::empty())?);
    if file.metadata()?.is_file() { Ok(file) } else { Err(Errno::LOOP.into()) }
}

/// Whether a file could not be opened because a link, a folder or a device is in its place.
pub(super) fn is_no_plain_file(fault: &io::Error) -> bool {
    matches!(Errno::from_io_error(fault), Some(Errno::LOOP | Errno::NOTDIR | Errno::NXIO | Errno::ISDIR))
}

/// Whether a path leads to a folder, not to a link.
pub(super) fn is_folder(path: &Path) -> bool {
    path.symlink_metadata().is_ok_and(|found| found.is_dir())
}

/// Whether a path leads to a regular file, not to a link.
pub(super) fn is_plain_file(path: &Path) -> bool {
    path.symlink_metadata().is_ok_and(|found| found.is_file())
}

/// Computes the digest of data that was stored under `expected`, while it is read from the first byte to the last.
#[derive(Debug, Clone)]
pub struct Verifying {
    expected: Sha256Hex,
    hasher: Sha256,
    length: u64,
}

impl Verifying {
    /// No bytes read yet.
    #[must_use]
    pub fn new(expected: &str) -> Self {
        Self { expected: expected.to_owned(), hasher: Sha256::new(), length: 0 }
    }

    /// The digest under which it was stored.
    #[must_use]
    pub fn expected(&self) -> &str {
        &self.expected
    }

    /// Takes the next bytes.
    pub fn take(&mut self, bytes: &[u8]) {
        self.hasher.update(bytes);
        self.length += bytes.len() as u64;
    }

    /// Whether all bytes are as stored.
    ///
    /// # Errors
    /// They have changed.
    pub fn finish(self) -> Result<(), DamagedFile> {
        let Self { expected, hasher, length } = self;
        let sha256 = hex(&hasher.finalize());
        if sha256 == expected {
            return Ok(());
        }
        Err(DamagedFile {
            what: StoredThing::File,
            sha256: expected,
            damage: Damage::Other { length, sha256 },
        })
    }
}

/// Reads a file to its end and compares its digest, then returns to its first byte. Returns the state from before the
/// first byte was read.
///
/// # Errors
/// It cannot be read, or `each` failed; the inner error says that its bytes have changed.
pub(super) fn verify(
    file: &mut File,
    sha256: &str,
    mut each: impl FnMut(u64) -> io::Result<()>,
) -> io::Result<Result<FileState, DamagedFile>> {
    let state = FileState::of(file)?;
    let (mut verifying, mut buffer) = (Verifying::new(sha256), vec![0; READ_AT_ONCE]);
    loop {
        let read = match file.read(&mut buffer) {
            Err(fault) if fault.kind() == io::ErrorKind::Interrupted => continue,
            read => read?,
        };
        let Some(part) = buffer.get(..read).filter(|part| !part.is_empty()) else { break };
        verifying.take(part);
        each(part.len() as u64)?;
    }
    file.seek(SeekFrom::Start(0))?;
    Ok(verifying.finish().map(|()| state))
}

/// Whether a text of the database is as stored.
///
/// # Errors
/// It has another digest.
pub fn verify_text(what: impl FnOnce() -> StoredThing, text: &str, sha256: &str) -> Result<(), DamagedFile> {
    let mut verifying = Verifying::new(sha256);
    verifying.take(text.as_bytes());
    verifying.finish().map_err(|damaged| DamagedFile { what: what(), ..damaged })
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;
    use crate::store::sha256_hex;

    #[test]
    fn no_link_is_followed_in_any_place_of_the_way() {
        let root = tempfile::TempDir::new().expect("a directory");
        let at = |path: &str| root.path().join(path);
        std::fs::create_dir_all(at("blobs/ab")).expect("folders");
        std::fs::write(at("blobs/ab/file"), "bytes").expect("a file");
        std::fs::create_dir(at("blobs/ab/folder")).expect("a folder");
        symlink(at("blobs/ab/file"), at("blobs/ab/link")).expect("a link");
        symlink(at("blobs/ab"), at("blobs/cd")).expect("a link");
        symlink(at("blobs"), at("elsewhere")).expect("a link");
        let open = |root: &str, folder: &str, name: &str| open_below(&at(root), &[folder], name);
        assert!(open("blobs", "ab", "file").is_ok());
        for (root, folder, name) in [
            ("blobs", "ab", "link"),
            ("blobs", "ab", "folder"),
            ("blobs", "cd", "file"),
            ("elsewhere", "ab", "file"),
        ] {
            let fault = open(root, folder, name).expect_err("refused");
            assert!(is_no_plain_file(&fault), "{root} {folder} {name}: {fault}");
        }
        let missing = open("blobs", "ab", "none").expect_err("missing");
        assert_eq!(missing.kind(), io::ErrorKind::NotFound);
    }

    #[test]
    fn one_bit_or_one_byte_less_is_told_with_length_and_digest() {
        let root = tempfile::TempDir::new().expect("a directory");
        let path = root.path().join("file");
        let sha256 = sha256_hex(b"G1 X10\n");
        let look = |bytes: &[u8]| {
            std::fs::write(&path, bytes).expect("written");
            let mut file = File::open(&path).expect("opened");
            verify(&mut file, &sha256, |_| Ok(())).expect("read").map(|_| ())
        };
        assert_eq!(look(b"G1 X10\n"), Ok(()));
        for bytes in [&b"G1 X11\n"[..], b"G1 X10", b""] {
            let damaged = look(bytes).expect_err("damaged");
            let found = Damage::Other { length: bytes.len() as u64, sha256: sha256_hex(bytes) };
            assert_eq!(damaged.damage, found);
            assert!(damaged.to_string().contains(&sha256), "{damaged}");
        }
    }

    #[test]
    fn who_writes_to_a_file_changes_its_state() {
        let root = tempfile::TempDir::new().expect("a directory");
        let path = root.path().join("file");
        std::fs::write(&path, "G1 X10\n").expect("written");
        let file = File::open(&path).expect("opened");
        let before = FileState::of(&file).expect("a state");
        assert_eq!(FileState::of(&file).expect("a state"), before);
        std::thread::sleep(std::time::Duration::from_millis(20));
        std::fs::write(&path, "G1 X11\n").expect("written");
        assert_ne!(FileState::of(&file).expect("a state"), before);
    }
}
