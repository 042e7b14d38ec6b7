//! The written program read back as a control would read it, block by block against the source.
//!
//! The reader and interpreter here know nothing of the writer: they are fed the bytes that leave. Every block that
//! was left alone must mean what it meant; every part of a divided block must be where it was planned, and is sampled
//! against the source block's line from the words that were read.

use std::collections::VecDeque;
use std::rc::Rc;

use super::emit::Division;
use super::judge::Checked;
use super::report::DeviationTotals;
use super::{CcParameters, Fault, Series, SeriesPoint};
use crate::contact::{
    BlockTime, Correction, Sampled, Segment, Station, block_time_s, sample_until_sure, within_tolerance,
};
use crate::machine::Machine;
use crate::motion::{
    AxisWords, FeedMode, Interpolation, Interpreter, InterpreterOptions, Motion, MotionKind, Unfollowable,
};
use crate::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader, Severity};

/// Words read back may differ by this from those meant: inches and increments pass through binary fractions
/// [mm or deg].
const SAME_POSITION: f64 = 1e-7;
/// The time of a divided block may differ by this share: F words are rounded.
const SAME_TIME: f64 = 0.01;

/// A part is measured where a proof found at least this share of the largest deviation so far.
const NEAR_LARGEST: f64 = 0.9;

/// What the next motion of the written program has to be.
#[derive(Debug)]
pub(super) enum Expected<'a> {
    /// A block left as it was.
    Same {
        motion: Meaning,
        /// Contact path length and deviation, if it was checked.
        checked: Option<(f64, Sampled)>,
    },
    /// Part of a divided block.
    Part { group: Rc<Group<'a>>, index: usize },
}

/// What of a motion must not change in a block that is left alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Meaning {
    line: u64,
    kind: MotionKind,
    interpolation: Interpolation,
    unfollowable: Option<Unfollowable>,
    offset_changed: bool,
    feed_mode: Option<FeedMode>,
    feed: Option<f64>,
    start: Option<AxisWords>,
    end: Option<AxisWords>,
}

impl Meaning {
    pub(super) fn of(motion: &Motion) -> Self {
        Self {
            line: motion.line,
            kind: motion.kind,
            interpolation: motion.interpolation,
            unfollowable: motion.unfollowable,
            offset_changed: motion.offset_changed,
            feed_mode: motion.feed.mode,
            feed: motion.feed.value.map(|_| motion.feed.raw),
            start: motion.start,
            end: motion.end,
        }
    }
}

/// A divided block with its plan.
#[derive(Debug)]
pub(super) struct Group<'a> {
    pub(super) source: Motion,
    pub(super) checked: Checked<'a>,
    pub(super) division: Division,
}

/// Reads the output back and sums up what it leaves.
pub(super) struct Verifier<'a> {
    machine: &'a Machine,
    parameters: &'a CcParameters,
    reader: Reader,
    interpreter: Interpreter,
    batch: Batch,
    motions: Vec<Motion>,
    diagnostics: Diagnostics,
    expected: VecDeque<Expected<'a>>,
    parts: Vec<(f64, Sampled)>,
    time_s: f64,
    pub(super) before: DeviationTotals,
    pub(super) after: DeviationTotals,
    pub(super) series: Series,
    pub(super) blocks: u64,
    pub(super) evaluations: u64,
}

impl<'a> Verifier<'a> {
    pub(super) fn new(
        machine: &'a Machine,
        parameters: &'a CcParameters,
        dialect: Dialect,
        options: InterpreterOptions,
    ) -> Self {
        Self {
            machine,
            parameters,
            reader: Reader::new(Some(dialect), ReadLimits::default()),
            interpreter: Interpreter::new(machine, options),
            batch: Batch::new(),
            motions: Vec::new(),
            diagnostics: Diagnostics::new(),
            expected: VecDeque::new(),
            parts: Vec::new(),
            time_s: 0.0,
            before: DeviationTotals::default(),
            after: DeviationTotals::default(),
            series: Series::default(),
            blocks: 0,
            evaluations: 0,
        }
    }

    /// What has to come next, in the order written.
    pub(super) fn await_next(&mut self, next: Expected<'a>) {
        self.expected.push_back(next);
    }

    /// Reads these bytes of the output.
    pub(super) fn take(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        self.reader.feed(bytes);
        self.read()
    }

    /// The output has ended: everything expected must have come.
    pub(super) fn finish(&mut self) -> Result<(), Fault> {
        self.reader.finish();
        self.read()?;
        if let Some(Expected::Same { motion, .. }) = self.expected.front() {
            return Err(failed(motion.line, "a motion is missing"));
        }
        if let Some(Expected::Part { group, .. }) = self.expected.front() {
            return Err(failed(group.source.line, "a part of a divided block is missing"));
        }
        Ok(())
    }

    fn read(&mut self) -> Result<(), Fault> {
        while self.reader.next_batch(&mut self.batch)? {
            self.blocks += self.batch.blocks().iter().filter(|block| block.counts()).count() as u64;
            self.motions.clear();
            self.interpreter.interpret(&self.batch, &mut self.motions, &mut self.diagnostics);
            if self.diagnostics.count(Severity::Refusal) > 0 {
                let line = self.expected.front().map_or(0, |next| match next {
                    Expected::Same { motion, .. } => motion.line,
                    Expected::Part { group, .. } => group.source.line,
                });
                return Err(failed(line, "the written program is not readable"));
            }
            for index in 0..self.motions.len() {
                let motion = self.motions[index];
                let next = self.expected.pop_front().ok_or(failed(motion.line, "a motion too many"))?;
                match next {
                    Expected::Same { motion: source, checked } => self.same(&motion, &source, checked)?,
                    Expected::Part { group, index } => self.part(&motion, &group, index)?,
                }
            }
        }
        Ok(())
    }

    fn same(
        &mut self,
        read: &Motion,
        source: &Meaning,
        checked: Option<(f64, Sampled)>,
    ) -> Result<(), Fault> {
        let (line, read) = (source.line, Meaning::of(read));
        if !same_words(read.start, source.start) || !same_words(read.end, source.end) {
            return Err(failed(line, "a block left alone starts or ends elsewhere"));
        }
        // A rapid has no feed of its own; the modal one is given back by the next block that uses it.
        let feed = if source.kind == MotionKind::Rapid { source.feed } else { read.feed };
        let (start, end) = (source.start, source.end);
        if (Meaning { line, start, end, feed, ..read }) != *source {
            return Err(failed(line, "a block left alone changed its meaning or its feed"));
        }
        if let Some((path_mm, found)) = checked {
            self.record(line, path_mm, &found, &found);
        }
        Ok(())
    }

    fn part(&mut self, read: &Motion, group: &Group<'a>, index: usize) -> Result<(), Fault> {
        let line = group.source.line;
        let node = group.division.nodes.get(index).ok_or(failed(line, "a part too many"))?;
        let block = &group.checked.block;
        let mode = self.parameters.interpolation.unwrap_or(read.interpolation);
        let (Some(start), Some(end)) = (read.start, read.end) else {
            return Err(failed(line, "a part of a divided block has no known end"));
        };
        let planned_start = match index.checked_sub(1) {
            None => block.ends[0].words,
            Some(before) => group.division.nodes[before].station.words,
        };
        if read.kind != MotionKind::Linear || read.unfollowable.is_some() || mode != block.mode {
            return Err(failed(line, "a part of a divided block is no straight motion"));
        }
        if !same_words(Some(start), Some(planned_start)) || !same_words(Some(end), Some(node.station.words)) {
            return Err(failed(line, "a part of a divided block starts or ends elsewhere"));
        }
        let from = index.checked_sub(1).map_or(0.0, |before| group.division.nodes[before].fraction);
        let ends = [start, end].map(|words| Station::new(self.machine, block.kinematics, mode, words));
        let segment = Segment { ends, fraction: [from, node.fraction] };
        let tolerance_mm = self.parameters.tolerance.mm();
        let found = if self.parameters.correction == Correction::Seed {
            sample_until_sure(block, &segment, tolerance_mm)
        } else {
            within_tolerance(block, &segment, tolerance_mm)
                .or_else(|found| {
                    // Words that differ in the last bit may tip a block that was just inside.
                    let slack = 1.0 + 1e-9;
                    if found.max_mm <= tolerance_mm * slack { Ok(found) } else { Err(found) }
                })
                .map_err(|_found| failed(line, "a part of a divided block exceeds the tolerance"))?
        };
        self.evaluations += found.evaluations;
        // What may become the largest deviation of the report is measured, not only bounded.
        let found = if found.max_mm > NEAR_LARGEST * self.after.max_mm() {
            let measured = sample_until_sure(block, &segment, tolerance_mm);
            self.evaluations += measured.evaluations;
            Sampled { max_mm: measured.max_mm.min(tolerance_mm.max(found.max_mm)), ..measured }
        } else {
            found
        };
        self.parts.push((node.fraction - from, found));
        self.time(read, group, &segment, index)?;
        if index + 1 == group.division.nodes.len() {
            let after = Sampled::join(self.parts.drain(..));
            self.record(line, block.line.length_mm, &group.checked.before, &after);
        }
        Ok(())
    }

    /// The parts together must take the source block's time.
    fn time(
        &mut self,
        read: &Motion,
        group: &Group<'a>,
        segment: &Segment,
        index: usize,
    ) -> Result<(), Fault> {
        let (line, block) = (group.source.line, &group.checked.block);
        let (Some(mode), Some(_)) = (group.source.feed.mode, group.source.feed.value) else { return Ok(()) };
        if mode == FeedMode::PerRevolution || (read.feed.value.is_none() && group.source.feed.value.is_some())
        {
            return Ok(());
        }
        let unit = group.source.mm_per_unit;
        let part = block_time_s(mode, read.feed.raw, &BlockTime::of(block, segment, unit));
        let whole = block_time_s(mode, group.source.feed.raw, &BlockTime::of(block, &block.whole(), unit));
        if index == 0 {
            self.time_s = 0.0;
        }
        self.time_s += part.unwrap_or(0.0);
        let Some(whole) = whole else { return Ok(()) };
        if index + 1 == group.division.nodes.len() && (self.time_s - whole).abs() > SAME_TIME * whole {
            return Err(failed(line, "the parts of a divided block take another time"));
        }
        Ok(())
    }

    fn record(&mut self, line: u64, path_mm: f64, before: &Sampled, after: &Sampled) {
        self.before.add(line, path_mm, before);
        self.after.add(line, path_mm, after);
        let point = SeriesPoint {
            path_mm: self.before.path_mm(),
            line,
            before_mm: before.max_mm,
            after_mm: after.max_mm,
        };
        self.series.push(point);
    }
}

fn failed(line: u64, what: &'static str) -> Fault {
    Fault::VerificationFailed { line, what }
}

fn same_words(a: Option<AxisWords>, b: Option<AxisWords>) -> bool {
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= SAME_POSITION);
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => near(&a.linear_mm, &b.linear_mm) && near(&a.rotary_deg, &b.rotary_deg),
        _ => false,
    }
}
