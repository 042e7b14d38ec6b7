//! A program written from another one: blocks are copied or written again, feeds that inserted blocks replaced are
//! restored, and inserted lines are recorded.

use super::emit::Emitter;
use super::outgoing::Outgoing;
use crate::motion::{Motion, MotionKind};
use crate::process::fault::Fault;
use crate::process::text::{Inventory, LineMap, Numbering, Passage, line_ends};
use crate::program::{Batch, NewWord, WriteFault, print_changed};

/// A passage, and its index in the current stretch.
pub(in crate::process) type Placed<'p> = (usize, &'p Passage);

/// Writes the passages of a program one after the other.
#[derive(Debug, Default)]
pub(in crate::process) struct Rewriter {
    emitter: Emitter,
    lines: LineMap,
    /// Blocks of the current passage that are written.
    copied: usize,
    /// Inserted blocks, without those that only state a feed.
    inserted: u64,
}

impl Rewriter {
    /// For a program with this numbering.
    pub(in crate::process) fn new(numbering: Numbering) -> Self {
        Self { emitter: Emitter::new(numbering), ..Self::default() }
    }

    /// Begins a passage. If the previous one ended with an owed F, restores it before this passage changes the
    /// meaning of F.
    pub(in crate::process) fn begin<E>(
        &mut self,
        passage: &Passage,
        out: &mut Outgoing<E>,
    ) -> Result<(), Fault> {
        self.copied = 0;
        let Some(first) = passage.batch.blocks().first() else { return Ok(()) };
        let from = out.text.len();
        self.emitter
            .settle(&passage.batch, 0, 0, &mut out.text)
            .map_err(|fault| Fault::Unwritable { line: first.line, fault })?;
        self.lines.insert(first.line.saturating_sub(1), line_ends(&out.text[from..]))
    }

    /// Leaves the block of a motion unchanged, but restores its feed. Returns whether it was written again for
    /// that.
    pub(in crate::process) fn leave<E>(
        &mut self,
        passage: Placed<'_>,
        motion: &Motion,
        out: &mut Outgoing<E>,
    ) -> Result<bool, Fault> {
        if !self.emitter.owes_feed() {
            return Ok(false);
        }
        self.copy_before(passage, motion, out);
        let batch = &passage.1.batch;
        let (feed_blocks, from) = (self.emitter.feed_blocks, out.text.len());
        let is_changed = self
            .emitter
            .restore_feed(batch, motion, &mut out.text)
            .map_err(|fault| Fault::Unwritable { line: motion.line, fault })?;
        if self.emitter.feed_blocks > feed_blocks {
            let own = if is_changed { own_lines(batch, motion) } else { 0 };
            self.note_lines(batch, motion, &out.text[from..], own)?;
        }
        self.copied += usize::from(is_changed);
        Ok(is_changed)
    }

    /// Writes the block of a motion with these words changed or added, and with its feed: `feed`, or the source's if
    /// the written program has another one in force. A block that needs none of them is left unchanged. Returns
    /// whether it was written.
    pub(in crate::process) fn rewrite<E>(
        &mut self,
        passage: Placed<'_>,
        motion: &Motion,
        words: &mut Vec<NewWord>,
        feed: Option<NewWord>,
        out: &mut Outgoing<E>,
    ) -> Result<bool, Fault> {
        if let Some(feed) = feed {
            // It is written even if it should already be in force, because an F may have been inserted between the
            // blocks.
            self.emitter.owe(&motion.feed);
            words.push(feed);
        } else if motion.kind != MotionKind::Rapid
            && let Some(owed) = self.emitter.take_owed(&motion.feed)
        {
            self.emitter.feeds_restored += u64::from(words.is_empty());
            words.push(owed);
        }
        if words.is_empty() {
            return Ok(false);
        }
        self.change(passage, motion, words, out)?;
        Ok(true)
    }

    fn change<E>(
        &mut self,
        passage: Placed<'_>,
        motion: &Motion,
        words: &[NewWord],
        out: &mut Outgoing<E>,
    ) -> Result<(), Fault> {
        self.anew(passage, motion, out, |emitter, text| {
            print_changed(&passage.1.batch, motion.block as usize, words, false, text)?;
            emitter.count_feed(&passage.1.batch, words);
            Ok(())
        })
    }

    /// Writes the block of a motion again, after copying those before it.
    pub(in crate::process) fn anew<E>(
        &mut self,
        passage: Placed<'_>,
        motion: &Motion,
        out: &mut Outgoing<E>,
        write: impl FnOnce(&mut Emitter, &mut Vec<u8>) -> Result<(), WriteFault>,
    ) -> Result<(), Fault> {
        self.copy_before(passage, motion, out);
        let (batch, index, from) = (&passage.1.batch, motion.block as usize, out.text.len());
        write(&mut self.emitter, &mut out.text)
            .and_then(|()| self.emitter.settle(batch, index, index + 1, &mut out.text))
            .map_err(|fault| Fault::Unwritable { line: motion.line, fault })?;
        self.note_lines(batch, motion, &out.text[from..], own_lines(batch, motion))?;
        self.copied = index + 1;
        Ok(())
    }

    /// Ends a passage by copying the rest of it.
    pub(in crate::process) fn end<E>(&mut self, passage: Placed<'_>, out: &mut Outgoing<E>) {
        out.copy(passage, self.copied, passage.1.batch.blocks().len());
    }

    /// Counts blocks that were inserted after a divided one.
    pub(in crate::process) fn count_inserted(&mut self, blocks: u64) {
        self.inserted += blocks;
    }

    /// Blocks inserted so far, without those that only state a feed.
    pub(in crate::process) fn inserted(&self) -> u64 {
        self.inserted
    }

    /// Blocks in which only the F word was restored, and blocks inserted for it.
    pub(in crate::process) fn feeds_restored(&self) -> u64 {
        self.emitter.feeds_restored
    }

    /// The inventory that the written program must have, from what was read.
    pub(in crate::process) fn inventory(&self, read: &Inventory) -> Inventory {
        let mut inventory = *read;
        inventory.inserted += self.inserted + self.emitter.feed_blocks;
        inventory.join(&self.emitter.numbers);
        inventory
    }

    /// The inserted lines, as a map to the lines read.
    pub(in crate::process) fn into_lines(self) -> LineMap {
        self.lines
    }

    fn copy_before<E>(&mut self, passage: Placed<'_>, motion: &Motion, out: &mut Outgoing<E>) {
        out.copy(passage, self.copied, motion.block as usize);
        self.copied = motion.block as usize;
    }

    /// Records the lines written for this motion. The source has `own` of them; if it has none, they come before
    /// its block.
    fn note_lines(&mut self, batch: &Batch, motion: &Motion, written: &[u8], own: u64) -> Result<(), Fault> {
        let line = batch.blocks().get(motion.block as usize).map_or(motion.line, |block| block.line);
        self.lines.insert(line.saturating_sub(u64::from(own == 0)), line_ends(written).saturating_sub(own))
    }
}

/// Number of lines that end in the block of this motion.
fn own_lines(batch: &Batch, motion: &Motion) -> u64 {
    let own = batch.blocks().get(motion.block as usize);
    own.map_or(0, |block| line_ends(batch.block_text(block)))
}
