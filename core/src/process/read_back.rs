//! The bytes that leave, read back as a control would read them, beside what was meant.
//!
//! Reader and interpreter here know nothing of the writer.

use std::collections::VecDeque;

use super::inventory::Inventory;
use super::report::DeviationTotals;
use super::tool_vectors::ToolVectors;
use super::{Fault, ProgramSetup, Series, SeriesPoint};
use crate::contact::Sampled;
use crate::machine::Machine;
use crate::motion::{Interpreter, Motion};
use crate::program::{Address, Batch, Block, Diagnostics, Dialect, ReadLimits, Reader, Severity, Word};

/// What the next motion of the written program has to be.
pub(super) trait Awaited {
    /// The source's line that it comes from.
    fn line(&self) -> u64;
    /// What is said where it never comes.
    fn missing(&self) -> &'static str;
}

/// A word that has the machine do something, as it was read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MachineWord {
    /// How many motions stand before its block.
    pub(super) motions: u64,
    pub(super) address: Address,
    pub(super) value: f64,
}

/// Pairs every motion that is read with what was meant.
pub(super) struct ReadBack<E> {
    reader: Reader,
    interpreter: Interpreter,
    vectors: ToolVectors,
    batch: Batch,
    motions: Vec<Motion>,
    /// How many of `motions` were handed out.
    seen: usize,
    diagnostics: Diagnostics,
    /// Blocks before the batch at hand.
    blocks_before: u64,
    /// Lines are read as soon as they are there; else in full batches.
    is_eager: bool,
    /// A statement may run over lines, or hang on the one behind it.
    pub(super) looks_ahead: bool,
    /// What comes next; empty only where `later` is.
    expected: VecDeque<E>,
    /// What comes behind it, in the order written.
    later: VecDeque<VecDeque<E>>,
    /// Queues that were worked off: their memory is used again.
    spare: Vec<VecDeque<E>>,
    pub(super) inventory: Inventory,
    /// M, S, G4 and its P, in their order, where somebody takes them.
    words: Option<VecDeque<MachineWord>>,
    /// Motions before the batch at hand.
    motions_before: u64,
}

impl<E: Awaited> ReadBack<E> {
    pub(super) fn new(machine: &Machine, dialect: Dialect, program: &ProgramSetup) -> Self {
        Self {
            reader: Reader::new(Some(dialect), ReadLimits::default()),
            interpreter: Interpreter::new(machine, program.options()),
            vectors: ToolVectors::new(machine, program),
            batch: Batch::new(),
            motions: Vec::new(),
            seen: 0,
            diagnostics: Diagnostics::new(),
            blocks_before: 0,
            is_eager: false,
            looks_ahead: dialect.rules().looks_ahead,
            expected: VecDeque::new(),
            later: VecDeque::new(),
            spare: Vec::new(),
            inventory: Inventory::default(),
            words: None,
            motions_before: 0,
        }
    }

    /// Words for the machine are kept until they are [taken](Self::take_word). Not where blocks are passed over.
    pub(super) fn with_words(mut self) -> Self {
        self.words = Some(VecDeque::new());
        self
    }

    /// The next word for the machine that was read.
    pub(super) fn take_word(&mut self) -> Option<MachineWord> {
        self.words.as_mut()?.pop_front()
    }

    fn note_words(&mut self) {
        let Some(words) = &mut self.words else { return };
        for (index, block) in self.batch.blocks().iter().enumerate() {
            for word in self.batch.words(block) {
                let is_dwell = word.address == Address::G && (word.value - 4.0).abs() <= 0.0;
                if is_dwell || matches!(word.address, Address::M | Address::S | Address::P) {
                    let before = self.motions.partition_point(|motion| (motion.block as usize) < index);
                    let motions = self.motions_before + before as u64;
                    words.push_back(MachineWord { motions, address: word.address, value: word.value });
                }
            }
        }
    }

    /// Lines are read as soon as they were fed.
    pub(super) fn eager(mut self) -> Self {
        self.is_eager = true;
        self
    }

    /// The words that name places, of the block that makes the motion read last.
    pub(super) fn coordinates_read(&self) -> impl Iterator<Item = &Word> {
        let last = self.seen.checked_sub(1).and_then(|index| self.motions.get(index));
        let block = last.and_then(|motion| self.batch.blocks().get(motion.block as usize));
        let words = block.map_or(&[][..], |block| self.batch.words(block));
        words.iter().filter(|word| word.address.is_coordinate())
    }

    /// How many blocks stand before that of the motion read last.
    pub(super) fn blocks_before(&self) -> u64 {
        let last = self.seen.checked_sub(1).and_then(|index| self.motions.get(index));
        self.blocks_before + last.map_or(0, |motion| u64::from(motion.block))
    }

    /// How many blocks were read.
    pub(super) fn blocks_read(&self) -> u64 {
        self.blocks_before + self.batch.blocks().len() as u64
    }

    /// What has to come next, to be changed.
    pub(super) fn awaited_mut(&mut self) -> impl Iterator<Item = &mut E> {
        self.expected.iter_mut().chain(self.later.iter_mut().flatten())
    }

    /// Whether motions that repeat the one read last can be [passed over](Self::pass_over).
    pub(super) fn can_pass_over(&self) -> bool {
        self.seen == self.motions.len() && self.reader.is_between_lines() && self.interpreter.can_pass_over()
    }

    /// Goes on behind blocks that stand in the output as they stand in the source, on so many lines, and make these
    /// motions; what was expected of them is taken away by the caller.
    pub(super) fn pass_over(&mut self, batch: &Batch, blocks: &[Block], lines: u64, motions: &[Motion]) {
        let bytes = blocks.iter().map(|block| (block.end - block.start) as usize).sum();
        self.reader.pass_over(lines, bytes);
        self.interpreter.pass_over(motions);
        self.vectors.pass_over(motions);
        self.inventory.see_blocks(batch, blocks);
        self.blocks_before += self.batch.blocks().len() as u64 + blocks.len() as u64;
        self.batch.clear();
        self.motions.clear();
        self.seen = 0;
    }

    /// What has to come next, in the order written.
    pub(super) fn await_next(&mut self, next: E) {
        self.later.back_mut().unwrap_or(&mut self.expected).push_back(next);
    }

    /// These bytes of the output were written.
    pub(super) fn feed(&mut self, bytes: &[u8]) {
        self.reader.feed(bytes);
    }

    /// The last so many of them are only looked at until this is called with 0.
    pub(super) fn hold(&mut self, bytes: usize) {
        self.reader.hold(bytes);
    }

    /// Nothing more is written.
    pub(super) fn end(&mut self) {
        self.reader.finish();
    }

    /// Takes over what has to come next, in the order written; leaves the queue empty.
    pub(super) fn await_all(&mut self, next: &mut VecDeque<E>) {
        if self.expected.is_empty() {
            std::mem::swap(&mut self.expected, next);
        } else if !next.is_empty() {
            let empty = self.spare.pop().unwrap_or_default();
            self.later.push_back(std::mem::replace(next, empty));
        }
    }

    fn pop(&mut self) -> Option<E> {
        let popped = self.expected.pop_front();
        if self.expected.is_empty()
            && let Some(next) = self.later.pop_front()
        {
            self.spare.push(std::mem::replace(&mut self.expected, next));
        }
        popped
    }

    /// The next motion that can be read, with what it has to be.
    pub(super) fn next(&mut self) -> Result<Option<(Motion, E)>, Fault> {
        if !self.advance()? {
            return Ok(None);
        }
        let motion = self.pair().map(|(motion, _)| *motion);
        Ok(motion.zip(self.pop()))
    }

    /// The motion that was read last, with what it has to be.
    pub(super) fn pair(&self) -> Option<(&Motion, &E)> {
        self.motions.get(self.seen.checked_sub(1)?).zip(self.expected.front())
    }

    /// The pair looked at is done with.
    pub(super) fn drop_pair(&mut self) {
        self.pop();
    }

    /// Takes away what has to come next.
    pub(super) fn take_awaited(&mut self) -> Option<E> {
        self.pop()
    }

    /// Reads on to the next motion; false where it is not there yet.
    pub(super) fn advance(&mut self) -> Result<bool, Fault> {
        while self.seen == self.motions.len() {
            let before = self.batch.blocks().len() as u64;
            let is_there = if self.is_eager {
                self.reader.next_part(&mut self.batch)?
            } else {
                self.reader.next_batch(&mut self.batch)?
            };
            if !is_there {
                return Ok(false);
            }
            self.blocks_before += before;
            self.motions_before += self.motions.len() as u64;
            self.motions.clear();
            self.seen = 0;
            // Which words are a tool axis is known then.
            self.interpreter.interpret(&mut self.batch, &mut self.motions, &mut self.diagnostics);
            self.vectors.resolve(&mut self.motions);
            self.inventory.see(&self.batch);
            self.note_words();
            if self.diagnostics.count(Severity::Refusal) > 0 {
                let line = self.expected.front().map_or(0, Awaited::line);
                return Err(failed(line, "the written program is not readable"));
            }
        }
        let line = self.motions.get(self.seen).map_or(0, |motion| motion.line);
        self.seen += 1;
        if self.expected.is_empty() {
            return Err(failed(line, "a motion too many"));
        }
        Ok(true)
    }

    /// Everything expected must have come.
    pub(super) fn has_all(&self) -> Result<(), Fault> {
        self.expected.front().map_or(Ok(()), |next| Err(failed(next.line(), next.missing())))
    }

    /// Nothing was read so far that is warned of.
    pub(super) fn has_no_warning(&self) -> Result<(), Fault> {
        if self.diagnostics.count(Severity::Warning) == 0 {
            return Ok(());
        }
        let line = self.expected.front().map_or(0, Awaited::line);
        Err(failed(line, "the written program is not readable"))
    }

    /// Everything expected must have come, and nothing of the source be lost or doubled.
    pub(super) fn is_whole(&self, source: &Inventory) -> Result<(), Fault> {
        self.has_all()?;
        if !source.is_kept_by(&self.inventory) {
            return Err(failed(0, "blocks or words that are not to be changed were lost or doubled"));
        }
        Ok(())
    }
}

/// Deviations of the source and of what was read back, motion by motion.
#[derive(Debug, Default)]
pub(super) struct BeforeAfter {
    pub(super) before: DeviationTotals,
    pub(super) after: DeviationTotals,
    pub(super) series: Series,
}

impl BeforeAfter {
    /// One motion's.
    pub(super) fn record(&mut self, line: u64, path_mm: f64, before: &Sampled, after: &Sampled) {
        self.before.add(line, path_mm, before);
        self.after.add(line, path_mm, after);
        let (path_mm, before_mm, after_mm) = (self.before.path_mm(), before.max_mm, after.max_mm);
        self.series.push(SeriesPoint { path_mm, line, before_mm, after_mm });
    }
}

pub(super) fn failed(line: u64, what: &'static str) -> Fault {
    Fault::VerificationFailed { line, what }
}
