//! Programs and results as files named by their SHA-256. A file is complete, on disk and under its name before any
//! row names it.

use std::collections::HashSet;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use sha2::{Digest, Sha256};
use tempfile::NamedTempFile;
use thiserror::Error;
use tokio::sync::{OwnedRwLockReadGuard, OwnedRwLockWriteGuard, RwLock};

use super::draft::Draft;
use super::marks::{Died, Marks};
use super::sql::SharedFiles;
use super::stored_file::{is_folder, is_no_plain_file, open_below, verify};
use super::writable::Writable;
use super::{
    Damage, DamagedFile, FileState, Pace, Soundness, StorageFault, StoreError, StoredThing, Verifying,
};

mod copies;

/// A SHA-256 in lower-case hex.
pub type Sha256Hex = String;

/// A file could not be written, kept or opened.
#[derive(Debug, Error)]
pub enum BlobFault {
    /// The system returned an error.
    #[error("while {doing} {path}: {source}")]
    File {
        /// The action that failed.
        doing: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// A folder of the data directory is a link or not a folder.
    #[error("{0} is a link or not a folder, and links are not followed: replace it by the folder itself")]
    NoFolder(PathBuf),
    /// A kept file is damaged.
    #[error(transparent)]
    Damaged(#[from] DamagedFile),
    /// Files are in the database or in a bucket, and one of the two failed.
    #[error(transparent)]
    Rows(StoreError),
}

impl BlobFault {
    pub(super) fn at<'a>(doing: &'static str, path: &'a Path) -> impl FnOnce(io::Error) -> Self + 'a {
        move |source| Self::File { doing, path: path.to_owned(), source }
    }

    /// The fault of the disk, if it is the disk's.
    #[must_use]
    pub fn storage(&self) -> Option<StorageFault> {
        match self {
            Self::File { source, .. } => StorageFault::of(source),
            Self::Rows(fault) => fault.storage(),
            Self::NoFolder(_) | Self::Damaged(_) => None,
        }
    }
}

/// The files of one data directory: `blobs/<aa>/<sha256>`, and `spool/` for incomplete files. If the files are in the
/// database or in a bucket, the directory has copies, which are made when they are needed.
#[derive(Debug, Clone)]
pub struct Blobs {
    kept: PathBuf,
    spool: PathBuf,
    /// Shared by tasks that keep files until their rows name them; exclusive for the removal of files that no row
    /// names.
    naming: Arc<RwLock<()>>,
    writable: Arc<Writable>,
    soundness: Arc<Soundness>,
    /// Folders below `kept` whose names are known to be on the disk.
    settled: Arc<Mutex<HashSet<PathBuf>>>,
    shared: Option<SharedFiles>,
}

/// A kept file that is open and was verified.
#[derive(Debug)]
pub struct SoundFile {
    /// The file, at its first byte.
    pub file: File,
    /// Its state before it was verified.
    pub state: FileState,
    /// Length of the file \[bytes\].
    pub length: u64,
}

impl Blobs {
    /// Opens the directories and removes incomplete files of an earlier process.
    ///
    /// # Errors
    /// A directory cannot be created or read.
    pub fn open(data_dir: &Path) -> Result<Self, BlobFault> {
        let (kept, spool) = (data_dir.join("blobs"), data_dir.join("spool"));
        for directory in [&kept, &spool] {
            fs::create_dir_all(directory).map_err(BlobFault::at("making", directory))?;
            if !is_folder(directory) {
                return Err(BlobFault::NoFolder(directory.clone()));
            }
        }
        // Their names must be on the disk too: without them no file below is found again. An earlier process may have
        // died in between.
        sync_directory(data_dir)?;
        for entry in fs::read_dir(&spool).map_err(BlobFault::at("reading", &spool))? {
            let path = entry.map_err(BlobFault::at("reading", &spool))?.path();
            fs::remove_file(&path).map_err(BlobFault::at("removing", &path))?;
        }
        Ok(Self {
            kept,
            spool,
            naming: Arc::default(),
            writable: Arc::default(),
            soundness: Arc::default(),
            settled: Arc::default(),
            shared: None,
        })
    }

    /// Removes files that no row names: an earlier process kept them and ended before it wrote the row. Only for the
    /// start, before anything is written.
    ///
    /// # Errors
    /// A directory cannot be read or a file not removed.
    pub fn sweep(&self, named: &HashSet<Sha256Hex>) -> Result<usize, BlobFault> {
        self.remove_if(|path| {
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            !named.contains(name)
        })
    }

    fn remove_if(&self, goes: impl Fn(&Path) -> bool) -> Result<usize, BlobFault> {
        let mut removed = 0;
        let entries = |path: &Path| -> Result<Vec<PathBuf>, BlobFault> {
            let listed = fs::read_dir(path).map_err(BlobFault::at("reading", path))?;
            listed
                .map(|entry| entry.map(|entry| entry.path()).map_err(BlobFault::at("reading", path)))
                .collect()
        };
        for folder in entries(&self.kept)? {
            // Nothing is removed from the target of a link.
            if !is_folder(&folder) {
                return Err(BlobFault::NoFolder(folder));
            }
            for path in entries(&folder)? {
                if goes(&path) {
                    fs::remove_file(&path).map_err(BlobFault::at("removing", &path))?;
                    removed += 1;
                }
            }
        }
        Ok(removed)
    }

    /// Whether a file can be written; the result is at most a second old. Blocks.
    ///
    /// # Errors
    /// No file can be written.
    pub fn check(&self) -> Result<(), Arc<BlobFault>> {
        self.writable.check(&self.spool)
    }

    /// The marks of running jobs, and those of a process that died. Only for the start.
    ///
    /// # Errors
    /// Their folder cannot be used.
    pub fn marks(&self) -> Result<(Marks, Died), BlobFault> {
        Marks::open(self.spool.parent().unwrap_or(&self.spool))
    }

    /// A new, empty draft.
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn draft(&self) -> Result<Draft, BlobFault> {
        let file =
            NamedTempFile::new_in(&self.spool).map_err(BlobFault::at("making a file in", &self.spool))?;
        Ok(Draft::new(file))
    }

    /// A file for data between two steps of a computation; it is removed when the returned value is dropped.
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn scratch(&self) -> io::Result<NamedTempFile> {
        NamedTempFile::new_in(&self.spool)
    }

    /// A file without a name in the folder of incomplete files: it is gone when it is closed, however the process ends.
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn nameless(&self) -> io::Result<File> {
        tempfile::tempfile_in(&self.spool)
    }

    /// Moves a draft to the name of its digest: data to disk, folder to disk, rename, name to disk. If the same bytes
    /// are already there, nothing changes. If the directory has copies, the file itself comes first. Blocks.
    ///
    /// # Errors
    /// The file cannot be synchronised or renamed, or the database failed.
    pub fn keep(&self, draft: Draft) -> Result<Sha256Hex, BlobFault> {
        match &self.shared {
            None => {}
            #[cfg(feature = "scale-out")]
            Some(shared) => shared.keep(&draft.sha256(), draft.file.as_file(), draft.length())?,
            #[cfg(not(feature = "scale-out"))]
            Some(never) => match *never {},
        }
        self.keep_here(draft)
    }

    fn keep_here(&self, draft: Draft) -> Result<Sha256Hex, BlobFault> {
        let sha256 = draft.sha256();
        let path = self.path(&sha256);
        let folder = path.parent().unwrap_or(&self.kept).to_owned();
        draft.file.as_file().sync_all().map_err(BlobFault::at("synchronising", draft.file.path()))?;
        self.settle(&folder)?;
        draft.file.persist(&path).map_err(|fault| BlobFault::at("keeping", &path)(fault.error))?;
        sync_directory(&folder)?;
        self.soundness.sound(&sha256);
        Ok(sha256)
    }

    /// Makes sure that a folder exists and that its name is on the disk. It is not enough that it exists: the process
    /// that created it may still be synchronising, may have failed to, or may have died before.
    fn settle(&self, folder: &Path) -> Result<(), BlobFault> {
        let mut settled = self.settled.lock().unwrap_or_else(PoisonError::into_inner);
        let is_there = is_folder(folder);
        if settled.contains(folder) && is_there {
            return Ok(());
        }
        if !is_there && folder.symlink_metadata().is_ok() {
            return Err(BlobFault::NoFolder(folder.to_owned()));
        }
        fs::create_dir_all(folder).map_err(BlobFault::at("making", folder))?;
        sync_directory(&self.kept)?;
        settled.insert(folder.to_owned());
        Ok(())
    }

    /// The known damage.
    #[must_use]
    pub fn soundness(&self) -> &Arc<Soundness> {
        &self.soundness
    }

    /// Opens a kept file without verifying it.
    ///
    /// # Errors
    /// It is missing, not a regular file, or cannot be opened.
    pub fn read(&self, sha256: &str) -> Result<File, BlobFault> {
        self.opened(sha256).map_err(|fault| self.note(fault))
    }

    fn opened(&self, sha256: &str) -> Result<File, BlobFault> {
        match self.opened_here(sha256) {
            Err(BlobFault::Damaged(damaged)) if self.are_copies() => {
                self.copy(damaged)?;
                self.opened_here(sha256)
            }
            opened => opened,
        }
    }

    fn opened_here(&self, sha256: &str) -> Result<File, BlobFault> {
        open_below(&self.kept, &[folder_of(sha256)], sha256).map_err(|fault| {
            let damage = match fault.kind() {
                io::ErrorKind::NotFound => Damage::Missing,
                _ if is_no_plain_file(&fault) => Damage::NoPlainFile,
                _ => return BlobFault::at("opening", &self.path(sha256))(fault),
            };
            DamagedFile { what: StoredThing::File, sha256: sha256.to_owned(), damage }.into()
        })
    }

    /// Opens a kept file and reads it to its end, to verify it. Blocks.
    ///
    /// # Errors
    /// It is missing, not a regular file, has other bytes, or cannot be read.
    pub fn read_sound(&self, sha256: &str) -> Result<SoundFile, BlobFault> {
        let found = match self.verified(sha256, |_| Ok(())) {
            // Only a copy: the file itself decides.
            Err(BlobFault::Damaged(damaged)) if self.are_copies() => {
                self.copy(damaged).and_then(|()| self.verified(sha256, |_| Ok(())))
            }
            found => found,
        };
        let found = found.map_err(|fault| self.note(fault))?;
        self.soundness.sound(sha256);
        Ok(found)
    }

    /// Reads a kept file to its end at a pace, or until the pace is over, which is a fault too. Damage is not
    /// recorded, because the file may have been released meanwhile. Blocks.
    ///
    /// # Errors
    /// The same as [`Self::read_sound`].
    pub fn look(&self, sha256: &str, pace: &Pace) -> Result<(), BlobFault> {
        let each = |bytes| {
            pace.spend_blocking(bytes);
            if pace.is_over() { Err(io::Error::other("stopped")) } else { Ok(()) }
        };
        if !self.are_copies() {
            return self.verified(sha256, each).map(drop);
        }
        let mut verifying = Verifying::new(sha256);
        let is_there = self.read_shared(sha256, |bytes| {
            verifying.take(bytes);
            each(bytes.len() as u64).map_err(BlobFault::at("reading the file", Path::new(sha256)))
        })?;
        if !is_there {
            let (what, damage) = (StoredThing::File, Damage::Missing);
            return Err(DamagedFile { what, sha256: sha256.to_owned(), damage }.into());
        }
        Ok(verifying.finish()?)
    }

    fn verified(
        &self,
        sha256: &str,
        each: impl FnMut(u64) -> io::Result<()>,
    ) -> Result<SoundFile, BlobFault> {
        let mut file = self.opened(sha256)?;
        let verified = verify(&mut file, sha256, each);
        let state = verified.map_err(BlobFault::at("reading", &self.path(sha256)))??;
        let length = file.metadata().map_err(BlobFault::at("asking for", &self.path(sha256)))?.len();
        Ok(SoundFile { file, state, length })
    }

    fn note(&self, fault: BlobFault) -> BlobFault {
        if let BlobFault::Damaged(damaged) = &fault {
            self.soundness.damaged(damaged);
        }
        fault
    }

    /// Counts and logs the damage, and returns it. A damaged copy goes, so that the next reader makes a new one.
    #[must_use]
    pub fn noted(&self, damaged: DamagedFile) -> DamagedFile {
        self.soundness.damaged(&damaged);
        if self.are_copies()
            && let Err(fault) = self.remove(&damaged.sha256)
        {
            tracing::warn!(error = %fault, "a damaged copy cannot be removed");
        }
        damaged
    }

    /// Held from keeping files until a row names them: no file is removed meanwhile.
    pub async fn naming(&self) -> OwnedRwLockReadGuard<()> {
        Arc::clone(&self.naming).read_owned().await
    }

    /// Held while files that no row names are removed; `None` if files are being named during all of `within`. The
    /// waiting task keeps all others from naming their files, and files may wait for their row as long as the
    /// database is locked. So wait briefly and rarely, or not at all.
    pub async fn removing(&self, within: Duration) -> Option<OwnedRwLockWriteGuard<()>> {
        if within.is_zero() {
            return Arc::clone(&self.naming).try_write_owned().ok();
        }
        tokio::time::timeout(within, Arc::clone(&self.naming).write_owned()).await.ok()
    }

    /// Removes a kept file; it is not a fault if the file is already gone.
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

    /// Path of a kept file.
    #[must_use]
    pub fn path(&self, sha256: &str) -> PathBuf {
        self.kept.join(folder_of(sha256)).join(sha256)
    }
}

/// The folder of a file among the kept files.
pub(super) fn folder_of(sha256: &str) -> &str {
    sha256.get(..2).unwrap_or("00")
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
#[must_use]
pub fn hex(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 16] = b"0123456789abcdef";
    let digit = |nibble: u8| char::from(DIGITS.get(usize::from(nibble)).copied().unwrap_or(b'0'));
    bytes.iter().flat_map(|byte| [digit(byte >> 4), digit(byte & 15)]).collect()
}

#[cfg(test)]
mod tests {
    use std::pin::pin;

    use futures::poll;

    use super::*;

    #[test]
    fn what_is_gone_is_removed_and_what_cannot_be_removed_is_a_fault() {
        let directory = tempfile::TempDir::new().expect("a directory");
        let blobs = Blobs::open(directory.path()).expect("blobs");
        let (gone, folder) = ("00".repeat(32), "11".repeat(32));
        blobs.remove(&gone).expect("gone already");
        fs::create_dir_all(blobs.path(&folder)).expect("a folder");
        blobs.remove(&folder).expect_err("a folder in its place");
    }

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
