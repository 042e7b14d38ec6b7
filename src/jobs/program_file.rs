//! A file that came in, as work reads it: how much of it has been read tells how far the work is.

use std::fs::File;
use std::io::{self, Read};
use std::os::unix::fs::FileExt;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::process::ProgramSource;
use crate::store::{
    BlobFault, Blobs, Damage, DamagedFile, Draft, FileState, Sha256Hex, SoundFile, StoredThing,
};

/// A file that came in, complete and open: whatever becomes of its name, its bytes are read from what was opened.
#[derive(Debug, Clone)]
pub struct InputFile {
    file: Arc<File>,
    /// How it stood when its bytes were known to be those of its digest.
    state: FileState,
    /// Its length \[bytes\].
    pub length: u64,
    /// Its digest.
    pub sha256: Sha256Hex,
    /// Bytes read of it so far, over all passes.
    read: Arc<AtomicU64>,
}

impl InputFile {
    /// A file that was kept, read once to its end and found to be what was kept. Blocks.
    ///
    /// # Errors
    /// It is missing, has other bytes, or cannot be read.
    pub fn kept(blobs: &Blobs, sha256: &str) -> Result<Self, BlobFault> {
        let SoundFile { file, state, length } = blobs.read_sound(sha256)?;
        Ok(Self { file: Arc::new(file), state, length, sha256: sha256.to_owned(), read: Arc::default() })
    }

    /// A file that was just written.
    ///
    /// # Errors
    /// As many files are open as may be, or the system does not tell how it stands.
    pub fn of(draft: &Draft) -> io::Result<Self> {
        let file = draft.file()?;
        let state = FileState::of(&file)?;
        let (length, sha256) = (draft.length(), draft.sha256());
        Ok(Self { file: Arc::new(file), state, length, sha256, read: Arc::default() })
    }

    /// Bytes read of it so far, over all passes: goes on counting.
    pub(super) fn counted(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.read)
    }

    /// Whether the file is still as it was when its bytes were known: then everything that was read of it is what was stored.
    ///
    /// # Errors
    /// Somebody has written to it.
    pub(super) fn is_unchanged(&self) -> Result<(), DamagedFile> {
        match FileState::of(&self.file) {
            Ok(now) if now == self.state => Ok(()),
            _ => Err(DamagedFile {
                what: StoredThing::File,
                sha256: self.sha256.clone(),
                damage: Damage::WrittenTo,
            }),
        }
    }
}

impl ProgramSource for InputFile {
    fn open(&self) -> io::Result<Box<dyn Read + Send + '_>> {
        Ok(Box::new(Counted { file: &self.file, at: 0, read: &self.read }))
    }
}

/// Reads from a place of its own in a file that others read too, and counts what is read.
struct Counted<'a> {
    file: &'a File,
    at: u64,
    read: &'a AtomicU64,
}

impl Read for Counted<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read_at(buffer, self.at)?;
        self.at += read as u64;
        // Nothing else is ordered by this number.
        self.read.fetch_add(read as u64, Ordering::Relaxed);
        Ok(read)
    }
}
