//! Marks of the running jobs, for the next process if this one dies: a small file for each, written before the
//! computation and removed after it. The files survive the process but need not survive the computer: if the computer
//! died, no job was the cause.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::BlobFault;

/// Folder of the marks in the data directory.
const FOLDER: &str = "computing";
/// File in which Linux identifies this start of the computer.
const BOOT_ID: &str = "/proc/sys/kernel/random/boot_id";
/// Content of the mark of a job that is computed alone.
const ALONE: &str = "alone";
/// Content of any other mark.
const BESIDE: &str = "beside";

/// Jobs that were running when the process died.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Died {
    /// Jobs that ran beside others.
    pub beside: BTreeSet<String>,
    /// Jobs that ran alone.
    pub alone: BTreeSet<String>,
}

/// The marks of one data directory.
#[derive(Debug, Clone)]
pub struct Marks(Arc<Folder>);

#[derive(Debug)]
struct Folder {
    path: PathBuf,
    /// This start of the computer; empty if the system does not report it.
    boot: String,
}

/// A running job, as long as this lives.
#[derive(Debug)]
pub struct Mark(PathBuf);

impl Marks {
    /// Reads and removes the marks of an earlier process, and returns the jobs that it was computing when it died.
    /// Only for the start.
    ///
    /// # Errors
    /// The folder cannot be made, read or cleared.
    pub fn open(data_dir: &Path) -> Result<(Self, Died), BlobFault> {
        let boot = fs::read_to_string(BOOT_ID).unwrap_or_default();
        Self::open_at(data_dir, boot.trim())
    }

    fn open_at(data_dir: &Path, boot: &str) -> Result<(Self, Died), BlobFault> {
        let path = data_dir.join(FOLDER);
        fs::create_dir_all(&path).map_err(BlobFault::at("making", &path))?;
        let mut died = Died::default();
        for entry in fs::read_dir(&path).map_err(BlobFault::at("reading", &path))? {
            let mark = entry.map_err(BlobFault::at("reading", &path))?.path();
            // An unreadable mark blames no job.
            let text = fs::read_to_string(&mark).unwrap_or_default();
            fs::remove_file(&mark).map_err(BlobFault::at("removing", &mark))?;
            let Some(id) = mark.file_name().and_then(|name| name.to_str()) else { continue };
            match text.split_once(' ') {
                Some((then, ALONE)) if then == boot => died.alone.insert(id.to_owned()),
                Some((then, BESIDE)) if then == boot => died.beside.insert(id.to_owned()),
                _ => continue,
            };
        }
        Ok((Self(Arc::new(Folder { path, boot: boot.to_owned() })), died))
    }

    /// Marks this job as running.
    ///
    /// # Errors
    /// The mark cannot be written.
    pub fn set(&self, id: &str, alone: bool) -> io::Result<Mark> {
        let path = self.0.path.join(id);
        self.write(&path, if alone { ALONE } else { BESIDE })?;
        Ok(Mark(path))
    }

    /// Marks that the job is not alone any more. A job that has ended is not marked again.
    ///
    /// # Errors
    /// The mark cannot be written.
    pub fn beside(&self, id: &str) -> io::Result<()> {
        let path = self.0.path.join(id);
        if path.is_file() { self.write(&path, BESIDE) } else { Ok(()) }
    }

    fn write(&self, path: &Path, word: &str) -> io::Result<()> {
        fs::write(path, format!("{} {word}", self.0.boot))
    }
}

impl Drop for Mark {
    fn drop(&mut self) {
        if let Err(fault) = fs::remove_file(&self.0) {
            tracing::warn!(error = %fault, "the mark of an ended job cannot be removed");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_computed_when_the_process_died_is_known_once() {
        let directory = tempfile::TempDir::new().expect("a directory");
        let open = |boot| Marks::open_at(directory.path(), boot).expect("marks");
        let (marks, died) = open("first");
        assert_eq!(died, Died::default());
        drop(marks.set("ended", false).expect("a mark"));
        marks.beside("ended").expect("nothing to do");
        // A process that dies removes nothing.
        for (id, alone) in [("a", false), ("b", true), ("c", true)] {
            std::mem::forget(marks.set(id, alone).expect("a mark"));
        }
        marks.beside("c").expect("a mark");
        std::fs::write(directory.path().join(FOLDER).join("cut"), "").expect("a file");
        let set = |ids: &[&str]| ids.iter().map(|id| (*id).to_owned()).collect::<BTreeSet<_>>();
        let (marks, died) = open("first");
        assert_eq!(died, Died { beside: set(&["a", "c"]), alone: set(&["b"]) });
        // The computer was started again meanwhile.
        std::mem::forget(marks.set("d", true).expect("a mark"));
        let (_marks, died) = open("second");
        assert_eq!(died, Died::default());
        assert_eq!(std::fs::read_dir(directory.path().join(FOLDER)).expect("a folder").count(), 0);
    }
}
