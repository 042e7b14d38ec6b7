//! Where the text of a program comes from.

use std::io;
use std::io::Read;

/// Bytes read at once \[bytes\].
pub(in crate::process) const CHUNK_BYTES: usize = 64 * 1024;

/// A program that can be read more than once.
pub trait ProgramSource: Sync {
    /// The program from its first byte.
    ///
    /// # Errors
    /// The text cannot be opened.
    fn open(&self) -> io::Result<Box<dyn Read + Send + '_>>;

    /// The file of this index among those that the program may call, from its first byte; `None` if there are not so
    /// many.
    ///
    /// # Errors
    /// The file cannot be opened.
    fn open_subprogram(&self, _index: usize) -> io::Result<Option<OpenSubprogram<'_>>> {
        Ok(None)
    }
}

/// A file beside a program, opened.
pub struct OpenSubprogram<'a> {
    /// Its name.
    pub name: String,
    /// Its bytes.
    pub text: Box<dyn Read + Send + 'a>,
}

impl ProgramSource for [u8] {
    fn open(&self) -> io::Result<Box<dyn Read + Send + '_>> {
        Ok(Box::new(self))
    }
}

impl ProgramSource for Vec<u8> {
    fn open(&self) -> io::Result<Box<dyn Read + Send + '_>> {
        Ok(Box::new(self.as_slice()))
    }
}

pub(in crate::process) fn read_some(input: &mut dyn Read, chunk: &mut [u8]) -> io::Result<usize> {
    loop {
        match input.read(chunk) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            other => return other,
        }
    }
}
