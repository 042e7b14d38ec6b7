//! The programs in a zip archive. Its list of files is read file by file, and what it unpacks to is counted while it is
//! written.

use std::collections::BTreeSet;
use std::io::{self, BufReader, Read, Write};
use std::ops::ControlFlow;

use thiserror::Error;
use zip::CompressionMethod;
use zip::result::ZipError;
use zip::unstable::read::ZipIterable;

use super::Spool;
use super::spool::no_share;
use crate::process::Stop;
use crate::shares::NoShare;
use crate::store::{BlobFault, Draft, DraftTooLong};

/// Most programs in one archive: each has a file open until all of them are accepted.
const MOST_PROGRAMS: usize = 100;
/// Most files and folders in one archive, with those that are left out.
const MOST_ENTRIES: usize = 1000;
/// Longest path of a file in an archive \[characters\].
const LONGEST_PATH: usize = 500;
/// Bytes unpacked at a time.
const PIECE_BYTES: usize = 64 * 1024;

/// Why the programs of an archive cannot be taken.
#[derive(Debug, Error)]
pub enum ArchiveFault {
    /// It is no archive, or it is damaged.
    #[error("the zip archive cannot be read: {0}. Make the archive again")]
    Unreadable(ZipError),
    /// It has too many files and folders.
    #[error("the archive has {found} files and folders; at most {MOST_ENTRIES} are read. Divide the archive")]
    TooManyEntries {
        /// Files and folders.
        found: usize,
    },
    /// It has too many programs.
    #[error("the archive has more than {MOST_PROGRAMS} programs, which is the limit. Divide the archive")]
    TooManyPrograms,
    /// It has no program.
    #[error("the archive has no program; put the programs into it as files")]
    Empty,
    /// A path has characters that are not text, or is too long.
    #[error(
        "the path of entry {number} of the archive is empty, longer than {LONGEST_PATH} characters, not text, or has control \
         characters. Rename the file"
    )]
    Path {
        /// Position of the entry in the archive, from 1; folders count.
        number: usize,
    },
    /// Two files have one path.
    #[error("two files of the archive have the path {path}. Keep one of them")]
    Twice {
        /// The path.
        path: String,
    },
    /// A file is coded in a way that is not read.
    #[error(
        "{path} is {how}. Make the archive with the methods store or deflate, without a password and without links"
    )]
    Coded {
        /// The path.
        path: String,
        /// The fault of the coding.
        how: &'static str,
    },
    /// A file cannot be unpacked, or differs from its checksum.
    #[error("{path} cannot be unpacked: {fault}. Make the archive again")]
    Damaged {
        /// The path.
        path: String,
        /// The reason.
        fault: io::Error,
    },
    /// The programs are longer than they may be.
    #[error(
        "the programs of the archive are together larger than the limit of {limit} bytes (max_body_bytes). Divide the archive"
    )]
    TooLarge {
        /// The limit \[bytes\].
        limit: u64,
    },
    /// The caller holds its full share of the spool, or the spool is full.
    #[error(transparent)]
    NoShare(#[from] NoShare),
    /// A file could not be made.
    #[error(transparent)]
    File(#[from] BlobFault),
    /// A file could not be written.
    #[error("writing a program of an archive: {0}")]
    Write(io::Error),
    /// The client has left.
    #[error("the work was cancelled")]
    Cancelled,
}

/// The programs of an archive.
#[derive(Debug)]
pub struct Unpacked {
    /// Each program with its path, in the order of the archive.
    pub programs: Vec<(String, Draft)>,
    /// Paths of the files that the system of the sender added: hidden files, and those below `__MACOSX`.
    pub left_out: Vec<String>,
}

/// Unpacks the programs of an archive, together at most `limit` bytes. Blocks.
///
/// # Errors
/// It cannot be read, has no program or too much, or its programs cannot be written.
pub fn unpack(archive: &Draft, spool: &Spool, limit: u64, stop: &Stop<'_>) -> Result<Unpacked, ArchiveFault> {
    let file = archive.file().map_err(ArchiveFault::Write)?;
    let mut bodies = file.try_clone().map_err(ArchiveFault::Write)?;
    let archive = ZipIterable::try_new(BufReader::new(file), zip::read::Config::default());
    let mut archive = archive.map_err(ArchiveFault::Unreadable)?.enforce_header_consistency(true);
    if archive.len() > MOST_ENTRIES {
        return Err(ArchiveFault::TooManyEntries { found: archive.len() });
    }
    let (mut paths, mut left) = (BTreeSet::new(), limit);
    let mut unpacked = Unpacked { programs: Vec::new(), left_out: Vec::new() };
    for (index, entry) in archive.files().map_err(ArchiveFault::Unreadable)?.enumerate() {
        let entry = entry.map_err(ArchiveFault::Unreadable)?;
        if entry.is_dir() && entry.size() == 0 {
            continue;
        }
        let path = entry.name().ok().filter(|path| is_legible(path)).map(std::borrow::Cow::into_owned);
        let path = path.ok_or(ArchiveFault::Path { number: index + 1 })?;
        if !paths.insert(path.clone()) {
            return Err(ArchiveFault::Twice { path });
        }
        if is_of_the_system(&path) {
            unpacked.left_out.push(path);
            continue;
        }
        if unpacked.programs.len() == MOST_PROGRAMS {
            return Err(ArchiveFault::TooManyPrograms);
        }
        let how = match entry.compression() {
            _ if entry.encrypted() => Some("encrypted"),
            _ if entry.is_symlink() => Some("a link"),
            _ if entry.is_dir() => Some("a folder with content"),
            CompressionMethod::Stored | CompressionMethod::Deflated => None,
            _ => Some("compressed by a method that is not read"),
        };
        if let Some(how) = how {
            return Err(ArchiveFault::Coded { path, how });
        }
        let body = entry.with_reader(&mut bodies, zip::ZipReadOptions::new());
        let mut body = body.map_err(ArchiveFault::Unreadable)?;
        let mut draft = spool.result()?.within(left);
        copy(&mut body, &mut draft, stop).map_err(|fault| match fault {
            Copying::Read(fault) => ArchiveFault::Damaged { path: path.clone(), fault },
            Copying::Written(fault) => written(fault, limit),
            Copying::Stopped => ArchiveFault::Cancelled,
        })?;
        left -= draft.length();
        unpacked.programs.push((path, draft));
    }
    if unpacked.programs.is_empty() {
        return Err(ArchiveFault::Empty);
    }
    Ok(unpacked)
}

/// Whether a path can be shown.
fn is_legible(path: &str) -> bool {
    !path.is_empty() && path.chars().count() <= LONGEST_PATH && !path.contains(char::is_control)
}

/// Whether a file was added by the system on which the archive was made.
fn is_of_the_system(path: &str) -> bool {
    let is_hidden = |name: &str| name.starts_with('.') && !matches!(name, "." | "..");
    path.split(['/', '\\']).any(|name| is_hidden(name) || name == "__MACOSX")
}

enum Copying {
    Read(io::Error),
    Written(io::Error),
    Stopped,
}

fn copy(from: &mut impl Read, to: &mut Draft, stop: &Stop<'_>) -> Result<(), Copying> {
    let mut piece = vec![0; PIECE_BYTES];
    loop {
        if let ControlFlow::Break(()) = stop() {
            return Err(Copying::Stopped);
        }
        let read = match from.read(&mut piece) {
            Ok(0) => return Ok(()),
            Ok(read) => read,
            Err(fault) if fault.kind() == io::ErrorKind::Interrupted => continue,
            Err(fault) => return Err(Copying::Read(fault)),
        };
        to.write_all(piece.get(..read).unwrap_or_default()).map_err(Copying::Written)?;
    }
}

/// A fault of writing a program.
fn written(fault: io::Error, limit: u64) -> ArchiveFault {
    if let Some(share) = no_share(&fault) {
        return ArchiveFault::NoShare(share);
    }
    match fault.get_ref().and_then(|inner| inner.downcast_ref()) {
        Some(DraftTooLong { .. }) => ArchiveFault::TooLarge { limit },
        None => ArchiveFault::Write(fault),
    }
}
