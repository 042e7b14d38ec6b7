//! From chunks of bytes to batches of blocks.

use super::dialect::Dialect;
use super::{Batch, ReadFault};

/// What a reader accepts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadLimits {
    /// Longest line, its ending included.
    pub max_line_bytes: usize,
    /// A batch is closed at this many blocks.
    pub batch_blocks: usize,
    /// A batch is closed behind the line that reaches this many bytes.
    pub batch_bytes: usize,
}

impl Default for ReadLimits {
    fn default() -> Self {
        Self { max_line_bytes: 64 * 1024, batch_blocks: 512, batch_bytes: 128 * 1024 }
    }
}

/// Reads a program from chunks of bytes of any size.
#[derive(Debug)]
pub struct Reader {
    limits: ReadLimits,
}

impl Reader {
    /// A reader for this dialect, or for the one that the beginning of the text shows.
    #[must_use]
    pub fn new(_dialect: Option<Dialect>, limits: ReadLimits) -> Self {
        Self { limits }
    }

    /// Takes the next bytes of the upload. Call [`Self::next_batch`] until it gives nothing before feeding more.
    pub fn feed(&mut self, _chunk: &[u8]) {}

    /// Says that there is no more.
    pub fn finish(&mut self) {}

    /// Fills `batch` with the next blocks; false if more bytes are needed first, or if all have been given. Batches
    /// depend on the text alone, not on how it was cut into chunks.
    ///
    /// # Errors
    /// The text cannot be read as a program; the reader gives nothing more then.
    pub fn next_batch(&mut self, _batch: &mut Batch) -> Result<bool, ReadFault> {
        let _ = self.limits;
        Ok(false)
    }

    /// The dialect, as soon as it is known.
    #[must_use]
    pub fn dialect(&self) -> Option<Dialect> {
        None
    }
}
