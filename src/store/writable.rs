//! Whether the disk takes a file, found out by writing one.

use std::io::Write;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tempfile::NamedTempFile;

use super::BlobFault;

/// How long an answer holds: whoever asks more often does not make the disk write more often.
const HOLDS: Duration = Duration::from_secs(1);

/// What is written: one page, so that a disk with room for names only counts as full.
const PAGE: [u8; 4096] = [0; 4096];

/// The last answer of the disk.
#[derive(Debug, Default)]
pub(super) struct Writable(Mutex<Asked>);

#[derive(Debug, Default)]
struct Asked {
    at: Option<Instant>,
    fault: Option<Arc<BlobFault>>,
}

impl Writable {
    /// Writes a file in `directory` that goes at once, unless that was done a moment ago or is being done. Blocks.
    pub(super) fn check(&self, directory: &Path) -> Result<(), Arc<BlobFault>> {
        {
            let mut asked = self.asked();
            if asked.at.is_some_and(|at| at.elapsed() < HOLDS) {
                return asked.fault.clone().map_or(Ok(()), Err);
            }
            asked.at = Some(Instant::now());
        }
        let written = NamedTempFile::new_in(directory).and_then(|mut file| file.write_all(&PAGE));
        let fault = written.map_err(BlobFault::at("writing a file in", directory)).err().map(Arc::new);
        self.asked().fault.clone_from(&fault);
        fault.map_or(Ok(()), Err)
    }

    fn asked(&self) -> MutexGuard<'_, Asked> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
