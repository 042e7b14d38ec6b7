//! Programs and results as files named by their SHA-256. A file is complete, on disk and under its name before any
//! row names it.

use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use sha2::{Digest, Sha256};
use tempfile::NamedTempFile;
use thiserror::Error;
use tokio::sync::{OwnedRwLockReadGuard, OwnedRwLockWriteGuard, RwLock};

use super::StorageFault;
use super::writable::Writable;

/// A SHA-256 in lower-case hex.
pub type Sha256Hex = String;

/// A file could not be written, kept or opened.
#[derive(Debug, Error)]
#[error("while {doing} {path}: {source}")]
pub struct BlobFault {
    doing: &'static str,
    path: PathBuf,
    source: io::Error,
}

impl BlobFault {
    pub(super) fn at<'a>(doing: &'static str, path: &'a Path) -> impl FnOnce(io::Error) -> Self + 'a {
        move |source| Self { doing, path: path.to_owned(), source }
    }

    /// What ails the disk, where it is the disk.
    #[must_use]
    pub fn storage(&self) -> Option<StorageFault> {
        StorageFault::of(&self.source)
    }
}

/// The files of one data directory: `blobs/<aa>/<sha256>`, and `spool/` for what is not complete yet.
#[derive(Debug, Clone)]
pub struct Blobs {
    kept: PathBuf,
    spool: PathBuf,
    /// Shared by those who keep files until their rows name them; alone for who removes what no row names.
    naming: Arc<RwLock<()>>,
    writable: Arc<Writable>,
    /// Folders below `kept` whose names are on the disk, as far as this process has made sure.
    settled: Arc<Mutex<HashSet<PathBuf>>>,
}

/// A file being written; it vanishes unless it is kept.
#[derive(Debug)]
pub struct Draft {
    file: NamedTempFile,
    hasher: Sha256,
    length: u64,
    limit: u64,
}

/// More bytes than a draft may hold; the kind of the fault of writing is then [`io::ErrorKind::FileTooLarge`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("what is made would be longer than {limit} bytes")]
pub struct DraftTooLong {
    /// The limit \[bytes\].
    pub limit: u64,
}

impl Blobs {
    /// Opens the directories and removes what an earlier process left half written.
    ///
    /// # Errors
    /// A directory cannot be made or read.
    pub fn open(data_dir: &Path) -> Result<Self, BlobFault> {
        let (kept, spool) = (data_dir.join("blobs"), data_dir.join("spool"));
        for directory in [&kept, &spool] {
            fs::create_dir_all(directory).map_err(BlobFault::at("making", directory))?;
        }
        // Their names too: without them nothing that is kept below is found again. A process before may have died in between.
        sync_directory(data_dir)?;
        for entry in fs::read_dir(&spool).map_err(BlobFault::at("reading", &spool))? {
            let path = entry.map_err(BlobFault::at("reading", &spool))?.path();
            fs::remove_file(&path).map_err(BlobFault::at("removing", &path))?;
        }
        let (naming, writable, settled) = (Arc::default(), Arc::default(), Arc::default());
        Ok(Self { kept, spool, naming, writable, settled })
    }

    /// Removes files that no row names: kept by a process that ended before it wrote the row. Only for the start,
    /// before anything is written.
    ///
    /// # Errors
    /// A directory cannot be read or a file not removed.
    pub fn sweep(&self, named: &HashSet<Sha256Hex>) -> Result<usize, BlobFault> {
        let mut removed = 0;
        let entries = |path: &Path| -> Result<Vec<PathBuf>, BlobFault> {
            let listed = fs::read_dir(path).map_err(BlobFault::at("reading", path))?;
            listed
                .map(|entry| entry.map(|entry| entry.path()).map_err(BlobFault::at("reading", path)))
                .collect()
        };
        for folder in entries(&self.kept)? {
            for path in entries(&folder)? {
                let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
                if !named.contains(name) {
                    fs::remove_file(&path).map_err(BlobFault::at("removing", &path))?;
                    removed += 1;
                }
            }
        }
        Ok(removed)
    }

    /// Whether a file can be written, as far as one was within the last second. Blocks.
    ///
    /// # Errors
    /// It cannot.
    pub fn check(&self) -> Result<(), Arc<BlobFault>> {
        self.writable.check(&self.spool)
    }

    /// A new, empty draft.
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn draft(&self) -> Result<Draft, BlobFault> {
        let file =
            NamedTempFile::new_in(&self.spool).map_err(BlobFault::at("making a file in", &self.spool))?;
        Ok(Draft { file, hasher: Sha256::new(), length: 0, limit: u64::MAX })
    }

    /// A file for what rests between two steps of a computation; it goes with what is returned.
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn scratch(&self) -> io::Result<NamedTempFile> {
        NamedTempFile::new_in(&self.spool)
    }

    /// Puts a draft under its digest: data to disk, folder to disk, rename, name to disk. The same bytes once more change
    /// nothing.
    ///
    /// # Errors
    /// The file cannot be synchronised or renamed.
    pub fn keep(&self, draft: Draft) -> Result<Sha256Hex, BlobFault> {
        let sha256 = draft.sha256();
        let path = self.path(&sha256);
        let folder = path.parent().unwrap_or(&self.kept).to_owned();
        draft.file.as_file().sync_all().map_err(BlobFault::at("synchronising", draft.file.path()))?;
        self.settle(&folder)?;
        draft.file.persist(&path).map_err(|fault| BlobFault::at("keeping", &path)(fault.error))?;
        sync_directory(&folder)?;
        Ok(sha256)
    }

    /// Makes sure that a folder is there and that its name is on the disk. That it is there is not enough: who made it may
    /// still be synchronising, may have failed to, or may have died before.
    fn settle(&self, folder: &Path) -> Result<(), BlobFault> {
        let mut settled = self.settled.lock().unwrap_or_else(PoisonError::into_inner);
        if settled.contains(folder) && folder.is_dir() {
            return Ok(());
        }
        fs::create_dir_all(folder).map_err(BlobFault::at("making", folder))?;
        sync_directory(&self.kept)?;
        settled.insert(folder.to_owned());
        Ok(())
    }

    /// Opens a kept file.
    ///
    /// # Errors
    /// There is none, or it cannot be opened.
    pub fn read(&self, sha256: &str) -> Result<File, BlobFault> {
        let path = self.path(sha256);
        File::open(&path).map_err(BlobFault::at("opening", &path))
    }

    /// Held from keeping files until a row names them: nothing is removed meanwhile.
    pub async fn naming(&self) -> OwnedRwLockReadGuard<()> {
        Arc::clone(&self.naming).read_owned().await
    }

    /// Held while what no row names is removed; none where files are being named all the time `within`. Who waits for
    /// it keeps all others from naming theirs, and files may be waiting for their row as long as the database is locked:
    /// wait shortly and seldom, or not at all.
    pub async fn removing(&self, within: Duration) -> Option<OwnedRwLockWriteGuard<()>> {
        if within.is_zero() {
            return Arc::clone(&self.naming).try_write_owned().ok();
        }
        tokio::time::timeout(within, Arc::clone(&self.naming).write_owned()).await.ok()
    }

    /// Removes a kept file; one that is gone already is no fault.
    ///
    /// # Errors
    /// It cannot be removed.
    pub fn remove(&self, sha256: &str) -> Result<(), BlobFault> {
        let path = self.path(sha256);
        match fs::remove_file(&path) {
            Err(fault) if fault.kind() != io::ErrorKind::NotFound => {
                Err(BlobFault::at("removing", &path)(fault))
            }
            _ => Ok(()),
        }
    }

    /// Length of a kept file \[bytes\].
    ///
    /// # Errors
    /// There is none, or it cannot be asked.
    pub fn length(&self, sha256: &str) -> Result<u64, BlobFault> {
        let path = self.path(sha256);
        fs::metadata(&path).map(|found| found.len()).map_err(BlobFault::at("asking for", &path))
    }

    /// Where a kept file stands.
    #[must_use]
    pub fn path(&self, sha256: &str) -> PathBuf {
        self.kept.join(sha256.get(..2).unwrap_or("00")).join(sha256)
    }
}

impl Draft {
    /// The same with a limit on its length \[bytes\]; one byte more is a fault of writing.
    #[must_use]
    pub fn within(self, limit: u64) -> Self {
        Self { limit, ..self }
    }

    /// Where the bytes written so far stand.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Bytes written so far.
    #[must_use]
    pub fn length(&self) -> u64 {
        self.length
    }

    /// SHA-256 of the bytes written so far.
    #[must_use]
    pub fn sha256(&self) -> Sha256Hex {
        hex(&self.hasher.clone().finalize())
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.length.saturating_add(bytes.len() as u64) > self.limit {
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, DraftTooLong { limit: self.limit }));
        }
        let written = self.file.write(bytes)?;
        let taken = bytes.get(..written).unwrap_or(bytes);
        self.hasher.update(taken);
        self.length += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

fn sync_directory(path: &Path) -> Result<(), BlobFault> {
    File::open(path).and_then(|folder| folder.sync_all()).map_err(BlobFault::at("synchronising", path))
}

/// SHA-256 of `bytes`.
#[must_use]
pub fn sha256_hex(bytes: &[u8]) -> Sha256Hex {
    hex(&Sha256::digest(bytes))
}

/// Lower-case hex.
pub(super) fn hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    let digit = |nibble: u8| char::from(DIGITS.get(usize::from(nibble)).copied().unwrap_or(b'0'));
    bytes.iter().flat_map(|byte| [digit(byte >> 4), digit(byte & 15)]).collect()
}

#[cfg(test)]
mod tests {
    use std::pin::pin;

    use futures::poll;

    use super::*;

    #[tokio::test]
    async fn who_removes_has_its_turn_before_those_who_name_next_and_waits_no_longer_than_told() {
        let directory = tempfile::TempDir::new().expect("a directory");
        let blobs = Blobs::open(directory.path()).expect("blobs");
        let held = blobs.naming().await;
        assert!(blobs.removing(Duration::ZERO).await.is_none());
        assert!(blobs.removing(Duration::from_millis(1)).await.is_none(), "nobody let go of it");
        let mut removing = pin!(blobs.removing(Duration::from_hours(1)));
        assert!(poll!(removing.as_mut()).is_pending());
        let mut next = pin!(blobs.naming());
        assert!(poll!(next.as_mut()).is_pending(), "behind who removes");
        drop(held);
        let alone = removing.await;
        assert!(alone.is_some() && poll!(next.as_mut()).is_pending());
        drop(alone);
        drop(next.await);
        assert!(blobs.removing(Duration::ZERO).await.is_some());
    }
}
