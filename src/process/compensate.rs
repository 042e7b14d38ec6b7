//! Cutter-contact compensation of a whole program, streamed: read, judge, divide, write, read back.

use std::io::Write;
use std::ops::ControlFlow;
use std::rc::Rc;

use super::compensation::{LineCursor, LineMap, line_ends};
use super::emit::Emitter;
use super::inventory::Inventory;
use super::judge::{Checked, Judge, Verdict};
use super::plan::plan;
use super::stream::{Passage, Passages};
use super::survey::Survey;
use super::verify::{Expected, Group, Meaning, Note, Verifier};
use super::{CcParameters, CcReport, ContactSource, Fault, ProgramSource, WarningKind};
use crate::contact::{Correction, Node, SourceBlock};
use crate::kinematics::Kinematics;
use crate::machine::Machine;
use crate::motion::{Interpolation, InterpreterOptions, Motion, MotionKind};
use crate::program::{Batch, Dialect};

/// Compensates the cutter-contact path of a program on one machine (§2; P0).
///
/// Blocks whose contact deviates by more than the tolerance are divided and corrected; all other bytes are copied.
/// What is written is read back with its own decimals and checked against the source's lines before this function
/// returns; the report's `after` comes from that reading. Memory does not grow with the program.
///
/// `stop` is asked between batches of a few hundred blocks and before every block that is divided.
///
/// # Errors
/// Why the program is refused; `output` then holds text that must not be run and has to be thrown away.
pub fn compensate(
    machine: &Machine,
    parameters: &CcParameters,
    source: &dyn ProgramSource,
    output: &mut dyn Write,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<CcReport, Fault> {
    Ok(compensate_from(machine, parameters, source, Vec::new(), output, &mut |_| Ok(()), stop)?.0)
}

/// [`compensate`] for a program that was itself written from the upload: `lines` lead to the upload's; `note` gets what
/// became of every motion once it was read back. Beside the report the lines of blocks that came in.
///
/// # Errors
/// As [`compensate`].
pub(super) fn compensate_from(
    machine: &Machine,
    parameters: &CcParameters,
    source: &dyn ProgramSource,
    lines: Vec<LineCursor<'_>>,
    output: &mut dyn Write,
    note: Note<'_>,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<(CcReport, LineMap), Fault> {
    let survey = Survey::of(machine, parameters.dialect, source, stop)?;
    let contact = survey.contact(parameters.contact, parameters.part.is_some())?;
    let kinematics = Kinematics::new(machine, &parameters.setup);
    let options = InterpreterOptions {
        feed_mm_per_min: parameters.feed.map(crate::units::Feedrate::mm_per_min),
        interpolation_stated: parameters.interpolation.is_some(),
    };
    let mut passages = Passages::open(source, machine, parameters.dialect, options)?
        .with_setup(machine, &parameters.setup)
        .with_lines(lines);
    let mut run: Option<Run<'_>> = None;
    passages.work(stop, |passage, following, dialect| {
        let run = run.get_or_insert_with(|| {
            Run::new(machine, &kinematics, parameters, survey, contact, dialect, options)
        });
        run.passage(passage, following, output, note, stop)
    })?;
    let Some(mut run) = run.filter(|_| passages.motions > 0) else { return Err(Fault::NoMotion) };
    if run.judge.faults.total > 0 {
        return Err(Fault::Lines(run.judge.faults));
    }
    run.inventory.inserted += run.emitter.feed_blocks;
    run.inventory.join(&run.emitter.numbers);
    run.verifier.finish(&run.inventory, note)?;
    output.flush()?;
    passages.warn(&mut run.judge.warnings);
    let lines = std::mem::take(&mut run.lines);
    Ok((run.report(passages.dialect(), passages.blocks), lines))
}

/// What was written is read back and handed on when it has come to this \[bytes\], or with its batch.
const FLUSH_BYTES: usize = 1 << 18;

/// How far the ends of the parts are from where the block has them at most \[mm\].
fn correction_mm(block: &SourceBlock<'_>, nodes: &[Node]) -> f64 {
    let inner = nodes.split_last().map_or(&[][..], |(_, inner)| inner);
    let off =
        |node: &Node| (node.station.pose.tip_mm - block.pose_at(&block.whole(), node.fraction).tip_mm).norm();
    inner.iter().map(off).fold(0.0, f64::max)
}

/// The work in progress.
struct Run<'a> {
    parameters: &'a CcParameters,
    machine: &'a Machine,
    survey: Survey,
    contact: ContactSource,
    judge: Judge<'a>,
    emitter: Emitter,
    verifier: Verifier<'a>,
    out: Vec<u8>,
    checked: u64,
    over: u64,
    inventory: Inventory,
    uses_tcp: bool,
    /// Of inserted blocks, in the lines of what is read.
    lines: LineMap,
}

impl<'a> Run<'a> {
    fn new(
        machine: &'a Machine,
        kinematics: &'a Kinematics,
        parameters: &'a CcParameters,
        survey: Survey,
        contact: ContactSource,
        dialect: Dialect,
        options: InterpreterOptions,
    ) -> Self {
        Self {
            parameters,
            machine,
            survey,
            contact,
            judge: Judge::new(machine, kinematics, parameters, contact),
            emitter: Emitter::new(survey.numbering),
            verifier: Verifier::new(machine, parameters, dialect, options),
            out: Vec::new(),
            checked: 0,
            over: 0,
            inventory: Inventory::default(),
            uses_tcp: false,
            lines: LineMap::default(),
        }
    }

    /// Compensates one batch, reads it back and writes it.
    fn passage(
        &mut self,
        passage: &Passage,
        following: Option<&Motion>,
        output: &mut dyn Write,
        note: Note<'_>,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<(), Fault> {
        let Passage { batch, motions } = passage;
        self.inventory.see(batch);
        let mut copied = 0;
        self.judge.prepare(motions);
        for (index, motion) in motions.iter().enumerate() {
            let text =
                batch.blocks().get(motion.block as usize).map_or(&[][..], |block| batch.block_text(block));
            if matches!(motion.kind, MotionKind::Linear | MotionKind::Arc) {
                self.uses_tcp |= self.judge.mode(motion) == Interpolation::Tcp;
            }
            let largest = self.verifier.found.after.max_mm();
            let verdict = self.judge.judge(motions, index, following, text, largest);
            self.checked += u64::from(verdict.is_some());
            let changed = match verdict {
                Some(Verdict::Over(checked)) => {
                    self.over += 1;
                    if stop().is_break() {
                        return Err(Fault::Cancelled);
                    }
                    let changed = self.divide(batch, motion, text, checked, &mut copied)?;
                    if changed && self.out.len() > FLUSH_BYTES {
                        self.flush(output, note)?;
                    }
                    changed
                }
                verdict => {
                    let checked = match verdict {
                        Some(Verdict::Within { path_mm, before }) => Some((path_mm, before)),
                        _ => None,
                    };
                    if self.judge.faults.total == 0 {
                        self.verifier.await_next(Expected::Same { motion: Meaning::of(motion), checked });
                    }
                    self.restore_feed(batch, motion, &mut copied)?
                }
            };
            if changed {
                copied = motion.block as usize + 1;
            }
        }
        self.out.extend_from_slice(batch.blocks_text(copied, batch.blocks().len()));
        self.flush(output, note)
    }

    /// Reads back what was written so far, and hands it on. A faulty program is judged to its end, so that every
    /// fault is named, but no longer written.
    fn flush(&mut self, output: &mut dyn Write, note: Note<'_>) -> Result<(), Fault> {
        self.check_budget()?;
        if self.judge.faults.total == 0 {
            self.verifier.take(&self.out, note)?;
            output.write_all(&self.out)?;
        } else {
            self.verifier.abandon();
        }
        self.out.clear();
        Ok(())
    }

    /// Copies the blocks before this motion's, then writes its parts.
    fn divide(
        &mut self,
        batch: &Batch,
        motion: &Motion,
        text: &[u8],
        checked: Checked<'a>,
        copied: &mut usize,
    ) -> Result<bool, Fault> {
        let spent = &mut self.judge.evaluations;
        let planned = plan(self.parameters, self.machine, self.survey, &checked, motion, spent);
        let division = match planned {
            Ok(division) => division,
            Err(kind) => {
                self.judge.faults.add(motion.line, text, kind);
                return Ok(false);
            }
        };
        // The last node is the source block's own end, which was looked at already.
        for node in division.nodes.iter().rev().skip(1) {
            let station = &node.station;
            let words = self.judge.axis_words(checked.block.mode, &station.words, station.pose.tip_mm);
            for (k, (axis, word)) in ['X', 'Y', 'Z'].into_iter().zip(words).enumerate() {
                let travel = self.machine.linear_travel_mm()[k];
                self.judge.check_word(motion.line, text, axis, word, travel);
            }
        }
        if !division.carries_feed {
            self.judge.warnings.add(WarningKind::NoFeed, Some(motion.line));
        }
        self.out.extend_from_slice(batch.blocks_text(*copied, motion.block as usize));
        let written_from = self.out.len();
        self.emitter
            .write_division(batch, &checked, motion, &division, &mut self.out)
            .map_err(|fault| Fault::Unwritable { line: motion.line, fault })?;
        self.note_lines(batch, motion, written_from, line_ends(text))?;
        self.inventory.inserted += division.nodes.len() as u64 - 1;
        let correction_mm = correction_mm(&checked.block, &division.nodes);
        let group = Rc::new(Group { source: *motion, checked, division, correction_mm });
        for index in 0..group.division.nodes.len() {
            if self.judge.faults.total > 0 {
                break;
            }
            self.verifier.await_next(Expected::Part { group: Rc::clone(&group), index });
        }
        Ok(true)
    }

    /// Gives a block left alone its feed back, where divided blocks before it took it.
    fn restore_feed(&mut self, batch: &Batch, motion: &Motion, copied: &mut usize) -> Result<bool, Fault> {
        if !self.emitter.owes_feed() {
            return Ok(false);
        }
        self.out.extend_from_slice(batch.blocks_text(*copied, motion.block as usize));
        *copied = motion.block as usize;
        let (blocks, written_from) = (self.emitter.feed_blocks, self.out.len());
        let changed = self
            .emitter
            .restore_feed(batch, motion, &mut self.out)
            .map_err(|fault| Fault::Unwritable { line: motion.line, fault })?;
        if self.emitter.feed_blocks > blocks {
            self.note_lines(batch, motion, written_from, 0)?;
        }
        Ok(changed)
    }

    /// Lines written since `written_from` for this motion, of which the source has `own`; where it has none they stand
    /// before its block.
    fn note_lines(
        &mut self,
        batch: &Batch,
        motion: &Motion,
        written_from: usize,
        own: u64,
    ) -> Result<(), Fault> {
        let line = batch.blocks().get(motion.block as usize).map_or(motion.line, |block| block.line);
        let written = line_ends(self.out.get(written_from..).unwrap_or_default());
        self.lines.insert(line.saturating_sub(u64::from(own == 0)), written.saturating_sub(own))
    }

    fn check_budget(&self) -> Result<(), Fault> {
        let budget = &self.parameters.budget;
        if self.judge.evaluations + self.verifier.evaluations > budget.max_evaluations {
            return Err(Fault::TooCostly {
                what: "evaluations of the deviation",
                limit: budget.max_evaluations,
            });
        }
        if self.inventory.blocks + self.inventory.inserted > budget.max_blocks_out {
            return Err(Fault::TooCostly { what: "blocks written", limit: budget.max_blocks_out });
        }
        Ok(())
    }

    fn report(mut self, dialect: Dialect, blocks_in: u64) -> CcReport {
        let warnings = &mut self.judge.warnings;
        if self.checked == 0 {
            warnings.add(WarningKind::NothingChecked, None);
        } else if self.contact == ContactSource::FeedPlane {
            warnings.add(WarningKind::ContactAssumed, None).count = self.checked;
        }
        let after = self.verifier.found.after.summary();
        if self.parameters.correction == Correction::Seed && after.max_mm > self.parameters.tolerance.mm() {
            warnings.add_distance(
                WarningKind::ToleranceNotReached,
                after.worst_line.unwrap_or_default(),
                after.max_mm,
            );
        }
        let interpolation = if self.uses_tcp { Interpolation::Tcp } else { Interpolation::Machine };
        CcReport {
            dialect,
            interpolation,
            contact: self.contact,
            blocks_in,
            blocks_out: self.verifier.blocks(),
            motions_checked: self.checked,
            motions_over_tolerance: self.over,
            feeds_restored: self.emitter.feeds_restored,
            before: self.verifier.found.before.summary(),
            after,
            cc_path_length_mm: self.verifier.found.before.path_mm(),
            series: self.verifier.found.series,
            warnings: self.judge.warnings.into_list(),
        }
    }
}
