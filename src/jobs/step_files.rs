//! The files of what rests between two steps of a program.

use std::fs::File;
use std::io::{self, Read, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use tempfile::NamedTempFile;

use super::InputFile;
use crate::process::{self, Place};
use crate::store::Blobs;

/// Files for data between two steps; they are removed with this value.
pub(super) struct StepFiles {
    blobs: Blobs,
    /// Number of bytes read of the program, whichever step wrote it.
    read: Arc<AtomicU64>,
    files: Mutex<[Option<NamedTempFile>; Place::ALL.len()]>,
}

impl StepFiles {
    /// No files yet. The reading of a text counts as the reading of this program.
    pub(super) fn new(blobs: Blobs, program: &InputFile) -> Self {
        Self { blobs, read: program.counted(), files: Mutex::new([const { None }; Place::ALL.len()]) }
    }

    /// Does something with the file of a place.
    fn at<T>(
        &self,
        place: Place,
        work: impl FnOnce(&mut Option<NamedTempFile>) -> io::Result<T>,
    ) -> io::Result<T> {
        let mut files = self.files.lock().unwrap_or_else(PoisonError::into_inner);
        work(&mut files[place as usize])
    }
}

impl process::StepStore for StepFiles {
    fn create(&self, place: Place) -> io::Result<Box<dyn Write + Send + '_>> {
        self.at(place, |file| {
            let made = file.insert(self.blobs.scratch()?);
            Ok(Box::new(made.reopen()?) as Box<dyn Write + Send>)
        })
    }

    fn open(&self, place: Place) -> io::Result<Box<dyn Read + Send + '_>> {
        self.at(place, |file| match file {
            Some(file) if place.is_text() => {
                Ok(Box::new(Counted { file: file.reopen()?, read: &self.read }) as Box<dyn Read + Send>)
            }
            Some(file) => Ok(Box::new(file.reopen()?) as Box<dyn Read + Send>),
            None => Err(io::ErrorKind::NotFound.into()),
        })
    }
}

/// Counts the bytes read of a text.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::process::StepStore;

    #[test]
    fn what_is_read_of_a_text_counts_as_read_of_the_program_and_records_do_not() {
        let directory = tempfile::tempdir().unwrap();
        let blobs = Blobs::open(directory.path()).unwrap();
        let program = InputFile::of(&blobs.draft().unwrap()).unwrap();
        let files = StepFiles::new(blobs, &program);
        for (place, counted) in [(Place::OneText, 4), (Place::OneChanges, 4), (Place::OtherText, 8)] {
            files.create(place).unwrap().write_all(b"G1X1").unwrap();
            io::copy(&mut files.open(place).unwrap(), &mut io::sink()).unwrap();
            assert_eq!(program.counted().load(Ordering::Relaxed), counted, "{place:?}");
        }
    }
}
