//! The course of the treatment, streamed: read, collect regions, plan, write, read back.

use std::collections::VecDeque;
use std::io::Write;
use std::sync::Arc;

use super::contact::Cutting;
use super::measured::{Measured, as_uploaded, measured};
use super::pending::{Collector, Pending, Seen};
use super::plan::{Course, Divided, Moved, Planner};
use super::regions::RegionNumber;
use super::report::{RegionFigures, RegionTreatment, SingularRegion, SingularityReport};
use super::verify::{Expected, SingularityVerifier};
use super::{LeftReason, SingularityAction, SingularityParameters};
use crate::contact::Effort;
use crate::geometry::trig;
use crate::machine::Machine;
use crate::motion::Motion;
use crate::process::compensate::Upstream;
use crate::process::fault::go_on;
use crate::process::inventory::Inventory;
use crate::process::pipeline::{LineMap, Outgoing, Placed, Rewriter};
use crate::process::stream::{Passage, Passages};
use crate::process::survey::Survey;
use crate::process::verify::{Group, Meaning};
use crate::process::warnings::Warnings;
use crate::process::{CcParameters, ContactSource, Fault, ProgramSource, Stop};
use crate::program::{Dialect, Step, Steps};
use crate::units::Angle;

/// So many batches wait for the end of a region at most; then it ends there.
const MAX_HELD: usize = 64;
/// The place of a passage that was held back: it is in no stretch.
const HELD: usize = usize::MAX;

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
    run.verifier.finish(&run.rewriter.inventory(&run.inventory))?;
    output.flush()?;
    let mut warnings = Warnings::default();
    passages.warn(&mut warnings);
    let (report, lines) = run.report(passages.dialect(), passages.blocks);
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
    rewriter: Rewriter,
    verifier: SingularityVerifier<'a>,
    inventory: Inventory,
    /// Batches that wait for the end of a region.
    held: VecDeque<Passage>,
    /// The fates of their motions and of those at hand.
    fates: VecDeque<Fate<'a>>,
    /// Number of the motion of the first fate, and of the next motion to come.
    first: u64,
    next: u64,
    out: Outgoing<Expected<'a>>,
    effort: Effort<'a>,
    blocks_changed: u64,
}

impl<'a> Run<'a> {
    fn new(planner: Planner<'a>, dialect: Dialect, stop: &'a Stop<'a>) -> Self {
        let cutting = planner.cutting.clone();
        let (sine, _) = trig::sin_cos(planner.singularity.zone.rad());
        let effort = || cutting.parameters.budget.effort(stop);
        let zone = cutting.kinematics.singular_zone(sine);
        Self {
            rewriter: Rewriter::new(planner.survey.numbering),
            verifier: SingularityVerifier::new(cutting.machine, planner.clone(), dialect, effort()),
            planner,
            collector: Collector::new(cutting.clone(), zone, dialect),
            inventory: Inventory::default(),
            held: VecDeque::new(),
            fates: VecDeque::new(),
            first: 0,
            next: 0,
            out: Outgoing::default(),
            effort: effort(),
            blocks_changed: 0,
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
        let placed = (HELD, passage);
        self.rewriter.begin(passage, &mut self.out)?;
        for motion in &passage.motions {
            let Fate { course, inside } = self.fates.pop_front().unwrap_or_default();
            self.first += 1;
            match (course, inside) {
                (Course::Move(moved), Some((region, _))) => self.write_moved(placed, *moved, region)?,
                (Course::Divide(divided), Some((region, _))) => {
                    self.write_divided(placed, motion, *divided, region)?;
                }
                (_, inside) => {
                    let motion_kept = Meaning::of(motion);
                    let expected = Expected::Same { motion: motion_kept, line: motion.line, inside };
                    self.out.expected.push_back(expected);
                    self.rewriter.leave(placed, motion, &mut self.out)?;
                }
            }
        }
        self.rewriter.end(placed, &mut self.out);
        self.check_budget()?;
        self.verifier.take(&mut self.out)?;
        output.write_all(&self.out.text)?;
        self.out.clear();
        Ok(())
    }

    /// Writes the parts of a block.
    fn write_divided(
        &mut self,
        passage: Placed<'_>,
        motion: &Motion,
        divided: Divided<'a>,
        region: RegionNumber,
    ) -> Result<(), Fault> {
        let Divided { source, checked, division } = divided;
        let effort = &mut self.effort;
        self.rewriter.anew(passage, motion, &mut self.out, |emitter, text| {
            emitter.write_division(&passage.1.batch, &checked, motion, &division, effort, text)
        })?;
        go_on(&self.effort)?;
        let parts = division.nodes.len();
        self.blocks_changed += 1;
        self.rewriter.count_inserted(parts as u64 - 1);
        let group = Arc::new(Group { source, checked, division, correction_mm: 0.0 });
        let part = |index| Expected::Part { group: Arc::clone(&group), index, region };
        self.out.expected.extend((0..parts).map(part));
        Ok(())
    }

    /// Writes a block with other ends.
    fn write_moved(&mut self, passage: Placed<'_>, moved: Moved, region: RegionNumber) -> Result<(), Fault> {
        let motion = moved.pending.motion;
        let mut words = moved.words.clone();
        let only_feed = words.is_empty();
        if let Some(feed) = moved.feed {
            self.rewriter.owe(&motion.feed);
            words.push(feed);
        } else {
            words.extend(self.rewriter.take_owed(&motion.feed));
            if only_feed && !words.is_empty() {
                self.rewriter.count_restored();
            }
        }
        if !words.is_empty() {
            self.rewriter.change(passage, &motion, &words, &mut self.out)?;
            self.blocks_changed += 1;
        }
        self.out.expected.push_back(Expected::Moved { moved: Box::new(moved), region });
        Ok(())
    }

    fn check_budget(&self) -> Result<(), Fault> {
        let budget = &self.planner.cutting.parameters.budget;
        if self.effort.evaluations() + self.verifier.effort.evaluations() > budget.max_evaluations {
            let what = "evaluations of the deviation";
            return Err(Fault::TooCostly { what, limit: budget.max_evaluations });
        }
        if self.inventory.blocks + self.rewriter.inserted() > budget.max_blocks_out {
            return Err(Fault::TooCostly { what: "blocks written", limit: budget.max_blocks_out });
        }
        Ok(())
    }

    /// What was done, and the lines that came in.
    fn report(self, dialect: Dialect, blocks_in: u64) -> (SingularityReport, LineMap) {
        let report = SingularityReport {
            blocks_in,
            blocks_out: self.verifier.blocks(),
            motions_checked: self.collector.checked,
            blocks_changed: self.blocks_changed,
            blocks_inserted: self.rewriter.inserted(),
            feeds_restored: self.rewriter.feeds_restored(),
            ..self.verifier.regions.report(dialect, self.planner.singularity.action)
        };
        (report, self.rewriter.into_lines())
    }
}
