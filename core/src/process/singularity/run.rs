//! The course of the treatment, streamed: read, collect regions, plan, write, read back.

use std::collections::VecDeque;
use std::io::Write;
use std::sync::Arc;

use super::contact::Cutting;
use super::measured::{Measured, as_uploaded, measured};
use super::pending::{Collector, Pending, Seen};
use super::plan::{Course, Moved, Planner};
use super::regions::RegionNumber;
use super::report::{RegionFigures, RegionTreatment, SingularRegion, SingularityReport};
use super::verify::{Expected, SingularityVerifier};
use super::{LeftReason, SingularityAction, SingularityParameters};
use crate::contact::Effort;
use crate::geometry::trig;
use crate::machine::Machine;
use crate::motion::Motion;
use crate::process::compensate::Upstream;
use crate::process::compensation::{LineMap, line_ends};
use crate::process::emit::Emitter;
use crate::process::fault::go_on;
use crate::process::inventory::Inventory;
use crate::process::stream::{Passage, Passages};
use crate::process::survey::Survey;
use crate::process::verify::{Group, Meaning};
use crate::process::warnings::Warnings;
use crate::process::{CcParameters, ContactSource, Fault, ProgramSource, Stop};
use crate::program::{Batch, Dialect, Step, Steps, print_changed};
use crate::units::Angle;

/// So many batches wait for the end of a region at most; then it ends there.
const MAX_HELD: usize = 64;

/// Finds the singular regions of a program and treats them: reports, divides or smooths (§1 "Conditioning", "Pole").
///
/// Tool, contact, tolerance, set-up, dialect and budget are those of `cc`; contacts that a rule would assume from the feed count
/// for nothing here, the tip stands for them. Blocks outside the regions are copied byte for byte, and so are those
/// whose words need not change. What is written is read back with its own decimals before this function returns; the
/// report's `after` comes from that reading. Memory does not grow with the program. To be run before a compensation
/// of the contact's path, which then takes the written program for its source.
///
/// # Errors
/// Why the program is refused; `output` then holds text that must not be run and has to be thrown away.
pub fn treat_singular_regions(
    machine: &Machine,
    cc: &CcParameters,
    singularity: &SingularityParameters,
    source: &dyn ProgramSource,
    output: &mut dyn Write,
    stop: &Stop<'_>,
) -> Result<SingularityReport, Fault> {
    let source = Upstream { source, lines: Vec::new() };
    Ok(treat_from(machine, cc, singularity, source, output, stop)?.0)
}

/// [`treat_singular_regions`] for a program that was itself written from the upload. Beside the report the lines of
/// blocks that came in.
///
/// # Errors
/// As [`treat_singular_regions`].
pub(in crate::process) fn treat_from(
    machine: &Machine,
    cc: &CcParameters,
    singularity: &SingularityParameters,
    Upstream { source, lines }: Upstream<'_>,
    output: &mut dyn Write,
    stop: &Stop<'_>,
) -> Result<(SingularityReport, LineMap), Fault> {
    let survey = Survey::of(machine, cc.program.dialect, source, stop)?;
    if singularity.action != SingularityAction::Report {
        survey.refuse_repeated(Steps::of(&[Step::Singularity]), cc.program.allow_repeated)?;
    }
    let contact = survey.contact(cc.contact, cc.part.is_some())?;
    // Contacts that a rule would assume count for nothing here.
    let counts = if contact == ContactSource::FeedPlane { ContactSource::Tip } else { contact };
    let cc = &cc.with_tools(counts, &survey.tools, machine, source, stop)?;
    let planner = Planner { cutting: Cutting::of(machine, cc, contact), survey, singularity: *singularity };
    let mut passages = Passages::open(source, machine, &cc.program)?.with_lines(lines);
    let mut run: Option<Run<'_>> = None;
    passages.work(stop, |passage, _, dialect| {
        let run = run.get_or_insert_with(|| Run::new(planner.clone(), dialect, stop));
        run.passage(passage, output, stop)
    })?;
    let Some(mut run) = run.filter(|_| passages.motions > 0) else { return Err(Fault::NoMotion) };
    if run.collector.faults.total > 0 {
        return Err(Fault::Lines(run.collector.faults));
    }
    run.close(stop)?;
    run.write_held(output)?;
    run.inventory.inserted += run.emitter.feed_blocks;
    run.inventory.join(&run.emitter.numbers);
    run.verifier.finish(&run.inventory)?;
    output.flush()?;
    let mut warnings = Warnings::default();
    passages.warn(&mut warnings);
    let lines = std::mem::take(&mut run.lines);
    let report = run.report(passages.dialect(), passages.blocks);
    Ok((SingularityReport { warnings: warnings.into_list(), ..report }, lines))
}

/// What becomes of a motion that is held back.
#[derive(Debug, Default)]
struct Fate<'a> {
    course: Course<'a>,
    /// The region it stands in, and its figures as uploaded.
    inside: Option<(RegionNumber, RegionFigures)>,
}

/// The work in progress.
struct Run<'a> {
    planner: Planner<'a>,
    collector: Collector<'a>,
    emitter: Emitter,
    verifier: SingularityVerifier<'a>,
    inventory: Inventory,
    /// Batches that wait for the end of a region.
    held: VecDeque<Passage>,
    /// The fates of their motions and of those at hand.
    fates: VecDeque<Fate<'a>>,
    /// Number of the motion of the first fate, and of the next motion to come.
    first: u64,
    next: u64,
    out: Vec<u8>,
    effort: Effort<'a>,
    blocks_changed: u64,
    blocks_inserted: u64,
    /// Of inserted blocks, in the lines of what is read.
    lines: LineMap,
}

impl<'a> Run<'a> {
    fn new(planner: Planner<'a>, dialect: Dialect, stop: &'a Stop<'a>) -> Self {
        let cutting = planner.cutting.clone();
        let (sine, _) = trig::sin_cos(planner.singularity.zone.rad());
        let effort = || cutting.parameters.budget.effort(stop);
        let zone = cutting.kinematics.singular_zone(sine);
        Self {
            emitter: Emitter::new(planner.survey.numbering),
            verifier: SingularityVerifier::new(cutting.machine, planner.clone(), dialect, effort()),
            planner,
            collector: Collector::new(cutting.clone(), zone, dialect),
            inventory: Inventory::default(),
            held: VecDeque::new(),
            fates: VecDeque::new(),
            first: 0,
            next: 0,
            out: Vec::new(),
            effort: effort(),
            blocks_changed: 0,
            blocks_inserted: 0,
            lines: LineMap::default(),
        }
    }

    /// Looks at one batch; writes it unless a region goes on behind it.
    fn passage(&mut self, passage: &Passage, output: &mut dyn Write, stop: &Stop<'_>) -> Result<(), Fault> {
        self.inventory.see(&passage.batch);
        for motion in &passage.motions {
            self.fates.push_back(Fate::default());
            let index = self.next;
            self.next += 1;
            if self.collector.see(&passage.batch, motion, index) == Seen::Closes && self.collector.is_open() {
                self.close(stop)?;
                self.collector.see(&passage.batch, motion, index);
            }
            if self.collector.is_full() {
                self.close(stop)?;
            }
        }
        if self.collector.is_open() && self.held.len() < MAX_HELD {
            self.held.push_back(Passage {
                batch: passage.batch.clone(),
                motions: passage.motions.clone(),
                ..Passage::default()
            });
            return Ok(());
        }
        self.close(stop)?;
        self.write_held(output)?;
        self.write(passage, output)
    }

    /// Plans the region at hand.
    fn close(&mut self, stop: &Stop<'_>) -> Result<(), Fault> {
        let region = self.collector.take();
        let (Some(first), Some(last)) = (region.first(), region.last()) else { return Ok(()) };
        if stop().is_break() {
            return Err(Fault::Cancelled);
        }
        let planner = self.planner.on(first);
        let Some(Measured { each, before, nearest }) = measured(&planner, &region, &mut self.effort)? else {
            return Ok(());
        };
        self.check_budget()?;
        let mut courses: Vec<Course<'a>> = region.iter().map(|_| Course::Keep).collect();
        let treatment = match planner.singularity.action {
            SingularityAction::Report => RegionTreatment::Reported,
            SingularityAction::Densify => self.densify(&planner, &region, &mut courses, stop)?,
            // The tolerance of the tool axis was spent the first time.
            SingularityAction::Smooth if planner.survey.borne.steps.has(Step::Singularity) => {
                RegionTreatment::Left(LeftReason::SmoothedBefore)
            }
            SingularityAction::Smooth => self.smooth(&planner, &region, &mut courses)?,
        };
        let found = as_uploaded([first, last], region.len(), before, &nearest);
        let number = self.verifier.regions.add(SingularRegion { treatment, ..found });
        for ((pending, course), found) in region.iter().zip(courses).zip(each) {
            let at = usize::try_from(pending.index - self.first).ok();
            if let Some(fate) = at.and_then(|at| self.fates.get_mut(at)) {
                *fate = Fate { course, inside: Some((number, found)) };
            }
        }
        Ok(())
    }

    fn densify(
        &mut self,
        planner: &Planner<'a>,
        region: &[Pending],
        courses: &mut [Course<'a>],
        stop: &Stop<'_>,
    ) -> Result<RegionTreatment, Fault> {
        let (mut divided, mut inserted, mut left, mut reason) = (0, 0, 0, None);
        for (pending, course) in region.iter().zip(courses) {
            if stop().is_break() {
                return Err(Fault::Cancelled);
            }
            let found = planner.densify(pending, &mut self.effort);
            go_on(&self.effort)?;
            match found {
                Ok(None) => {}
                Ok(Some(found)) => {
                    divided += 1;
                    inserted += found.division.nodes.len() as u64 - 1;
                    *course = Course::Divide(Box::new(found));
                }
                Err(why) => {
                    left += 1;
                    reason = reason.or(Some(why));
                }
            }
            self.check_budget()?;
        }
        Ok(match (divided, reason) {
            (0, Some(reason)) => RegionTreatment::Left(reason),
            (0, None) => RegionTreatment::Left(LeftReason::NothingToGain),
            _ => RegionTreatment::Densified { divided, inserted, left, reason },
        })
    }

    fn smooth(
        &mut self,
        planner: &Planner<'a>,
        region: &[Pending],
        courses: &mut [Course<'a>],
    ) -> Result<RegionTreatment, Fault> {
        let found = planner.smooth(region, &mut self.effort);
        go_on(&self.effort)?;
        Ok(match found {
            Err(reason) => RegionTreatment::Left(reason),
            Ok(moved) => {
                let mut changed = 0;
                for (course, moved) in courses.iter_mut().zip(moved) {
                    if let Some(moved) = moved {
                        changed += 1;
                        *course = Course::Move(Box::new(moved));
                    }
                }
                RegionTreatment::Smoothed { changed, axis_spent: Angle::ZERO }
            }
        })
    }

    fn write_held(&mut self, output: &mut dyn Write) -> Result<(), Fault> {
        while let Some(passage) = self.held.pop_front() {
            self.write(&passage, output)?;
        }
        Ok(())
    }

    /// Writes a batch whose motions' fates are known, and reads it back.
    fn write(&mut self, passage: &Passage, output: &mut dyn Write) -> Result<(), Fault> {
        let Passage { batch, motions, .. } = passage;
        let mut copied = 0;
        self.settle(batch)?;
        for motion in motions {
            let fate = self.fates.pop_front().unwrap_or_default();
            self.first += 1;
            let Fate { course, inside } = fate;
            match (course, inside) {
                (Course::Move(moved), Some((region, _))) => {
                    self.write_moved(batch, *moved, region, &mut copied)?;
                }
                (Course::Divide(divided), Some((region, _))) => {
                    self.out.extend_from_slice(batch.blocks_text(copied, motion.block as usize));
                    copied = motion.block as usize + 1;
                    let written_from = self.out.len();
                    self.emitter
                        .write_division(
                            batch,
                            &divided.checked,
                            motion,
                            &divided.division,
                            &mut self.effort,
                            &mut self.out,
                        )
                        .map_err(|fault| Fault::Unwritable { line: motion.line, fault })?;
                    go_on(&self.effort)?;
                    self.settle_behind(batch, motion, written_from)?;
                    let parts = divided.division.nodes.len();
                    self.blocks_changed += 1;
                    self.blocks_inserted += parts as u64 - 1;
                    self.inventory.inserted += parts as u64 - 1;
                    let (checked, division) = (divided.checked, divided.division);
                    let group =
                        Arc::new(Group { source: divided.source, checked, division, correction_mm: 0.0 });
                    for index in 0..parts {
                        let group = Arc::clone(&group);
                        self.verifier.await_next(Expected::Part { group, index, region });
                    }
                }
                (_, inside) => self.keep(batch, motion, inside, &mut copied)?,
            }
        }
        self.out.extend_from_slice(batch.blocks_text(copied, batch.blocks().len()));
        self.check_budget()?;
        self.verifier.take(&self.out)?;
        output.write_all(&self.out)?;
        self.out.clear();
        Ok(())
    }

    /// Copies a block, but gives it its feed back.
    fn keep(
        &mut self,
        batch: &Batch,
        motion: &Motion,
        inside: Option<(RegionNumber, RegionFigures)>,
        copied: &mut usize,
    ) -> Result<(), Fault> {
        let expected = Expected::Same { motion: Meaning::of(motion), line: motion.line, inside };
        self.verifier.await_next(expected);
        if !self.emitter.owes_feed() {
            return Ok(());
        }
        self.out.extend_from_slice(batch.blocks_text(*copied, motion.block as usize));
        *copied = motion.block as usize;
        let (blocks, written_from) = (self.emitter.feed_blocks, self.out.len());
        let changed = self
            .emitter
            .restore_feed(batch, motion, &mut self.out)
            .map_err(|fault| Fault::Unwritable { line: motion.line, fault })?;
        if self.emitter.feed_blocks > blocks {
            let own = if changed { own_lines(batch, motion) } else { 0 };
            self.note_lines(batch, motion, written_from, own)?;
        }
        *copied += usize::from(changed);
        Ok(())
    }

    /// Where the batch before ended with an F owed: gives it back before this one changes what F means.
    fn settle(&mut self, batch: &Batch) -> Result<(), Fault> {
        let Some(first) = batch.blocks().first() else { return Ok(()) };
        let from = self.out.len();
        self.emitter
            .settle(batch, 0, 0, &mut self.out)
            .map_err(|fault| Fault::Unwritable { line: first.line, fault })?;
        let written = line_ends(self.out.get(from..).unwrap_or_default());
        self.lines.insert(first.line.saturating_sub(1), written)
    }

    /// Behind a block that was written anew from `from` on: gives an owed F back before what follows changes what F
    /// means, and notes the lines.
    fn settle_behind(&mut self, batch: &Batch, motion: &Motion, from: usize) -> Result<(), Fault> {
        let index = motion.block as usize;
        self.emitter
            .settle(batch, index, index + 1, &mut self.out)
            .map_err(|fault| Fault::Unwritable { line: motion.line, fault })?;
        self.note_lines(batch, motion, from, own_lines(batch, motion))
    }

    /// Lines written for this motion since `from`, of which the source has `own`; where it has none they stand before
    /// its block.
    fn note_lines(&mut self, batch: &Batch, motion: &Motion, from: usize, own: u64) -> Result<(), Fault> {
        let line = batch.blocks().get(motion.block as usize).map_or(motion.line, |block| block.line);
        let written = line_ends(self.out.get(from..).unwrap_or_default());
        self.lines.insert(line.saturating_sub(u64::from(own == 0)), written.saturating_sub(own))
    }

    /// Writes a block with other ends.
    fn write_moved(
        &mut self,
        batch: &Batch,
        moved: Moved,
        region: RegionNumber,
        copied: &mut usize,
    ) -> Result<(), Fault> {
        let motion = moved.pending.motion;
        let mut words = moved.words.clone();
        let only_feed = words.is_empty();
        if let Some(feed) = moved.feed {
            self.emitter.owe(&motion.feed);
            words.push(feed);
        } else {
            words.extend(self.emitter.take_owed(&motion.feed));
            self.emitter.feeds_restored += u64::from(only_feed && !words.is_empty());
        }
        if !words.is_empty() {
            self.out.extend_from_slice(batch.blocks_text(*copied, motion.block as usize));
            let written_from = self.out.len();
            print_changed(batch, motion.block as usize, &words, false, &mut self.out)
                .map_err(|fault| Fault::Unwritable { line: motion.line, fault })?;
            self.emitter.count_feed(batch, &words);
            self.settle_behind(batch, &motion, written_from)?;
            *copied = motion.block as usize + 1;
            self.blocks_changed += 1;
        }
        self.verifier.await_next(Expected::Moved { moved: Box::new(moved), region });
        Ok(())
    }

    fn check_budget(&self) -> Result<(), Fault> {
        let budget = &self.planner.cutting.parameters.budget;
        if self.effort.evaluations() + self.verifier.effort.evaluations() > budget.max_evaluations {
            let what = "evaluations of the deviation";
            return Err(Fault::TooCostly { what, limit: budget.max_evaluations });
        }
        if self.inventory.blocks + self.inventory.inserted > budget.max_blocks_out {
            return Err(Fault::TooCostly { what: "blocks written", limit: budget.max_blocks_out });
        }
        Ok(())
    }

    fn report(self, dialect: Dialect, blocks_in: u64) -> SingularityReport {
        let blocks_out = self.verifier.blocks();
        SingularityReport {
            blocks_in,
            blocks_out,
            motions_checked: self.collector.checked,
            blocks_changed: self.blocks_changed,
            blocks_inserted: self.blocks_inserted,
            feeds_restored: self.emitter.feeds_restored,
            ..self.verifier.regions.report(dialect, self.planner.singularity.action)
        }
    }
}

/// Lines that end in the block of this motion.
fn own_lines(batch: &Batch, motion: &Motion) -> u64 {
    let own = batch.blocks().get(motion.block as usize);
    own.map_or(0, |block| line_ends(batch.block_text(block)))
}
