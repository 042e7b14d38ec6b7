//! Where a program rests between two steps: places that the caller gives, a file each, say.

use std::io;
use std::io::{Read, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::stream::ProgramSource;

/// What rests in a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The program whose ends of motions were moved.
    Moved,
    /// What that step did to every motion, 53 bytes each.
    Moves,
    /// The written program, where it is run through the drives.
    Written,
    /// What all steps did to every motion, 53 bytes each.
    Changes,
    /// What the drives leave of every line, 12 bytes each.
    Lags,
    /// The program whose singular regions were treated.
    Treated,
}

impl Place {
    /// Every place.
    pub const ALL: [Self; 6] =
        [Self::Moved, Self::Moves, Self::Written, Self::Changes, Self::Lags, Self::Treated];
}

/// Places to put text in and read it from again; what is put there is of no use once the compensation is done.
pub trait Spool: Sync {
    /// An empty place to be written, in place of what was there.
    ///
    /// # Errors
    /// It cannot be made.
    fn create(&self, place: Place) -> io::Result<Box<dyn Write + '_>>;

    /// What was written there, from its first byte. Writers are flushed before.
    ///
    /// # Errors
    /// It cannot be opened.
    fn open(&self, place: Place) -> io::Result<Box<dyn Read + Send + '_>>;
}

/// A program that rests in a spool.
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

/// Nobody panics while holding one, and text that was half written is thrown away anyway.
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
