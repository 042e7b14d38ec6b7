//! Writes a program with its contact path repaired: judges motions and divides those whose contact deviates too far.

use std::sync::Arc;

use super::check::{ExpectedMotion, PathCheck, SourceMotion};
use super::judge::{Judge, Verdict};
use super::parameters::CcParameters;
use super::plan::{DivisionPlan, plan};
use super::report::CcReport;
use crate::contact::{BlockTime, Correction, Effort, Node, Sampled, SourceBlock, block_time_s, segments};
use crate::machine::Machine;
use crate::motion::{Interpolation, Motion, MotionKind};
use crate::process::divided::{Checked, DividedBlock, Division, write_division};
use crate::process::fault::{Fault, WarningKind, Warnings, go_on};
use crate::process::pipeline::{Outgoing, Placed, Rewriter, StepWork, Surveyed};
use crate::process::set_up::{ContactSource, Travels};
use crate::process::text::{DialectFit, Inventory, LineMap, Passage, Passages, Stretch, Survey};
use crate::program::{Dialect, StepName, Steps};

/// The written text is handed over for reading back when it reaches this size \[bytes\], or when its stretch ends.
const HAND_OVER_BYTES: usize = 4 << 20;

/// The largest distance between the end of a part and the same point of the source block \[mm\].
fn correction_mm(block: &SourceBlock<'_>, nodes: &[Node]) -> f64 {
    let inner = nodes.split_last().map_or(&[][..], |(_, inner)| inner);
    let off =
        |node: &Node| (node.station.pose.tip_mm - block.pose_at(&block.whole(), node.fraction).tip_mm).norm();
    inner.iter().map(off).fold(0.0, f64::max)
}

/// The fate of a motion's block.
enum Kept {
    /// It is copied. Holds path length and deviation if the motion was checked.
    As(Option<(f64, Sampled)>),
    /// It was rewritten.
    No,
    /// It has a fault, so the program is refused.
    Faulty,
}

/// The place that the work has reached in a stretch.
#[derive(Debug, Clone, Copy, Default)]
struct Reached {
    passage: usize,
    motion: usize,
    /// Whether the passage was begun.
    is_begun: bool,
}

/// The work in progress.
pub(super) struct PathWork<'a> {
    parameters: &'a CcParameters,
    machine: &'a Machine,
    survey: Survey,
    contact: ContactSource,
    judge: Judge<'a>,
    rewriter: Rewriter,
    at: Reached,
    /// The largest deviation found in the written text so far \[mm\].
    largest_after_mm: f64,
    checked: u64,
    over: u64,
    divided: u64,
    fit: DialectFit,
    /// Source blocks read so far.
    counted: u64,
    uses_tcp: bool,
}

impl<'a> StepWork for PathWork<'a> {
    type Expected = ExpectedMotion<'a>;
    type Checker = PathCheck<'a>;

    fn write(&mut self, stretch: &Stretch, out: &mut Outgoing<ExpectedMotion<'a>>) -> Result<bool, Fault> {
        while let Some(passage) = stretch.passages.get(self.at.passage) {
            if !self.at.is_begun {
                self.rewriter.begin(passage, out)?;
                self.at.is_begun = true;
            }
            if !self.passage((self.at.passage, passage), stretch.following(self.at.passage), out)? {
                return Ok(false);
            }
            self.at = Reached { passage: self.at.passage + 1, ..Reached::default() };
            if self.has_faults() {
                out.clear();
            }
        }
        self.at = Reached::default();
        Ok(true)
    }

    fn hear(&mut self, check: &PathCheck<'a>, read: &Inventory) -> Result<(), Fault> {
        self.largest_after_mm = check.milestones.largest_mm;
        self.counted = read.blocks;
        self.check_budget(check.effort.evaluations())
    }

    fn has_faults(&self) -> bool {
        self.judge.faults.total > 0
    }

    fn refuse(&mut self, surveyed: &Surveyed<'_>, _passages: &Passages<'_>) -> Result<(), Fault> {
        if self.has_faults() {
            return Err(Fault::Lines(std::mem::take(&mut self.judge.faults)));
        }
        if self.fit.is_unread(self.parameters.program.dialect, surveyed.source)? {
            return Err(Fault::NothingFollowed { first: self.judge.warnings.first_left() });
        }
        Ok(())
    }

    fn warnings(&mut self) -> &mut Warnings {
        &mut self.judge.warnings
    }

    fn rewriter(&self) -> &Rewriter {
        &self.rewriter
    }
}

impl<'a> PathWork<'a> {
    pub(super) fn new(
        machine: &'a Machine,
        parameters: &'a CcParameters,
        dialect: Dialect,
        surveyed: &Surveyed<'_>,
        effort: Effort<'a>,
    ) -> Self {
        let Surveyed { survey, contact, .. } = *surveyed;
        Self {
            parameters,
            machine,
            survey,
            contact,
            judge: Judge::new(machine, parameters, dialect, contact, effort),
            rewriter: Rewriter::new(survey.numbering),
            at: Reached::default(),
            largest_after_mm: 0.0,
            checked: 0,
            over: 0,
            divided: 0,
            fit: DialectFit::default(),
            counted: 0,
            uses_tcp: false,
        }
    }

    /// Continues with a batch. Returns true at its end, false if enough text is written.
    fn passage(
        &mut self,
        passage: Placed<'_>,
        following: Option<&Motion>,
        out: &mut Outgoing<ExpectedMotion<'a>>,
    ) -> Result<bool, Fault> {
        let Passage { batch, motions, .. } = passage.1;
        while let Some(motion) = motions.get(self.at.motion) {
            // Motions in a tilted plane say nothing of the words outside it.
            if matches!(motion.kind, MotionKind::Linear | MotionKind::Arc) && motion.frame.is_none() {
                self.uses_tcp |= self.judge.mode(motion) == Interpolation::Tcp;
            }
            let glanced = self.judge.glance(passage.1, self.at.motion, self.largest_after_mm);
            self.judge.effort.pass(1);
            go_on(&self.judge.effort)?;
            self.at.motion += 1;
            self.fit.see(batch, motion);
            let kept = match glanced {
                Some(within) => {
                    self.checked += 1;
                    Kept::As(Some(within))
                }
                None => self.look_closely(passage, self.at.motion - 1, following, out)?,
            };
            let changed = match kept {
                Kept::No => true,
                Kept::Faulty => false,
                Kept::As(checked) => {
                    if !self.has_faults() {
                        let (passage, line) = (passage.0, motion.line);
                        let motion = SourceMotion::At { passage, motion: self.at.motion - 1, line };
                        out.expected.push_back(ExpectedMotion::Same { motion, checked });
                    }
                    self.rewriter.leave(passage, motion, out)?
                }
            };
            if changed && out.text.len() > HAND_OVER_BYTES {
                return Ok(false);
            }
        }
        self.judge.catch_up(passage.1, motions.len().saturating_sub(1));
        self.rewriter.end(passage, out);
        Ok(true)
    }

    /// Judges the motion of this index, and divides its block if its contact deviates too far.
    fn look_closely(
        &mut self,
        passage: Placed<'_>,
        index: usize,
        following: Option<&Motion>,
        out: &mut Outgoing<ExpectedMotion<'a>>,
    ) -> Result<Kept, Fault> {
        let Passage { batch, motions, .. } = passage.1;
        let motion = &motions[index];
        let block = batch.blocks().get(motion.block as usize);
        let text = block.map_or(&[][..], |block| batch.block_text(block));
        let verdict = self.judge.judge(passage.1, index, following, text, self.largest_after_mm);
        go_on(&self.judge.effort)?;
        self.checked += u64::from(verdict.is_some());
        Ok(match verdict {
            Some(Verdict::Over(checked)) => {
                self.over += 1;
                self.divide(passage, motion, text, checked, out)?
            }
            Some(Verdict::Within { path_mm, before }) => Kept::As(Some((path_mm, before))),
            None => Kept::As(None),
        })
    }

    /// Copies the blocks before this motion's block, then writes its parts, unless the parts would run too fast.
    fn divide(
        &mut self,
        passage: Placed<'_>,
        motion: &Motion,
        text: &[u8],
        checked: Checked<'a>,
        out: &mut Outgoing<ExpectedMotion<'a>>,
    ) -> Result<Kept, Fault> {
        let batch = &passage.1.batch;
        let finder = *self.judge.finder();
        let effort = &mut self.judge.effort;
        let planned = plan(&finder, self.machine, self.survey, &checked, motion, effort);
        go_on(&self.judge.effort)?;
        let division = match planned {
            Ok(DivisionPlan::Divide(division)) => division,
            Ok(stays @ (DivisionPlan::TooFast | DivisionPlan::Unsettled)) => {
                let Checked { block, before, .. } = &checked;
                let why = match stays {
                    DivisionPlan::Unsettled => WarningKind::ContactUnsettled,
                    _ => WarningKind::FeedTooHigh,
                };
                self.judge.warnings.add_distance(why, motion.line, before.max_mm);
                return Ok(Kept::As(Some((block.line.length_mm, *before))));
            }
            Err(kind) => {
                self.judge.faults.add(motion.line, text, kind);
                return Ok(Kept::Faulty);
            }
        };
        // The last node is the end of the source block, which was already checked.
        for node in division.nodes.iter().rev().skip(1) {
            // The judge has warned already, if the travels of this motion cannot be checked.
            let (Travels::Checked | Travels::NotChecked) =
                self.judge.check_words(motion, &node.station.words, text);
        }
        if !division.carries_feed {
            self.judge.warnings.add(WarningKind::NoFeed, Some(motion.line));
        }
        self.warn_of_times(motion, &checked, &division);
        let effort = &mut self.judge.effort;
        self.rewriter.anew(passage, motion, out, |emitter, text| {
            write_division(emitter, batch, &checked, motion, &division, effort, text)
        })?;
        go_on(&self.judge.effort)?;
        self.rewriter.count_inserted(division.nodes.len() as u64 - 1);
        self.divided += 1;
        let correction_mm = correction_mm(&checked.block, &division.nodes);
        let group = Arc::new(DividedBlock { source: *motion, checked, division, correction_mm });
        if !self.has_faults() {
            let parts = 0..group.division.nodes.len();
            out.expected.extend(parts.map(|index| ExpectedMotion::Part { group: Arc::clone(&group), index }));
        }
        Ok(Kept::No)
    }

    /// Warns if the machine stops after every part, and if a part is shorter than the control needs for a block.
    fn warn_of_times(&mut self, motion: &Motion, checked: &Checked<'_>, division: &Division) {
        let warnings = &mut self.judge.warnings;
        if motion.exact_stop {
            warnings.add(WarningKind::ExactStop, Some(motion.line));
        }
        let (Some(shortest_s), Some(mode)) = (self.parameters.block_time_s, motion.feed.mode) else { return };
        let block = &checked.block;
        let time = BlockTime::of(block, &block.whole(), motion.mm_per_unit, motion.feed.paths);
        let Some(whole_s) = motion.feed.value.and_then(|_| block_time_s(mode, motion.feed.raw, &time)) else {
            return;
        };
        for segment in segments(block, &division.nodes) {
            let part_s = whole_s * (segment.fraction[1] - segment.fraction[0]);
            if part_s < shortest_s {
                warnings.add_time(WarningKind::ShortBlocks, motion.line, part_s);
            }
        }
    }

    /// Refuses the program if judging plus `verifying` evaluations exceed the budget, or if too many blocks are
    /// written.
    fn check_budget(&self, verifying: u64) -> Result<(), Fault> {
        let evaluations = self.judge.effort.evaluations() + verifying;
        self.parameters.budget.check(evaluations, self.counted + self.rewriter.inserted())
    }

    /// The report, and the map of inserted lines.
    pub(super) fn report(mut self, check: PathCheck<'_>, passages: &Passages<'_>) -> (CcReport, LineMap) {
        let warnings = &mut self.judge.warnings;
        if self.checked == 0 {
            warnings.add(WarningKind::NothingChecked, None);
        }
        if self.contact == ContactSource::Tip && self.parameters.contact == ContactSource::Auto {
            warnings.add(WarningKind::ContactUnknown, None).count = self.checked;
        }
        if self.judge.assumed > 0 {
            warnings.add(WarningKind::ContactAssumed, None).count = self.judge.assumed;
        }
        let after = check.found.after.summary();
        if self.parameters.correction == Correction::Seed && after.max_mm > self.parameters.tolerance.mm() {
            warnings.add_distance(
                WarningKind::ToleranceNotReached,
                after.worst_line.unwrap_or_default(),
                after.max_mm,
            );
        }
        let interpolation = if self.uses_tcp { Interpolation::Tcp } else { Interpolation::Machine };
        let report = CcReport {
            dialect: passages.dialect(),
            interpolation,
            contact: self.contact,
            steps: if self.divided > 0 { Steps::of(&[StepName::Cc]) } else { Steps::NONE },
            reading: passages.reading(),
            blocks_in: passages.blocks,
            blocks_out: check.blocks(),
            motions_checked: self.checked,
            motions_over_tolerance: self.over,
            motions_left_over: self.over - self.divided,
            feeds_restored: self.rewriter.feeds_restored(),
            before: check.found.before.summary(),
            after,
            cc_path_length_mm: check.found.before.path_mm(),
            series: check.found.series,
            warnings: self.judge.warnings.into_list(),
        };
        (report, self.rewriter.into_lines())
    }
}
