//! Uploads on their way to the disk: counted, hashed, limited.

use std::io::Write;

use bytes::Bytes;
use thiserror::Error;

use super::asker;
use crate::shares::{Held, NoShare, Shares, Who};
use crate::store::{BlobFault, Blobs, Draft};

/// Why an upload could not be taken.
#[derive(Debug, Error)]
pub enum SpoolFault {
    /// More bytes than the limit.
    #[error("the body is larger than the limit of {limit} bytes")]
    TooLarge {
        /// The limit \[bytes\].
        limit: u64,
    },
    /// The caller holds its full share of the spool, or the spool is full.
    #[error(transparent)]
    NoShare(#[from] NoShare),
    /// The file could not be written.
    #[error(transparent)]
    File(#[from] BlobFault),
    /// The bytes could not be written.
    #[error("writing an upload: {0}")]
    Write(std::io::Error),
}

/// The place of uploads.
#[derive(Debug, Clone)]
pub struct Spool {
    blobs: Blobs,
    limit: u64,
    results_limit: u64,
    shares: Option<Shares>,
    /// The owner of the results; without an owner they are not counted.
    results_of: Option<Who>,
}

/// An upload that is being received; it is removed unless it is kept.
#[derive(Debug)]
pub struct Upload {
    draft: Option<Draft>,
    pending: Vec<u8>,
    taken: u64,
    limit: u64,
}

/// Bytes that are collected before they are written.
const GATHERED: usize = 64 * 1024;

impl Spool {
    /// A spool in the directory of `blobs` with a limit on the length of an upload \[bytes\].
    #[must_use]
    pub fn new(blobs: Blobs, limit: u64) -> Self {
        Self { blobs, limit, results_limit: u64::MAX, shares: None, results_of: None }
    }

    /// The same with a limit on the length of a result \[bytes\].
    #[must_use]
    pub fn with_results_within(self, results_limit: u64) -> Self {
        Self { results_limit, ..self }
    }

    /// The same with bytes that callers share.
    #[must_use]
    pub fn shared(self, shares: Shares) -> Self {
        Self { shares: Some(shares), ..self }
    }

    /// The same spool, with results that count for the present caller.
    #[must_use]
    pub fn of_asker(&self) -> Self {
        Self { results_of: Some(asker()), ..self.clone() }
    }

    /// A new result.
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn result(&self) -> Result<Draft, BlobFault> {
        let draft = self.blobs.draft()?.within(self.results_limit);
        let room = self.shares.as_ref().zip(self.results_of.as_ref());
        Ok(match room {
            Some((shares, who)) => draft.counted(shares.none_of(who)),
            None => draft,
        })
    }

    /// Room for the present caller's bytes that are no upload and no result; none if callers do not share the spool.
    #[must_use]
    pub fn room(&self) -> Option<Held> {
        self.shares.as_ref().map(|shares| shares.none_of(&asker()))
    }

    /// The files beside the database.
    #[must_use]
    pub fn blobs(&self) -> &Blobs {
        &self.blobs
    }

    /// Begins an upload.
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn begin(&self) -> Result<Upload, SpoolFault> {
        self.begin_within(self.limit)
    }

    /// Begins an upload with a limit of its own \[bytes\].
    ///
    /// # Errors
    /// The file cannot be made.
    pub fn begin_within(&self, limit: u64) -> Result<Upload, SpoolFault> {
        let mut draft = self.blobs.draft()?;
        if let Some(room) = self.room() {
            draft = draft.counted(room);
        }
        Ok(Upload { draft: Some(draft), pending: Vec::new(), taken: 0, limit })
    }
}

impl Upload {
    /// Takes the next bytes.
    ///
    /// # Errors
    /// The limit is passed, or the file cannot be written.
    pub async fn take(&mut self, bytes: &Bytes) -> Result<(), SpoolFault> {
        self.taken += bytes.len() as u64;
        if self.taken > self.limit {
            return Err(SpoolFault::TooLarge { limit: self.limit });
        }
        self.pending.extend_from_slice(bytes);
        if self.pending.len() >= GATHERED { self.write_out().await } else { Ok(()) }
    }

    /// The complete upload.
    ///
    /// # Errors
    /// The file cannot be written.
    pub async fn finish(mut self) -> Result<Draft, SpoolFault> {
        self.write_out().await?;
        self.draft.ok_or_else(lost)
    }

    async fn write_out(&mut self) -> Result<(), SpoolFault> {
        let pending = std::mem::take(&mut self.pending);
        let Some(mut draft) = self.draft.take() else { return Err(lost()) };
        let written =
            tokio::task::spawn_blocking(move || draft.write_all(&pending).map(|()| (draft, pending)));
        let written = written.await.map_err(|_panicked| lost())?;
        let (draft, mut pending) = written.map_err(|fault| match no_share(&fault) {
            Some(share) => SpoolFault::NoShare(share),
            None => SpoolFault::Write(fault),
        })?;
        pending.clear();
        (self.draft, self.pending) = (Some(draft), pending);
        Ok(())
    }
}

/// The fault of shares inside a fault of writing, if there is one.
pub(super) fn no_share(fault: &std::io::Error) -> Option<NoShare> {
    fault.get_ref()?.downcast_ref::<NoShare>().copied()
}

fn lost() -> SpoolFault {
    SpoolFault::Write(std::io::Error::other("the upload was lost"))
}
