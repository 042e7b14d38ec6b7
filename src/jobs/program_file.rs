//! A program in a file, as the core reads it.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::process::ProgramSource;

/// A program in a file.
pub(super) struct FileSource<'a>(pub(super) &'a Path);

impl ProgramSource for FileSource<'_> {
    fn open(&self) -> io::Result<Box<dyn Read + Send + '_>> {
        Ok(Box::new(File::open(self.0)?))
    }
}
