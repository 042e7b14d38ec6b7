//! Storage for a program between two steps, in places that the caller provides, for example one file each.

use std::io;
use std::io::{Read, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::source::ProgramSource;
use crate::listed::listed;

listed! {
    /// The content of a place.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub enum Place {
        /// The program between two steps. Steps write to `OneText` and `OtherText` in turn.
        OneText,
        /// The program between two steps.
        OtherText,
        /// The changes that all steps so far made to every motion, one record each.
        OneChanges,
        /// The same, in turn with `OneChanges`. A step reads one of them and writes the other.
        OtherChanges,
        /// The written program, if it is run through the drives.
        Written,
        /// The changes that all steps made to every motion, one record each, if the program is run through the drives.
        AllChanges,
        /// Servo lag of every line, 12 bytes each.
        Lags,
    }
}

impl Place {
    /// Whether it has the program between two steps.
    #[must_use]
    pub const fn is_text(self) -> bool {
        matches!(self, Self::OneText | Self::OtherText)
    }
}

/// Places that store text to be read again. Their content is not needed after the compensation.
pub trait StepStore: Sync {
    /// Empties a place and opens it for writing.
    ///
    /// # Errors
    /// The place cannot be created.
    fn create(&self, place: Place) -> io::Result<Box<dyn Write + Send + '_>>;

    /// The content of a place, from its first byte. Its writers were flushed before.
    ///
    /// # Errors
    /// The place cannot be opened.
    fn open(&self, place: Place) -> io::Result<Box<dyn Read + Send + '_>>;
}

/// A program in a place of a store.
pub(in crate::process) struct StoredText<'a> {
    pub(in crate::process) store: &'a dyn StepStore,
    pub(in crate::process) place: Place,
}

impl ProgramSource for StoredText<'_> {
    fn open(&self) -> io::Result<Box<dyn Read + Send + '_>> {
        self.store.open(self.place)
    }
}

/// Places in memory: for short programs.
#[derive(Debug, Default)]
pub struct MemoryStepStore([Mutex<Vec<u8>>; Place::ALL.len()]);

struct MemoryWriter<'a>(&'a Mutex<Vec<u8>>);

/// No code panics while it holds the lock, and text that was written in part is thrown away in any case.
fn held(place: &Mutex<Vec<u8>>) -> MutexGuard<'_, Vec<u8>> {
    place.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Write for MemoryWriter<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        held(self.0).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl StepStore for MemoryStepStore {
    fn create(&self, place: Place) -> io::Result<Box<dyn Write + Send + '_>> {
        let cell = &self.0[place as usize];
        held(cell).clear();
        Ok(Box::new(MemoryWriter(cell)))
    }

    fn open(&self, place: Place) -> io::Result<Box<dyn Read + Send + '_>> {
        Ok(Box::new(io::Cursor::new(held(&self.0[place as usize]).clone())))
    }
}
