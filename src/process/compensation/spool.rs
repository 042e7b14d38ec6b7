//! Where a program rests between two steps: places that the caller gives, a file each, say.

use std::io::{self, Read, Write};

use super::super::ProgramSource;

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
}

impl Place {
    /// Every place.
    pub const ALL: [Self; 5] = [Self::Moved, Self::Moves, Self::Written, Self::Changes, Self::Lags];
}

/// Places to put text in and read it from again; what is put there is of no use once the compensation is done.
pub trait Spool {
    /// An empty place to be written, in place of what was there.
    ///
    /// # Errors
    /// It cannot be made.
    fn create(&self, place: Place) -> io::Result<Box<dyn Write + '_>>;

    /// What was written there, from its first byte. Writers are flushed before.
    ///
    /// # Errors
    /// It cannot be opened.
    fn open(&self, place: Place) -> io::Result<Box<dyn Read + '_>>;
}

/// A program that rests in a spool.
pub(super) struct Resting<'a> {
    pub(super) spool: &'a dyn Spool,
    pub(super) place: Place,
}

impl ProgramSource for Resting<'_> {
    fn open(&self) -> io::Result<Box<dyn Read + '_>> {
        self.spool.open(self.place)
    }
}

/// Places in memory: for short programs.
#[derive(Debug, Default)]
pub struct MemorySpool([std::cell::RefCell<Vec<u8>>; 5]);

struct MemoryWriter<'a>(&'a std::cell::RefCell<Vec<u8>>);

impl Write for MemoryWriter<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Spool for MemorySpool {
    fn create(&self, place: Place) -> io::Result<Box<dyn Write + '_>> {
        let cell = &self.0[place as usize];
        cell.borrow_mut().clear();
        Ok(Box::new(MemoryWriter(cell)))
    }

    fn open(&self, place: Place) -> io::Result<Box<dyn Read + '_>> {
        Ok(Box::new(io::Cursor::new(self.0[place as usize].borrow().clone())))
    }
}
