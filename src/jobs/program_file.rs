//! A file that came in, as work reads it: how much of it has been read tells how far the work is.

use std::fs::File;
use std::io::{self, Read};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::process::ProgramSource;
use crate::store::{BlobFault, Blobs, Draft, Sha256Hex};

/// A file that came in, complete.
#[derive(Debug, Clone)]
pub struct InputFile {
    /// Where it stands.
    pub path: PathBuf,
    /// Its length \[bytes\].
    pub length: u64,
    /// Its digest.
    pub sha256: Sha256Hex,
    /// Bytes read of it so far, over all passes.
    read: Arc<AtomicU64>,
}

impl InputFile {
    /// A file of this length and digest.
    #[must_use]
    pub fn new(path: PathBuf, length: u64, sha256: Sha256Hex) -> Self {
        Self { path, length, sha256, read: Arc::default() }
    }

    /// A file that was kept.
    ///
    /// # Errors
    /// There is none, or it cannot be opened.
    pub fn kept(blobs: &Blobs, sha256: &str) -> Result<Self, BlobFault> {
        Ok(Self::new(blobs.path(sha256), blobs.length(sha256)?, sha256.to_owned()))
    }

    /// Bytes read of it so far, over all passes: goes on counting.
    pub(super) fn counted(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.read)
    }
}

impl From<&Draft> for InputFile {
    fn from(draft: &Draft) -> Self {
        Self::new(draft.path().to_owned(), draft.length(), draft.sha256())
    }
}

impl ProgramSource for InputFile {
    fn open(&self) -> io::Result<Box<dyn Read + Send + '_>> {
        Ok(Box::new(Counted { file: File::open(&self.path)?, read: &self.read }))
    }
}

/// Counts what is read.
struct Counted<'a> {
    file: File,
    read: &'a AtomicU64,
}

impl Read for Counted<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.file.read(buffer)?;
        // Nothing else is ordered by this number.
        self.read.fetch_add(read as u64, Ordering::Relaxed);
        Ok(read)
    }
}
