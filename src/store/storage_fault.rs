//! Faults of the disk, not of the request: they pass, or somebody must fix them, and then the same request may be
//! sent again.

use std::io;

use rustix::io::Errno;
use thiserror::Error;

/// Why nothing can be stored at present.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum StorageFault {
    /// No space is left.
    #[error("the disk is full")]
    Full,
    /// The file system accepts no writes: it was mounted so, or the system changed it after a fault.
    #[error("the disk is read-only")]
    ReadOnly,
    /// The disk answers with errors.
    #[error("the disk fails")]
    Failing,
    /// The process or the system has reached its limit of open files.
    #[error("too many files are open")]
    TooManyFiles,
    /// The server of the database does not answer.
    #[error(
        "the database server does not answer. Start it, or check the network and its address; the service goes on by \
         itself when it answers"
    )]
    Away,
    /// The server of the bucket does not answer, or refuses.
    #[error(
        "the server of the files (S3) does not answer, or refuses. Start it, or check the network, its address and the keys \
         to the bucket; the service goes on by itself when it answers"
    )]
    NoBucket,
}

impl StorageFault {
    /// The fault of the disk in an I/O error; `None` for an error of another kind.
    #[must_use]
    pub fn of(error: &io::Error) -> Option<Self> {
        match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => return Some(Self::Full),
            io::ErrorKind::ReadOnlyFilesystem => return Some(Self::ReadOnly),
            _ => {}
        }
        match Errno::from_io_error(error) {
            Some(Errno::MFILE | Errno::NFILE) => Some(Self::TooManyFiles),
            Some(Errno::IO) => Some(Self::Failing),
            // Temporary files report only the kind; this file has no name and belongs to the system.
            None if error.kind() == io::Error::from(Errno::IO).kind() => Some(Self::Failing),
            _ => None,
        }
    }

    /// The fault of the disk in a result code of `SQLite`, <https://www.sqlite.org/rescode.html>: 8 is
    /// `SQLITE_READONLY`, 10 `SQLITE_IOERR`, 13 `SQLITE_FULL`, 14 `SQLITE_CANTOPEN`; the bits above the lowest byte
    /// give details.
    pub(super) fn of_sqlite(code: u32) -> Option<Self> {
        match code & 0xff {
            8 => Some(Self::ReadOnly),
            10 | 14 => Some(Self::Failing),
            13 => Some(Self::Full),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_of_the_disk_are_told_from_all_others() {
        for (errno, expected) in [
            (Errno::NOSPC, Some(StorageFault::Full)),
            (Errno::DQUOT, Some(StorageFault::Full)),
            (Errno::ROFS, Some(StorageFault::ReadOnly)),
            (Errno::IO, Some(StorageFault::Failing)),
            (Errno::MFILE, Some(StorageFault::TooManyFiles)),
            (Errno::NFILE, Some(StorageFault::TooManyFiles)),
            (Errno::NOENT, None),
            (Errno::ACCESS, None),
            (Errno::FBIG, None),
        ] {
            assert_eq!(StorageFault::of(&errno.into()), expected, "{errno}");
        }
        assert_eq!(StorageFault::of(&io::Error::other("ours")), None);
        // In the form of temporary files: wrapped, with the file's name.
        let wrapped = |errno: Errno| io::Error::new(io::Error::from(errno).kind(), "in /spool/.tmp");
        assert_eq!(StorageFault::of(&wrapped(Errno::IO)), Some(StorageFault::Failing));
        assert_eq!(StorageFault::of(&wrapped(Errno::ROFS)), Some(StorageFault::ReadOnly));
        assert_eq!(StorageFault::of(&wrapped(Errno::NOENT)), None);
        // SQLITE_READONLY_DBMOVED, SQLITE_IOERR_FSYNC, SQLITE_FULL, SQLITE_CONSTRAINT_UNIQUE
        let codes = [1032, 1034, 13, 2067].map(StorageFault::of_sqlite);
        assert_eq!(
            codes,
            [Some(StorageFault::ReadOnly), Some(StorageFault::Failing), Some(StorageFault::Full), None]
        );
    }
}
