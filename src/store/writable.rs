//! Checks whether the disk can be written, by writing a file.

use std::io::{self, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use rustix::io::Errno;
use tempfile::NamedTempFile;

use super::BlobFault;

/// How long an answer is valid: more frequent questions do not make the disk write more often.
const HOLDS: Duration = Duration::from_secs(1);

/// The bytes to write: one page, so that a disk with room only for names counts as full.
const PAGE: [u8; 4096] = [0; 4096];

/// The last answer of the disk.
#[derive(Debug, Default)]
pub(super) struct Writable(Mutex<Asked>);

#[derive(Debug, Default)]
struct Asked {
    /// Time of the last answer.
    at: Option<Instant>,
    fault: Option<Arc<BlobFault>>,
    /// Time since when a file is being written.
    since: Option<Instant>,
}

impl Writable {
    /// Writes a file in `directory` that is removed at once. If that was done a moment ago or is still being done,
    /// the last answer is returned; if no answer came for longer than an answer is valid, the disk fails. Blocks.
    pub(super) fn check(&self, directory: &Path) -> Result<(), Arc<BlobFault>> {
        self.ask(directory, || NamedTempFile::new_in(directory).and_then(|mut file| file.write_all(&PAGE)))
    }

    /// The same as `check`, with the action on the disk as a parameter.
    fn ask(&self, directory: &Path, write: impl FnOnce() -> io::Result<()>) -> Result<(), Arc<BlobFault>> {
        let doing = "writing a file in";
        {
            let mut asked = self.asked();
            if let Some(since) = asked.since {
                if since.elapsed() >= HOLDS {
                    return Err(Arc::new(BlobFault::at(doing, directory)(Errno::IO.into())));
                }
                return asked.last();
            }
            if asked.at.is_some_and(|at| at.elapsed() < HOLDS) {
                return asked.last();
            }
            asked.since = Some(Instant::now());
        }
        let fault = write().map_err(BlobFault::at(doing, directory)).err().map(Arc::new);
        let mut asked = self.asked();
        *asked = Asked { at: Some(Instant::now()), fault, since: None };
        asked.last()
    }

    fn asked(&self) -> MutexGuard<'_, Asked> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Asked {
    fn last(&self) -> Result<(), Arc<BlobFault>> {
        self.fault.clone().map_or(Ok(()), Err)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::StorageFault;

    #[test]
    fn nothing_is_written_beside_a_write_that_hangs_and_the_disk_is_told_to_fail() {
        let (writable, directory) = (Writable::default(), Path::new("spool"));
        let beside = || writable.ask(directory, || panic!("a second write began"));
        let of = |answer: Result<(), Arc<BlobFault>>| answer.expect_err("a fault").storage();
        writable
            .ask(directory, || {
                beside().expect("not known yet");
                writable.asked().since = Instant::now().checked_sub(HOLDS);
                assert_eq!(of(beside()), Some(StorageFault::Failing));
                Ok(())
            })
            .expect("it was written at last");
        beside().expect("that answer holds");
        writable.asked().at = Instant::now().checked_sub(HOLDS);
        let full = || Err(Errno::NOSPC.into());
        assert_eq!(of(writable.ask(directory, full)), Some(StorageFault::Full));
        assert_eq!(of(beside()), Some(StorageFault::Full));
    }
}
