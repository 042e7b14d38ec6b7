//! A program of several files as one file: a list of the names, digests and lengths of its files, and their bytes one
//! after the other. The main program is the first. The same files make the same bytes, in whatever order they came.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read, Write};
use std::os::unix::fs::FileExt;

use thiserror::Error;

use super::Spool;
use crate::store::{BlobFault, Draft, Sha256Hex};

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
        "the name of a file is missing, longer than {LONGEST_NAME} characters, or has control characters. Rename the file"
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

/// A file of a program that is being sent.
#[derive(Debug)]
pub struct NamedFile {
    /// Its name, which calls use.
    pub name: String,
    /// Its bytes.
    pub draft: Draft,
}

/// The files of a program as one file. `is_archive` says that they came as an archive. Blocks.
///
/// # Errors
/// There are too many, a name is wrong or is there twice, or the file cannot be written.
pub fn joined(
    spool: &Spool,
    main: NamedFile,
    mut others: Vec<NamedFile>,
    is_archive: bool,
) -> Result<Draft, ProgramFilesFault> {
    let found = 1 + others.len();
    if found > MOST_FILES {
        return Err(ProgramFilesFault::TooMany { found });
    }
    others.sort_by(|one, other| one.name.cmp(&other.name));
    let files: Vec<NamedFile> = std::iter::once(main).chain(others).collect();
    let mut names = BTreeSet::new();
    let mut list = format!("{}\n", if is_archive { MARK_OF_ARCHIVE } else { MARK });
    for NamedFile { name, draft } in &files {
        if name.is_empty() || name.chars().count() > LONGEST_NAME || name.contains(char::is_control) {
            return Err(ProgramFilesFault::Name);
        }
        if !names.insert(name.to_uppercase()) {
            return Err(ProgramFilesFault::Twice { name: name.clone() });
        }
        list.push_str(&format!("{} {} {name}\n", draft.sha256(), draft.length()));
    }
    list.push('\n');
    let mut out = spool.result()?;
    out.write_all(list.as_bytes())?;
    for NamedFile { draft, .. } in &files {
        let file = draft.file()?;
        out = out.with_all_of(&mut Part { file: &file, at: 0, end: draft.length() })?;
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

    /// The files of a list; `None` if it is none, or does not fit a file of this length.
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
struct Part<'a> {
    file: &'a File,
    at: u64,
    end: u64,
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

    fn named(spool: &Spool, name: &str, text: &str) -> NamedFile {
        let mut draft = spool.result().unwrap();
        draft.write_all(text.as_bytes()).unwrap();
        NamedFile { name: name.to_owned(), draft }
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
        let texts: Vec<_> = found.files.iter().map(|entry| {
            let mut text = String::new();
            Part { file: &file, at: entry.start, end: entry.end }.read_to_string(&mut text).unwrap();
            (entry.name.clone(), text)
        });
        let expected = [("main.nc", "M98 P2\n\n"), ("b.nc", "X1\n"), ("Ä b.nc", "")];
        assert_eq!(
            texts.collect::<Vec<_>>(),
            expected.map(|(name, text)| (name.to_owned(), text.to_owned()))
        );
        for (name, other) in [("a", "A"), ("", "b"), ("a\nb", "c")] {
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
