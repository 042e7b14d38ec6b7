//! The files of what rests between two steps of a program.

use std::io::{self, Read, Write};
use std::sync::{Mutex, PoisonError};

use tempfile::NamedTempFile;

use crate::process::{self, Place};
use crate::store::Blobs;

/// Files for data between two steps; they are removed with this value.
pub(super) struct StepFiles {
    blobs: Blobs,
    files: Mutex<[Option<NamedTempFile>; Place::ALL.len()]>,
}

impl StepFiles {
    /// No files yet.
    pub(super) fn new(blobs: Blobs) -> Self {
        Self { blobs, files: Mutex::new([const { None }; Place::ALL.len()]) }
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
    fn create(&self, place: Place) -> io::Result<Box<dyn Write + '_>> {
        self.at(place, |file| {
            let made = file.insert(self.blobs.scratch()?);
            Ok(Box::new(made.reopen()?) as Box<dyn Write>)
        })
    }

    fn open(&self, place: Place) -> io::Result<Box<dyn Read + Send + '_>> {
        self.at(place, |file| match file {
            Some(file) => Ok(Box::new(file.reopen()?) as Box<dyn Read + Send>),
            None => Err(io::ErrorKind::NotFound.into()),
        })
    }
}
