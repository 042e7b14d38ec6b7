//! From chunks of bytes to batches of blocks.

use super::dialect::{Dialect, DialectRules, LineRead, Read, Source, detect};
use super::line::{is_blank, line_end, next_line};
use super::{Batch, Block, BlockFlags, BlockKind, ReadFault};

/// The limits of what a reader accepts and how much it returns at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadLimits {
    /// The longest line, its ending included.
    pub max_line_bytes: usize,
    /// A batch is closed at this many blocks.
    pub batch_blocks: usize,
    /// A batch is closed after the line that reaches this many bytes.
    pub batch_bytes: usize,
}

impl Default for ReadLimits {
    fn default() -> Self {
        Self { max_line_bytes: 64 * 1024, batch_blocks: 512, batch_bytes: 128 * 1024 }
    }
}

/// Reads a program from chunks of bytes of any size. It keeps the bytes of one chunk, of one batch, and of the opening
/// lines that show the dialect.
#[derive(Debug)]
pub struct Reader {
    limits: ReadLimits,
    wanted: Option<Dialect>,
    opening: Option<detect::Opening>,
    /// Bytes that are not in a batch yet.
    pending: Vec<u8>,
    /// The number of bytes of `pending` that are already in `current`.
    taken: usize,
    /// The position up to which `pending` has been searched for line endings, and one after the last ending found.
    searched: usize,
    complete: usize,
    /// The number of last bytes of `pending` that are examined as following text but not returned.
    held: usize,
    current: Batch,
    next_line: u64,
    has_header: bool,
    finished: bool,
    failed: Option<ReadFault>,
}

impl Reader {
    /// A reader for this dialect, or for the dialect that the beginning of the text shows.
    #[must_use]
    pub fn new(dialect: Option<Dialect>, limits: ReadLimits) -> Self {
        Self {
            limits,
            wanted: dialect,
            opening: None,
            pending: Vec::new(),
            taken: 0,
            searched: 0,
            complete: 0,
            held: 0,
            current: Batch::new(),
            next_line: 1,
            has_header: false,
            finished: false,
            failed: None,
        }
    }

    /// Takes the next bytes of the upload. Call [`Self::next_batch`] until it returns nothing before you feed more,
    /// because bytes that were fed and not taken are kept.
    pub fn feed(&mut self, chunk: &[u8]) {
        if self.failed.is_some() || self.finished {
            return;
        }
        self.pending.drain(..self.taken);
        self.searched -= self.taken;
        self.complete = self.complete.saturating_sub(self.taken);
        self.taken = 0;
        self.pending.extend_from_slice(chunk);
        self.find_complete();
    }

    /// States that no more bytes follow. The rest is the last line.
    pub fn finish(&mut self) {
        self.finished = true;
        self.complete = self.pending.len();
    }

    /// Fills `batch` with the next blocks; false if it needs more bytes first, or if all blocks have been returned.
    /// Batches depend only on the text, not on how it was cut into chunks.
    ///
    /// # Errors
    /// The text cannot be read as a program. The reader then returns nothing more.
    pub fn next_batch(&mut self, batch: &mut Batch) -> Result<bool, ReadFault> {
        self.give(batch, false)
    }

    /// The same without waiting for a full batch: all whole lines so far.
    ///
    /// # Errors
    /// As [`Self::next_batch`].
    pub fn next_part(&mut self, batch: &mut Batch) -> Result<bool, ReadFault> {
        self.give(batch, true)
    }

    /// Holds the last `bytes` bytes fed. They are examined if a statement depends on the text after it, but they are
    /// not returned until this is called with 0. They begin with a line.
    pub fn hold(&mut self, bytes: usize) {
        self.held = bytes.min(self.pending.len() - self.taken);
    }

    /// Whether all bytes that were fed and not [held](Self::hold) have been returned, and the dialect is known.
    #[must_use]
    pub fn is_between_lines(&self) -> bool {
        let is_given = self.taken + self.held == self.pending.len();
        self.opening.is_some() && is_given && self.current.blocks.is_empty()
    }

    /// Continues after `lines` lines that are held or, if none are held, not fed. Call it only [between
    /// lines](Self::is_between_lines).
    pub fn pass_over(&mut self, lines: u64, bytes: usize) {
        debug_assert!(self.is_between_lines(), "no bytes wait before the lines that are passed over");
        let held = bytes.min(self.held);
        self.held -= held;
        self.taken += held;
        self.next_line += lines;
        self.current.offset += bytes as u64;
    }

    fn give(&mut self, batch: &mut Batch, partly: bool) -> Result<bool, ReadFault> {
        if let Some(fault) = self.failed {
            return Err(fault);
        }
        let full = self.fill().inspect_err(|fault| self.failed = Some(*fault))?;
        let filled = full || (partly && !self.current.blocks.is_empty());
        if filled {
            batch.clear();
            self.current.note_line_ending();
            let offset = self.current.offset + self.current.text.len() as u64;
            std::mem::swap(batch, &mut self.current);
            self.current.clear();
            self.current.offset = offset;
            self.current.dialect = batch.dialect;
            self.current.separator = batch.separator;
            self.current.habits = batch.habits;
            if batch.dialect.rules().states_feed_apart {
                let last_feed =
                    batch.blocks.iter().rev().find_map(|block| super::batch::FeedStatement::of(batch, block));
                self.current.habits.feed_before = last_feed.unwrap_or(batch.habits.feed_before);
            }
            self.current.columns.clone_from(&batch.columns);
        }
        Ok(filled)
    }

    /// The dialect, as soon as it is known.
    #[must_use]
    pub fn dialect(&self) -> Option<Dialect> {
        self.opening.map(|opening| opening.dialect)
    }

    /// Moves `complete` to the byte after the last line ending in `pending`. A final CR waits, because it may be half
    /// of CR LF.
    fn find_complete(&mut self) {
        let fresh = self.pending.get(self.searched..).unwrap_or_default();
        let last = match memchr::memrchr2(b'\n', b'\r', fresh) {
            Some(at) if fresh[at] == b'\r' && at + 1 == fresh.len() => {
                memchr::memrchr2(b'\n', b'\r', &fresh[..at])
            }
            found => found,
        };
        if let Some(at) = last {
            self.complete = self.searched + at + 1;
        }
        self.searched = self.pending.len() - usize::from(self.pending.last() == Some(&b'\r'));
    }

    /// Whether enough of the beginning has arrived to find the dialect, and how much of it is examined.
    fn opening_length(&self) -> Option<usize> {
        let head = &self.pending[..self.pending.len().min(detect::MAX_BYTES)];
        if self.finished && self.pending.len() < detect::MAX_BYTES {
            return Some(head.len());
        }
        if let Some(at) = memchr::memchr_iter(b'\n', head).nth(detect::MAX_LINES - 1) {
            return Some(at + 1);
        }
        (self.pending.len() >= detect::MAX_BYTES)
            .then(|| memchr::memrchr2(b'\n', b'\r', head).map_or(head.len(), |at| at + 1))
    }

    fn fill(&mut self) -> Result<bool, ReadFault> {
        if self.opening.is_none() {
            if !self.finished && self.pending.len() > self.complete + self.limits.max_line_bytes {
                return Err(self.too_long());
            }
            let Some(length) = self.opening_length() else { return Ok(false) };
            let opening = detect::opening(&self.pending[..length], self.wanted);
            if let Some((dialect, line)) = opening.foreign {
                return Err(ReadFault::UnsupportedDialect { line, dialect });
            }
            self.current.dialect = opening.dialect;
            self.opening = Some(opening);
        }
        let origin = self.taken;
        let held = self.current.text.len();
        let full = self.take_lines();
        self.current.text.extend_from_slice(&self.pending[origin..self.taken]);
        debug_assert!(self.current.text.len() == held + self.taken - origin, "every byte is kept");
        if !full? {
            let rest = self.pending.len() - self.complete.max(self.taken);
            if rest > self.limits.max_line_bytes {
                return Err(self.too_long());
            }
            return Ok(self.finished && !self.current.blocks.is_empty());
        }
        Ok(true)
    }

    fn too_long(&self) -> ReadFault {
        let lines =
            memchr::memchr_iter(b'\n', &self.pending[self.taken..self.complete.max(self.taken)]).count();
        let line = self.next_line + lines as u64;
        ReadFault::LineTooLong { line, max_bytes: self.limits.max_line_bytes }
    }

    /// Reads whole lines into the current batch until it is full (true) or no lines are left (false).
    fn take_lines(&mut self) -> Result<bool, ReadFault> {
        let Some(opening) = self.opening else { return Ok(false) };
        // The difference from a position in `pending` to a position in the batch's text.
        let shift = self.current.text.len().wrapping_sub(self.taken);
        let text = &self.pending[..self.complete];
        let DialectRules { read, read_header, .. } = opening.dialect.rules();
        loop {
            let start = self.taken;
            let length = start.wrapping_add(shift);
            if self.current.blocks.len() >= self.limits.batch_blocks || length >= self.limits.batch_bytes {
                return Ok(true);
            }
            if start >= text.len().min(self.pending.len() - self.held) {
                return Ok(false);
            }
            let source = Source { text, start, shift, line: self.next_line, is_last: self.finished };
            let line = self.next_line;
            let read = if line <= opening.banner_lines {
                LineRead::one(skip_line(source, BlockKind::Banner, &mut self.current))
            } else if let Some(read_header) = read_header.filter(|_| !self.has_header) {
                let header = text.get(start..line_end(text, start)).unwrap_or_default();
                let kind = if is_blank(header) {
                    BlockKind::Blank
                } else {
                    (self.current.columns, self.current.separator) = read_header(header, line)?;
                    self.has_header = true;
                    BlockKind::Header
                };
                LineRead::one(skip_line(source, kind, &mut self.current))
            } else {
                let read = match read {
                    Read::Lines(read) => Some(read(source, &mut self.current)),
                    Read::Statements(read) => read(source, &mut self.current),
                };
                // A statement of several lines needs its last line.
                let Some(read) = read else {
                    if text.len() - start > self.limits.max_line_bytes {
                        return Err(ReadFault::LineTooLong { line, max_bytes: self.limits.max_line_bytes });
                    }
                    return Ok(false);
                };
                read
            };
            if read.next - start > self.limits.max_line_bytes {
                return Err(ReadFault::LineTooLong { line, max_bytes: self.limits.max_line_bytes });
            }
            self.taken = read.next;
            self.next_line += read.lines;
        }
    }
}

/// Adds a line without reading it.
fn skip_line(source: Source<'_>, kind: BlockKind, batch: &mut Batch) -> usize {
    let Source { text, start, shift, line, .. } = source;
    let body_end = line_end(text, start);
    let end = next_line(text, body_end);
    let at = |position: usize| position.wrapping_add(shift);
    #[expect(clippy::cast_possible_truncation, reason = "a batch is closed far below 4 GiB")]
    let (start, body_end, end_in_batch, words) =
        (at(start) as u32, at(body_end) as u32, at(end) as u32, batch.words.len() as u32);
    batch.blocks.push(Block {
        line,
        start,
        body_end,
        end: end_in_batch,
        words_start: words,
        words_end: words,
        kind,
        flags: BlockFlags::default(),
    });
    end
}
