//! Files that the database or a bucket keeps. The directory then has copies, which are made when they are needed.

use std::io::Write;
use std::time::Duration;

use super::{BlobFault, Blobs};
use crate::store::sql::SharedFiles;
use crate::store::{Damage, DamagedFile};

impl Blobs {
    /// The same, kept there if files are kept for several services.
    #[must_use]
    pub(in crate::store) fn kept_in(self, shared: Option<SharedFiles>) -> Self {
        Self { shared, ..self }
    }

    /// Whether the directory only has copies of what the database or a bucket keeps.
    #[must_use]
    pub fn are_copies(&self) -> bool {
        self.shared.is_some()
    }

    /// Removes copies that were made so long ago, and counts them. A reader of a copy can read it to its end. Blocks.
    ///
    /// # Errors
    /// A directory cannot be read or a file not removed.
    pub fn remove_copies(&self, age: Duration) -> Result<usize, BlobFault> {
        if !self.are_copies() {
            return Ok(0);
        }
        self.remove_if(|path| {
            let made = path.symlink_metadata().and_then(|found| found.modified());
            made.is_ok_and(|made| made.elapsed().is_ok_and(|elapsed| elapsed > age))
        })
    }

    /// Makes a copy in the place of one that is missing or damaged.
    pub(super) fn copy(&self, damaged: DamagedFile) -> Result<(), BlobFault> {
        let sha256 = damaged.sha256.as_str();
        self.remove(sha256)?;
        let mut draft = self.draft()?;
        let path = draft.path().to_owned();
        let is_there = self.read_shared(sha256, |bytes| {
            draft.write_all(bytes).map_err(BlobFault::at("copying a file to", &path))
        })?;
        if !is_there {
            return Err(DamagedFile { damage: Damage::Missing, ..damaged }.into());
        }
        if draft.sha256() != sha256 {
            let damage = Damage::Other { length: draft.length(), sha256: draft.sha256() };
            return Err(DamagedFile { damage, ..damaged }.into());
        }
        self.keep_here(draft).map(drop)
    }

    /// Reads a file where it is kept; `false` if it is not.
    #[cfg_attr(
        not(feature = "scale-out"),
        expect(unused_variables, clippy::unnecessary_wraps, reason = "there are no such files")
    )]
    pub(super) fn read_shared(
        &self,
        sha256: &str,
        each: impl FnMut(&[u8]) -> Result<(), BlobFault>,
    ) -> Result<bool, BlobFault> {
        match &self.shared {
            None => Ok(false),
            #[cfg(feature = "scale-out")]
            Some(shared) => shared.read(sha256, each),
            #[cfg(not(feature = "scale-out"))]
            Some(never) => match *never {},
        }
    }
}
