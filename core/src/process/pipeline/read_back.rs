//! Reads the output bytes back as a control would, and compares them with the intended motions.
//!
//! The reader and interpreter here know nothing of the writer.

use std::collections::VecDeque;

use super::deviation::DeviationTotals;
use super::series::{Series, SeriesPoint};
use crate::contact::Sampled;
use crate::machine::Machine;
use crate::motion::{Interpreter, Motion};
use crate::process::fault::Fault;
use crate::process::set_up::{ProgramSetup, ToolVectors};
use crate::process::text::Inventory;
use crate::program::{Address, Batch, Block, Diagnostics, Dialect, ReadLimits, Reader, Severity, Word};

/// What the next motion of the written program must be.
pub(in crate::process) trait Expected {
    /// Its line of the source.
    fn line(&self) -> u64;
    /// The message if it never comes.
    fn missing(&self) -> &'static str;
}

/// G codes that are words for the machine: a dwell, and a plain tool length.
const KEPT_G: [f64; 2] = [4.0, 43.0];

/// A word that makes the machine do something, as read back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::process) struct MachineWord {
    /// Number of motions before its block.
    pub(in crate::process) motions: u64,
    pub(in crate::process) address: Address,
    pub(in crate::process) value: f64,
}

/// Pairs every motion that is read with the intended one.
pub(in crate::process) struct ReadBack<E> {
    reader: Reader,
    interpreter: Interpreter,
    vectors: ToolVectors,
    batch: Batch,
    motions: Vec<Motion>,
    /// How many of `motions` were returned.
    seen: usize,
    diagnostics: Diagnostics,
    /// Blocks before the current batch.
    blocks_before: u64,
    /// Lines are read as soon as they arrive, otherwise in full batches.
    is_eager: bool,
    /// A statement may run over several lines, or depend on the next one.
    pub(in crate::process) looks_ahead: bool,
    /// The next expected motions; empty only if `later` is.
    expected: VecDeque<E>,
    /// The motions expected after them, in the order written.
    later: VecDeque<VecDeque<E>>,
    /// Finished queues, whose memory is used again.
    spare: Vec<VecDeque<E>>,
    pub(in crate::process) inventory: Inventory,
    /// M, S, T, G4 and its P, G43 and H, in order, if the caller takes them.
    words: Option<VecDeque<MachineWord>>,
    /// Motions before the current batch.
    motions_before: u64,
}

impl<E: Expected> ReadBack<E> {
    pub(in crate::process) fn new(machine: &Machine, dialect: Dialect, program: &ProgramSetup) -> Self {
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

    /// Keeps words for the machine until they are [taken](Self::take_word). Blocks that are passed over give no
    /// words.
    pub(in crate::process) fn with_words(mut self) -> Self {
        self.words = Some(VecDeque::new());
        self
    }

    /// The next word for the machine.
    pub(in crate::process) fn take_word(&mut self) -> Option<MachineWord> {
        self.words.as_mut()?.pop_front()
    }

    fn note_words(&mut self) {
        let Some(words) = &mut self.words else { return };
        for (index, block) in self.batch.blocks().iter().enumerate() {
            for word in self.batch.words(block) {
                let is_kept = match word.address {
                    Address::M | Address::S | Address::P | Address::T | Address::H => true,
                    Address::G => KEPT_G.contains(&word.value),
                    _ => false,
                };
                if is_kept {
                    let before = self.motions.partition_point(|motion| (motion.block as usize) < index);
                    let motions = self.motions_before + before as u64;
                    words.push_back(MachineWord { motions, address: word.address, value: word.value });
                }
            }
        }
    }

    /// Makes lines be read as soon as they were fed.
    pub(in crate::process) fn eager(mut self) -> Self {
        self.is_eager = true;
        self
    }

    /// The words with positions in the block of the motion read last.
    pub(in crate::process) fn coordinates_read(&self) -> impl Iterator<Item = &Word> {
        let last = self.seen.checked_sub(1).and_then(|index| self.motions.get(index));
        let block = last.and_then(|motion| self.batch.blocks().get(motion.block as usize));
        let words = block.map_or(&[][..], |block| self.batch.words(block));
        words.iter().filter(|word| word.address.is_coordinate())
    }

    /// Number of blocks before that of the motion read last.
    pub(in crate::process) fn blocks_before(&self) -> u64 {
        let last = self.seen.checked_sub(1).and_then(|index| self.motions.get(index));
        self.blocks_before + last.map_or(0, |motion| u64::from(motion.block))
    }

    /// Number of blocks read.
    pub(in crate::process) fn blocks_read(&self) -> u64 {
        self.blocks_before + self.batch.blocks().len() as u64
    }

    /// The expected motions, to be changed.
    pub(in crate::process) fn awaited_mut(&mut self) -> impl Iterator<Item = &mut E> {
        self.expected.iter_mut().chain(self.later.iter_mut().flatten())
    }

    /// Whether motions that repeat the one read last can be [passed over](Self::pass_over).
    pub(in crate::process) fn can_pass_over(&self) -> bool {
        self.seen == self.motions.len() && self.reader.is_between_lines() && self.interpreter.can_pass_over()
    }

    /// Continues after blocks that are the same in output and source, on `lines` lines, and that make these
    /// motions. The caller removes the motions expected from them.
    pub(in crate::process) fn pass_over(
        &mut self,
        batch: &Batch,
        blocks: &[Block],
        lines: u64,
        motions: &[Motion],
    ) {
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

    /// Expects this motion after all others.
    pub(in crate::process) fn await_next(&mut self, next: E) {
        self.later.back_mut().unwrap_or(&mut self.expected).push_back(next);
    }

    /// Takes these written bytes of the output.
    pub(in crate::process) fn feed(&mut self, bytes: &[u8]) {
        self.reader.feed(bytes);
    }

    /// The last `bytes` bytes are only looked at until this is called with 0.
    pub(in crate::process) fn hold(&mut self, bytes: usize) {
        self.reader.hold(bytes);
    }

    /// Called when nothing more is written.
    pub(in crate::process) fn end(&mut self) {
        self.reader.finish();
    }

    /// Takes over the expected motions, in the order written, and leaves the queue empty.
    pub(in crate::process) fn expect_all(&mut self, next: &mut VecDeque<E>) {
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

    /// The next motion that can be read, with the expected one.
    pub(in crate::process) fn next(&mut self) -> Result<Option<(Motion, E)>, Fault> {
        if !self.advance()? {
            return Ok(None);
        }
        let motion = self.pair().map(|(motion, _)| *motion);
        Ok(motion.zip(self.pop()))
    }

    /// The motion that was read last, with the expected one.
    pub(in crate::process) fn pair(&self) -> Option<(&Motion, &E)> {
        self.motions.get(self.seen.checked_sub(1)?).zip(self.expected.front())
    }

    /// Removes the pair that was looked at.
    pub(in crate::process) fn drop_pair(&mut self) {
        self.pop();
    }

    /// Removes the next expected motion and returns it.
    pub(in crate::process) fn take_expected(&mut self) -> Option<E> {
        self.pop()
    }

    /// Reads on to the next motion; false if it has not arrived yet.
    pub(in crate::process) fn advance(&mut self) -> Result<bool, Fault> {
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
            // From here on it is known which words are a tool axis.
            self.interpreter.interpret(&mut self.batch, &mut self.motions, &mut self.diagnostics);
            self.vectors.resolve(&mut self.motions);
            self.inventory.see(&self.batch);
            self.note_words();
            if self.diagnostics.count(Severity::Refusal) > 0 {
                let line = self.expected.front().map_or(0, Expected::line);
                return Err(failed(line, "the written program cannot be read"));
            }
        }
        let line = self.motions.get(self.seen).map_or(0, |motion| motion.line);
        self.seen += 1;
        if self.expected.is_empty() {
            return Err(failed(line, "the written program has a motion too many"));
        }
        Ok(true)
    }

    /// Every expected motion must have been read.
    pub(in crate::process) fn has_all(&self) -> Result<(), Fault> {
        self.expected.front().map_or(Ok(()), |next| Err(failed(next.line(), next.missing())))
    }

    /// The text read so far must give no warning.
    pub(in crate::process) fn has_no_warning(&self) -> Result<(), Fault> {
        if self.diagnostics.count(Severity::Warning) == 0 {
            return Ok(());
        }
        let line = self.expected.front().map_or(0, Expected::line);
        Err(failed(line, "the written program cannot be read"))
    }

    /// Every expected motion must have been read, and nothing of the source may be lost or doubled.
    pub(in crate::process) fn is_whole(&self, source: &Inventory) -> Result<(), Fault> {
        self.has_all()?;
        if !source.is_kept_by(&self.inventory) {
            return Err(failed(0, "blocks or words that are not to be changed were lost or doubled"));
        }
        Ok(())
    }
}

/// Deviations of the source and of the text read back, motion by motion.
#[derive(Debug, Default)]
pub(in crate::process) struct BeforeAfter {
    pub(in crate::process) before: DeviationTotals,
    pub(in crate::process) after: DeviationTotals,
    pub(in crate::process) series: Series,
}

impl BeforeAfter {
    /// Records those of one motion.
    pub(in crate::process) fn record(&mut self, line: u64, path_mm: f64, before: &Sampled, after: &Sampled) {
        self.before.add(line, path_mm, before);
        self.after.add(line, path_mm, after);
        let (path_mm, before_mm, after_mm) = (self.before.path_mm(), before.max_mm, after.max_mm);
        self.series.push(SeriesPoint { path_mm, line, before_mm, after_mm });
    }
}

pub(in crate::process) fn failed(line: u64, what: &'static str) -> Fault {
    Fault::VerificationFailed { line, what }
}
