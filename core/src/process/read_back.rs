//! The bytes that leave, read back as a control would read them, beside what was meant.
//!
//! Reader and interpreter here know nothing of the writer.

use std::collections::VecDeque;

use super::inventory::Inventory;
use super::report::DeviationTotals;
use super::tool_vectors::ToolVectors;
use super::{Fault, Series, SeriesPoint};
use crate::contact::Sampled;
use crate::kinematics::Setup;
use crate::machine::Machine;
use crate::motion::{Interpreter, InterpreterOptions, Motion};
use crate::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader, Severity};

/// What the next motion of the written program has to be.
pub(super) trait Awaited {
    /// The source's line that it comes from.
    fn line(&self) -> u64;
    /// What is said where it never comes.
    fn missing(&self) -> &'static str;
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
    expected: VecDeque<E>,
    pub(super) inventory: Inventory,
}

impl<E: Awaited> ReadBack<E> {
    pub(super) fn new(machine: &Machine, dialect: Dialect, options: InterpreterOptions) -> Self {
        Self {
            reader: Reader::new(Some(dialect), ReadLimits::default()),
            interpreter: Interpreter::new(machine, options),
            vectors: ToolVectors::new(machine, &Setup::default()),
            batch: Batch::new(),
            motions: Vec::new(),
            seen: 0,
            diagnostics: Diagnostics::new(),
            expected: VecDeque::new(),
            inventory: Inventory::default(),
        }
    }

    /// Tool vectors are those of the machine set up like this.
    pub(super) fn with_setup(mut self, machine: &Machine, setup: &Setup) -> Self {
        self.vectors = ToolVectors::new(machine, setup);
        self
    }

    /// What has to come next, in the order written.
    pub(super) fn await_next(&mut self, next: E) {
        self.expected.push_back(next);
    }

    /// Forgets what was to come: the program is refused.
    pub(super) fn abandon(&mut self) {
        self.expected.clear();
    }

    /// These bytes of the output were written.
    pub(super) fn feed(&mut self, bytes: &[u8]) {
        self.reader.feed(bytes);
    }

    /// Nothing more is written.
    pub(super) fn end(&mut self) {
        self.reader.finish();
    }

    /// Takes over what has to come next, in the order written; leaves the queue empty.
    pub(super) fn await_all(&mut self, next: &mut VecDeque<E>) {
        if self.expected.is_empty() {
            std::mem::swap(&mut self.expected, next);
        } else {
            self.expected.append(next);
        }
    }

    /// The next motion that can be read, with what it has to be.
    pub(super) fn next(&mut self) -> Result<Option<(Motion, E)>, Fault> {
        if !self.advance()? {
            return Ok(None);
        }
        let motion = self.pair().map(|(motion, _)| *motion);
        Ok(motion.zip(self.expected.pop_front()))
    }

    /// The motion that was read last, with what it has to be.
    pub(super) fn pair(&self) -> Option<(&Motion, &E)> {
        self.motions.get(self.seen.checked_sub(1)?).zip(self.expected.front())
    }

    /// The pair looked at is done with.
    pub(super) fn drop_pair(&mut self) {
        self.expected.pop_front();
    }

    /// Reads on to the next motion; false where it is not there yet.
    pub(super) fn advance(&mut self) -> Result<bool, Fault> {
        while self.seen == self.motions.len() {
            if !self.reader.next_batch(&mut self.batch)? {
                return Ok(false);
            }
            self.motions.clear();
            self.seen = 0;
            // Which words are a tool axis is known then.
            self.interpreter.interpret(&mut self.batch, &mut self.motions, &mut self.diagnostics);
            self.vectors.resolve(&mut self.motions);
            self.inventory.see(&self.batch);
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
