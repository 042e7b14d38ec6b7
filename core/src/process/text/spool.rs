//! Storage for a program between two steps, in places that the caller provides, for example one file each.

use std::io;
use std::io::{Read, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::stream::ProgramSource;

/// The content of a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The program with its ends of motions moved.
    Moved,
    /// What that step did to every motion, 53 bytes each.
    Moves,
    /// The written program, if it is run through the drives.
    Written,
    /// What all steps did to every motion, 53 bytes each.
    Changes,
    /// Servo lag of every line, 12 bytes each.
    Lags,
    /// The program with its singular regions treated.
    Treated,
}

impl Place {
    /// All places.
    pub const ALL: [Self; 6] =
        [Self::Moved, Self::Moves, Self::Written, Self::Changes, Self::Lags, Self::Treated];
}

/// Places that store text to be read again. Their content is not needed after the compensation.
pub trait Spool: Sync {
    /// Empties a place and opens it for writing.
    ///
    /// # Errors
    /// The place cannot be created.
    fn create(&self, place: Place) -> io::Result<Box<dyn Write + '_>>;

    /// The content of a place, from its first byte. Its writers were flushed before.
    ///
    /// # Errors
    /// The place cannot be opened.
    fn open(&self, place: Place) -> io::Result<Box<dyn Read + Send + '_>>;
}

/// A program stored in a spool.
pub(in crate::process) struct Resting<'a> {
    pub(in crate::process) spool: &'a dyn Spool,
    pub(in crate::process) place: Place,
}

impl ProgramSource for Resting<'_> {
    fn open(&self) -> io::Result<Box<dyn Read + Send + '_>> {
        self.spool.open(self.place)
    }
}

/// Places in memory: for short programs.
#[derive(Debug, Default)]
pub struct MemorySpool([Mutex<Vec<u8>>; 6]);

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

impl Spool for MemorySpool {
    fn create(&self, place: Place) -> io::Result<Box<dyn Write + '_>> {
        let cell = &self.0[place as usize];
        held(cell).clear();
        Ok(Box::new(MemoryWriter(cell)))
    }

    fn open(&self, place: Place) -> io::Result<Box<dyn Read + Send + '_>> {
        Ok(Box::new(io::Cursor::new(held(&self.0[place as usize]).clone())))
    }
}
