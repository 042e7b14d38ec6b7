//! An uploaded file as the work reads it: the number of bytes read shows the progress of the work.

use std::fs::File;
use std::io::{self, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::program_files::{Part, StoredProgramFile, StoredProgramFiles};
use crate::process::{OpenSubprogram, ProgramSource};
use crate::program::{Dialect, Steps};
use crate::store::{
    BlobFault, Blobs, Damage, DamagedFile, Draft, FileState, Sha256Hex, SoundFile, StoredThing,
};

/// A complete and open uploaded file: whatever happens to its name, the bytes come from the file that was opened.
#[derive(Debug, Clone)]
pub struct InputFile {
    file: Arc<File>,
    /// Its state when its bytes were verified against its digest.
    state: FileState,
    /// Length of the file \[bytes\].
    pub length: u64,
    /// Digest of the file.
    pub sha256: Sha256Hex,
    /// Steps of earlier jobs that wrote this file as their output.
    pub steps_done: Steps,
    /// Its files, if it is a program of several files.
    parts: Option<Arc<StoredProgramFiles>>,
    /// Number of bytes read so far, over all passes.
    read: Arc<AtomicU64>,
}

impl InputFile {
    /// A stored file that was read to its end and verified. Blocks.
    ///
    /// # Errors
    /// It is missing, has other bytes, or cannot be read.
    pub fn kept(blobs: &Blobs, sha256: &str) -> Result<Self, BlobFault> {
        let SoundFile { file, state, length } = blobs.read_sound(sha256)?;
        let parts = StoredProgramFiles::of(&file, length).map_err(|source| BlobFault::File {
            doing: "reading the list of files of",
            path: sha256.into(),
            source,
        })?;
        let parts = parts.map(Arc::new);
        Ok(Self {
            file: Arc::new(file),
            state,
            length,
            sha256: sha256.to_owned(),
            steps_done: Steps::NONE,
            parts,
            read: Arc::default(),
        })
    }

    /// A file that was just written.
    ///
    /// # Errors
    /// Too many files are open, or the system does not report its state.
    pub fn of(draft: &Draft) -> io::Result<Self> {
        let file = draft.file()?;
        let state = FileState::of(&file)?;
        let (length, sha256) = (draft.length(), draft.sha256());
        let parts = StoredProgramFiles::of(&file, length)?.map(Arc::new);
        Ok(Self {
            file: Arc::new(file),
            state,
            length,
            sha256,
            steps_done: Steps::NONE,
            parts,
            read: Arc::default(),
        })
    }

    /// The same file, known as the output of earlier jobs with these steps.
    pub(super) fn with_steps_done(self, steps_done: Steps) -> Self {
        Self { steps_done, ..self }
    }

    /// The name of one of its files, counted from 1; the main program has none.
    pub(super) fn name_of(&self, file: u16) -> Option<&str> {
        self.part(usize::from(file)).map(|part| part.name.as_str())
    }

    /// The dialect that the names of its files show, for example by `.SPF`. The text of a main program alone may show
    /// another one.
    pub(super) fn dialect_of_files(&self) -> Option<Dialect> {
        self.files().iter().find_map(|part| Dialect::of_file(&part.name))
    }

    /// Whether its files came as an archive.
    pub(super) fn is_archive(&self) -> bool {
        self.parts.as_ref().is_some_and(|parts| parts.is_archive)
    }

    /// Its files, if it is a program of several files.
    pub(super) fn files(&self) -> &[StoredProgramFile] {
        self.parts.as_ref().map_or(&[], |parts| &parts.files)
    }

    /// The text of one of these files.
    pub(super) fn text_of(&self, part: &StoredProgramFile) -> Box<dyn Read + Send + '_> {
        self.read_part(Some(part))
    }

    fn part(&self, index: usize) -> Option<&StoredProgramFile> {
        self.files().get(index)
    }

    fn read_part(&self, part: Option<&StoredProgramFile>) -> Box<dyn Read + Send + '_> {
        let (at, end) = part.map_or((0, u64::MAX), |part| (part.start, part.end));
        Box::new(Counted { part: Part { file: &self.file, at, end }, read: &self.read })
    }

    /// The same program with its loops and calls written out in this draft: one file, known by the digest of the upload.
    pub(super) fn written_out(&self, draft: &Draft) -> io::Result<Self> {
        let parts = self.parts.as_ref().and_then(|parts| {
            let main = StoredProgramFile { start: 0, end: draft.length(), ..parts.files.first()?.clone() };
            Some(Arc::new(StoredProgramFiles { files: vec![main], is_archive: parts.is_archive }))
        });
        let (sha256, steps_done, read) = (self.sha256.clone(), self.steps_done, Arc::clone(&self.read));
        Ok(Self { sha256, steps_done, parts, read, ..Self::of(draft)? })
    }

    /// The counter of bytes read so far, over all passes.
    pub(super) fn counted(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.read)
    }

    /// Whether the file is still in the state in which it was verified: then everything that was read from it is what
    /// was stored.
    ///
    /// # Errors
    /// The file was written to.
    pub(super) fn is_unchanged(&self) -> Result<(), DamagedFile> {
        match FileState::of(&self.file) {
            Ok(now) if now == self.state => Ok(()),
            _ => Err(DamagedFile {
                what: StoredThing::File,
                sha256: self.sha256.clone(),
                damage: Damage::WrittenTo,
            }),
        }
    }
}

impl ProgramSource for InputFile {
    fn open(&self) -> io::Result<Box<dyn Read + Send + '_>> {
        Ok(self.read_part(self.part(0)))
    }

    fn open_subprogram(&self, index: usize) -> io::Result<Option<OpenSubprogram<'_>>> {
        let part = self.part(index + 1);
        Ok(part.map(|part| OpenSubprogram { name: part.name.clone(), text: self.read_part(Some(part)) }))
    }
}

/// Reads a part of a file that others read too, and counts the bytes.
struct Counted<'a> {
    part: Part<'a>,
    read: &'a AtomicU64,
}

impl Read for Counted<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.part.read(buffer)?;
        // Nothing else is ordered by this number.
        self.read.fetch_add(read as u64, Ordering::Relaxed);
        Ok(read)
    }
}
