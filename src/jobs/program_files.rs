//! A program of several files as one file: a list of the names, digests and lengths of its files, and their bytes one
//! after the other. The main program is the first. The same files make the same bytes, in whatever order they came.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read, Write};
use std::os::unix::fs::FileExt;

use std::sync::Arc;

use bytes::Bytes;
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::spool::{Spool, SpoolFault, Upload};
use crate::store::{BlobFault, Draft, Sha256Hex, hex};

/// The first line. No control reads it as a program.
const MARK: &str = "%TRUNNION PROGRAM FILES 1";
/// The same for files that came as an archive.
const MARK_OF_ARCHIVE: &str = "%TRUNNION PROGRAM FILES 1 ZIP";
/// Most files of one program: each is open until the program is kept.
const MOST_FILES: usize = 100;
/// Longest name of a file \[characters\].
const LONGEST_NAME: usize = 200;
/// More bytes than any list has.
const LIST_BYTES: usize = MOST_FILES * (LONGEST_NAME * 4 + 128) + 1024;

/// Why files do not make one program.
#[derive(Debug, Error)]
pub enum ProgramFilesFault {
    /// There are too many.
    #[error(
        "the program has {found} files; at most {MOST_FILES} belong to one program. Leave out files that it does not call"
    )]
    TooMany {
        /// Files, with the main program.
        found: usize,
    },
    /// A name has characters that are not text, or is too long.
    #[error(
        "the name of a file is missing, longer than {LONGEST_NAME} characters, leads out of its folder, or has control characters. Rename the file"
    )]
    Name,
    /// Two files have one name.
    #[error("two files have the name {name}, upper and lower case alike. Keep one of them")]
    Twice {
        /// The name.
        name: String,
    },
    /// The file could not be made.
    #[error(transparent)]
    File(#[from] BlobFault),
    /// A file could not be read or written.
    #[error("writing the files of a program: {0}")]
    Write(#[from] io::Error),
}

/// Whether a file that was sent looks like joined files. Only the service joins files.
///
/// # Errors
/// Its beginning cannot be read.
pub fn looks_joined(draft: &Draft) -> io::Result<bool> {
    let mut head = Vec::new();
    Part { file: &draft.file()?, at: 0, end: draft.length().min(MARK.len() as u64) }
        .read_to_end(&mut head)?;
    Ok(head == MARK.as_bytes())
}

/// A file of a program that was sent: bytes of a file on the disk.
#[derive(Debug)]
pub struct SentFile {
    /// Its name, which calls use.
    name: String,
    sha256: Sha256Hex,
    file: Arc<File>,
    start: u64,
    end: u64,
}

impl SentFile {
    /// A draft as a file of a program. It is removed from its folder, and its bytes stay.
    ///
    /// # Errors
    /// Too many files are open.
    pub fn of(name: String, draft: &Draft) -> io::Result<Self> {
        let (sha256, end) = (draft.sha256(), draft.length());
        Ok(Self { name, sha256, file: Arc::new(draft.file()?), start: 0, end })
    }
}

/// Files that arrive one after the other. They wait in one file on the disk, so that a sender opens no more.
#[derive(Debug)]
pub struct ArrivingFiles {
    upload: Upload,
    bytes: u64,
    hasher: Sha256,
    ended: Vec<(String, Sha256Hex, u64)>,
}

impl ArrivingFiles {
    /// No file so far; together at most `limit` bytes.
    ///
    /// # Errors
    /// The file on the disk cannot be made.
    pub fn begin(spool: &Spool, limit: u64) -> Result<Self, SpoolFault> {
        let upload = spool.begin_within(limit)?;
        Ok(Self { upload, bytes: 0, hasher: Sha256::new(), ended: Vec::new() })
    }

    /// The next bytes of the present file.
    ///
    /// # Errors
    /// The files are too long, or cannot be written.
    pub async fn take(&mut self, bytes: &Bytes) -> Result<(), SpoolFault> {
        self.hasher.update(bytes);
        self.bytes += bytes.len() as u64;
        self.upload.take(bytes).await
    }

    /// Bytes of the present file so far.
    #[must_use]
    pub fn length(&self) -> u64 {
        self.bytes - self.ended.last().map_or(0, |(.., end)| *end)
    }

    /// The present file is complete.
    ///
    /// # Errors
    /// There are too many files.
    pub fn end(&mut self, name: String) -> Result<(), ProgramFilesFault> {
        let sha256 = hex(&std::mem::take(&mut self.hasher).finalize());
        self.ended.push((name, sha256, self.bytes));
        match self.ended.len() + 1 {
            found if found > MOST_FILES => Err(ProgramFilesFault::TooMany { found }),
            _ => Ok(()),
        }
    }

    /// All files.
    ///
    /// # Errors
    /// They cannot be written.
    pub async fn finish(self) -> Result<Vec<SentFile>, SpoolFault> {
        let Self { upload, ended, .. } = self;
        let draft = upload.finish().await?;
        let file = Arc::new(draft.file().map_err(SpoolFault::Write)?);
        let mut start = 0;
        let files = ended.into_iter().map(|(name, sha256, end)| {
            let file = Arc::clone(&file);
            SentFile { name, sha256, file, start: std::mem::replace(&mut start, end), end }
        });
        Ok(files.collect())
    }
}

/// The files of a program as one file. `is_archive` says that they came as an archive. Blocks.
///
/// # Errors
/// There are too many, a name is wrong or is there twice, or the file cannot be written.
pub fn joined(
    spool: &Spool,
    main: SentFile,
    mut others: Vec<SentFile>,
    is_archive: bool,
) -> Result<Draft, ProgramFilesFault> {
    let found = 1 + others.len();
    if found > MOST_FILES {
        return Err(ProgramFilesFault::TooMany { found });
    }
    others.sort_by(|one, other| one.name.cmp(&other.name));
    let files: Vec<SentFile> = std::iter::once(main).chain(others).collect();
    let mut names = BTreeSet::new();
    let mut list = format!("{}\n", if is_archive { MARK_OF_ARCHIVE } else { MARK });
    for SentFile { name, sha256, start, end, .. } in &files {
        let leads_out = name.starts_with(['/', '\\']) || name.split(['/', '\\']).any(|part| part == "..");
        let length = name.chars().count();
        if name.is_empty() || length > LONGEST_NAME || name.contains(char::is_control) || leads_out {
            return Err(ProgramFilesFault::Name);
        }
        if !names.insert(name.to_uppercase()) {
            return Err(ProgramFilesFault::Twice { name: name.clone() });
        }
        let length = end - start;
        list.extend([sha256.as_str(), " ", &length.to_string(), " ", name, "\n"]);
    }
    list.push('\n');
    let mut out = spool.result()?;
    out.write_all(list.as_bytes())?;
    for SentFile { file, start, end, .. } in &files {
        out = out.with_all_of(&mut Part { file, at: *start, end: *end })?;
    }
    Ok(out)
}

/// A file of a program that is stored.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct StoredProgramFile {
    /// Its name.
    pub name: String,
    /// Its digest.
    pub sha256: Sha256Hex,
    /// Its first byte.
    pub start: u64,
    /// One after its last byte.
    pub end: u64,
}

/// The files of a stored program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct StoredProgramFiles {
    /// The main program first.
    pub files: Vec<StoredProgramFile>,
    /// They came as an archive.
    pub is_archive: bool,
}

impl StoredProgramFiles {
    /// The files in this file; `None` if it is a program itself.
    ///
    /// # Errors
    /// Its beginning cannot be read.
    pub(super) fn of(file: &File, length: u64) -> io::Result<Option<Self>> {
        let mut head = Vec::new();
        Part { file, at: 0, end: length.min(MARK_OF_ARCHIVE.len() as u64 + 1) }.read_to_end(&mut head)?;
        if !head.starts_with(MARK.as_bytes()) {
            return Ok(None);
        }
        head.clear();
        Part { file, at: 0, end: length.min(LIST_BYTES as u64) }.read_to_end(&mut head)?;
        Ok(Self::listed(&head, length))
    }

    /// The files that a list names; `None` if the bytes are no list, or if the files have another length together.
    fn listed(head: &[u8], length: u64) -> Option<Self> {
        let end = head.windows(2).position(|two| two == b"\n\n")?;
        let mut lines = std::str::from_utf8(head.get(..end)?).ok()?.split('\n');
        let is_archive = match lines.next()? {
            MARK => false,
            MARK_OF_ARCHIVE => true,
            _ => return None,
        };
        let mut start = end as u64 + 2;
        let mut files = Vec::new();
        for line in lines {
            let (sha256, rest) = line.split_once(' ')?;
            let (length, name) = rest.split_once(' ')?;
            let end = start.checked_add(length.parse().ok()?)?;
            files.push(StoredProgramFile { name: name.to_owned(), sha256: sha256.to_owned(), start, end });
            start = end;
        }
        (!files.is_empty() && files.len() <= MOST_FILES && start == length)
            .then_some(Self { files, is_archive })
    }
}

/// Bytes of a file, read from an own position.
pub(super) struct Part<'a> {
    pub(super) file: &'a File,
    pub(super) at: u64,
    pub(super) end: u64,
}

impl Read for Part<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let left = usize::try_from(self.end.saturating_sub(self.at)).unwrap_or(usize::MAX);
        let room = buffer.len().min(left);
        let read = self.file.read_at(buffer.get_mut(..room).unwrap_or_default(), self.at)?;
        self.at += read as u64;
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::Blobs;

    fn named(spool: &Spool, name: &str, text: &str) -> SentFile {
        let mut draft = spool.result().unwrap();
        draft.write_all(text.as_bytes()).unwrap();
        SentFile::of(name.to_owned(), &draft).unwrap()
    }

    #[test]
    fn files_become_one_file_and_files_again_in_whatever_order_they_came() {
        let folder = tempfile::tempdir().unwrap();
        let spool = Spool::new(Blobs::open(folder.path()).unwrap(), u64::MAX);
        let one = |name| named(&spool, name, "M98 P2\n\n");
        let two = || [named(&spool, "b.nc", "X1\n"), named(&spool, "Ä b.nc", "")];
        let first = joined(&spool, one("main.nc"), two().into(), true).unwrap();
        let second = joined(&spool, one("main.nc"), two().into_iter().rev().collect(), true).unwrap();
        assert_eq!(first.sha256(), second.sha256());
        assert_ne!(first.sha256(), joined(&spool, one("m.nc"), two().into(), true).unwrap().sha256());
        let found = StoredProgramFiles::of(&first.file().unwrap(), first.length()).unwrap().unwrap();
        assert!(found.is_archive);
        let file = first.file().unwrap();
        let texts = found.files.iter().map(|entry| {
            let mut text = String::new();
            Part { file: &file, at: entry.start, end: entry.end }.read_to_string(&mut text).unwrap();
            (entry.name.clone(), text)
        });
        let expected = [("main.nc", "M98 P2\n\n"), ("b.nc", "X1\n"), ("Ä b.nc", "")];
        assert_eq!(
            texts.collect::<Vec<_>>(),
            expected.map(|(name, text)| (name.to_owned(), text.to_owned()))
        );
        for (name, other) in
            [("a", "A"), ("", "b"), ("a\nb", "c"), ("../a", "b"), ("/a", "b"), ("a\\..\\b", "c")]
        {
            let files = vec![named(&spool, other, "")];
            assert!(joined(&spool, named(&spool, name, ""), files, false).is_err(), "{name:?}");
        }
        let many = (0..100).map(|index| named(&spool, &format!("{index}.nc"), "")).collect();
        assert!(matches!(
            joined(&spool, one("main.nc"), many, false),
            Err(ProgramFilesFault::TooMany { .. })
        ));
    }

    #[test]
    fn what_only_looks_like_files_is_a_program() {
        let good = format!("{MARK}\nab 3 x\n\nabc");
        assert!(StoredProgramFiles::listed(good.as_bytes(), good.len() as u64).is_some());
        for text in [
            format!("{MARK}\nab 3 x\n\nab"),
            format!("{MARK}\nab 3 x\n\nabcd"),
            format!("{MARK}\nab 18446744073709551615 x\n\nabc"),
            format!("{MARK}\nab x\n\n"),
            format!("{MARK}\n\n"),
            format!("{MARK}\nab 3 x\nabc"),
            format!("{MARK} 2\nab 3 x\n\nabc"),
        ] {
            assert_eq!(StoredProgramFiles::listed(text.as_bytes(), text.len() as u64), None, "{text}");
        }
    }
}
