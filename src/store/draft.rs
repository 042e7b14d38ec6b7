//! Files under way: programs and results that are being written.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

use sha2::{Digest, Sha256};
use tempfile::NamedTempFile;
use thiserror::Error;

use super::blobs::{Sha256Hex, hex};
use super::digest_beside::{DigestBeside, PIECE_BYTES};
use crate::shares::Held;

/// A file that is being written; it is removed unless it is kept.
#[derive(Debug)]
pub struct Draft {
    pub(super) file: NamedTempFile,
    hasher: Sha256,
    length: u64,
    limit: u64,
    /// Its share of the spool, if the spool is shared.
    room: Option<Held>,
}

/// More bytes than a draft may have; the fault of writing then has the kind [`io::ErrorKind::FileTooLarge`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[error("the result would be longer than the limit of {limit} bytes")]
pub struct DraftTooLong {
    /// The limit \[bytes\].
    pub limit: u64,
}

/// Bytes moved at a time when a draft gets another beginning \[bytes\]. The new beginning may be longer than the old
/// one by this much.
const MOVED_BYTES: u64 = 1 << 18;

impl Draft {
    /// An empty draft in this file.
    pub(super) fn new(file: NamedTempFile) -> Self {
        Self { file, hasher: Sha256::new(), length: 0, limit: u64::MAX, room: None }
    }

    /// The same with a limit on its length \[bytes\]; one byte more is a fault of writing.
    #[must_use]
    pub fn within(self, limit: u64) -> Self {
        Self { limit, ..self }
    }

    /// The same with its bytes counted while they arrive, until it is kept or dropped.
    #[must_use]
    pub fn counted(self, room: Held) -> Self {
        Self { room: Some(room), ..self }
    }

    /// Path of the bytes written so far.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Bytes written so far.
    #[must_use]
    pub fn length(&self) -> u64 {
        self.length
    }

    /// The file itself, whatever happens to its name.
    ///
    /// # Errors
    /// Too many files are open.
    pub fn file(&self) -> io::Result<File> {
        self.file.as_file().try_clone()
    }

    /// The same with everything from `source` after it. The digest is computed beside the copy.
    ///
    /// # Errors
    /// `source` cannot be read, the draft cannot be written, it would be longer than its limit, or there is no second
    /// thread.
    pub fn with_all_of(mut self, source: &mut impl Read) -> io::Result<Self> {
        let mut next = |piece: &mut Vec<u8>| {
            Read::by_ref(source).take(PIECE_BYTES as u64).read_to_end(piece).map(|count| count > 0)
        };
        let mut piece = Vec::with_capacity(PIECE_BYTES);
        next(&mut piece)?;
        if piece.len() < PIECE_BYTES {
            // A short text needs no second thread.
            self.write_all(&piece)?;
            return Ok(self);
        }
        let digest = DigestBeside::begin(std::mem::take(&mut self.hasher))?;
        loop {
            Undigested(&mut self).write_all(&piece)?;
            piece = digest.take(piece)?;
            if !next(&mut piece)? {
                break;
            }
        }
        self.hasher = digest.end()?;
        Ok(self)
    }

    /// The same with another beginning: `head` replaces the first `from` bytes. The bytes after them move within the file,
    /// so that no second copy needs room.
    ///
    /// # Errors
    /// The file cannot be read or written, it would be longer than its limit, or there is no room for the difference.
    pub fn with_head(mut self, head: &[u8], from: u64) -> io::Result<Self> {
        let (mut room, length) = (self.room.take(), self.length);
        if (head.len() as u64).saturating_sub(from) > MOVED_BYTES {
            return Err(io::ErrorKind::InvalidInput.into());
        }
        let mut rest = File::open(self.path())?;
        rest.seek(SeekFrom::Start(from))?;
        // Not the bytes that a longer beginning pushes over the old end.
        let mut rest = rest.take(length.saturating_sub(from));
        self.file.as_file_mut().rewind()?;
        (self.hasher, self.length) = (Sha256::new(), 0);
        // A piece is read before the one before it is written, which may reach into it.
        let mut piece = head.to_vec();
        loop {
            let mut next = Vec::new();
            Read::by_ref(&mut rest).take(MOVED_BYTES).read_to_end(&mut next)?;
            self.write_all(&piece)?;
            if next.is_empty() {
                break;
            }
            piece = next;
        }
        self.file.as_file().set_len(self.length)?;
        if let Some(room) = &mut room {
            room.take_more(self.length.saturating_sub(length)).map_err(io::Error::other)?;
            room.keep_only(self.length);
        }
        self.room = room;
        Ok(self)
    }

    /// SHA-256 of the bytes written so far.
    #[must_use]
    pub fn sha256(&self) -> Sha256Hex {
        hex(&self.hasher.clone().finalize())
    }
}

/// Writes to a draft whose digest is computed elsewhere.
struct Undigested<'a>(&'a mut Draft);

impl Write for Undigested<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.append(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl Draft {
    /// Appends bytes that are not in the digest yet.
    fn append(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.length.saturating_add(bytes.len() as u64) > self.limit {
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, DraftTooLong { limit: self.limit }));
        }
        if let Some(room) = &mut self.room {
            room.take_more(bytes.len() as u64).map_err(io::Error::other)?;
        }
        let written = self.file.write(bytes)?;
        self.length += written as u64;
        Ok(written)
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.append(bytes)?;
        self.hasher.update(bytes.get(..written).unwrap_or(bytes));
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::{Blobs, sha256_hex};

    #[test]
    fn a_copy_has_the_bytes_and_the_digest_of_its_source_and_keeps_its_limit() {
        let folder = tempfile::tempdir().unwrap();
        let blobs = Blobs::open(folder.path()).unwrap();
        let text: Vec<u8> = (0..=250).cycle().take(5 * PIECE_BYTES + 17).collect();
        for length in [0, 1, PIECE_BYTES - 1, PIECE_BYTES, PIECE_BYTES + 1, 4 * PIECE_BYTES, text.len()] {
            let source = &text[..length];
            let mut begun = blobs.draft().unwrap().within(length as u64 + 2);
            begun.write_all(b"ab").unwrap();
            let draft = begun.with_all_of(&mut &*source).unwrap();
            let expected = [b"ab", source].concat();
            assert!(std::fs::read(draft.path()).unwrap() == expected, "{length}");
            assert_eq!((draft.length(), draft.sha256()), (expected.len() as u64, sha256_hex(&expected)));
            if length > 0 {
                let short = blobs.draft().unwrap().within(length as u64 - 1);
                assert_eq!(short.with_all_of(&mut &*source).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
            }
        }
        let mut broken = text.as_slice().chain(Broken);
        assert_eq!(
            blobs.draft().unwrap().with_all_of(&mut broken).unwrap_err().kind(),
            io::ErrorKind::ConnectionReset
        );
    }

    struct Broken;

    impl Read for Broken {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::ErrorKind::ConnectionReset.into())
        }
    }

    #[test]
    fn a_new_beginning_leaves_the_rest_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let blobs = Blobs::open(folder.path()).unwrap();
        let text: Vec<u8> = (0..=250).cycle().take(3 * (1 << 18) + 17).collect();
        let long = vec![b'x'; 70_000];
        for length in [0, 5, 1000, text.len()] {
            for from in [0, 3, 900, length] {
                for head in [&b""[..], b"ab", &long] {
                    let from = from.min(length);
                    let mut draft = blobs.draft().unwrap();
                    draft.write_all(&text[..length]).unwrap();
                    let draft = draft.with_head(head, from as u64).unwrap();
                    let expected = [head, &text[from..length]].concat();
                    assert!(
                        std::fs::read(draft.path()).unwrap() == expected,
                        "{length} {from} {}",
                        head.len()
                    );
                    assert_eq!(
                        (draft.length(), draft.sha256()),
                        (expected.len() as u64, sha256_hex(&expected))
                    );
                }
            }
        }
    }
}
