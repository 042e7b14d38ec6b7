//! The answer of a program that came as an archive.

use std::io::{self, Read};

use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::program_files::{Part, ProgramFilesFault};
use super::{InputFile, Spool};
use crate::store::Draft;

/// The files of a program as a zip archive, with `main` in the place of the main program. Equal files make equal
/// bytes. Blocks.
///
/// # Errors
/// A file cannot be read, or the archive cannot be written.
pub(super) fn archive_with(
    spool: &Spool,
    source: &InputFile,
    main: &Draft,
) -> Result<Draft, ProgramFilesFault> {
    let mut archive = ZipWriter::new_stream(spool.result()?);
    let options = || SimpleFileOptions::default().compression_method(CompressionMethod::Deflated);
    let broken = |fault: ZipError| io::Error::other(fault);
    let (main, length) = (main.file()?, main.length());
    let mut files = Vec::new();
    for (index, part) in source.files().iter().enumerate() {
        let text: Box<dyn Read + '_> = match index {
            0 => Box::new(Part { file: &main, at: 0, end: length }),
            _ => source.text_of(part),
        };
        files.push((part.name.as_str(), text));
    }
    files.sort_by_key(|(name, _)| *name);
    for (name, mut text) in files {
        // No time, so that equal files make equal bytes.
        archive.start_file(name, options().last_modified_time(DateTime::DEFAULT)).map_err(broken)?;
        io::copy(&mut text, &mut archive)?;
    }
    Ok(archive.finish().map_err(broken)?.into_inner())
}
