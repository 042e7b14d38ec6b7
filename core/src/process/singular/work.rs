//! Writes a program with its singular regions treated, stretch by stretch: collect regions, plan, write.

use std::collections::VecDeque;
use std::sync::Arc;

use super::check::{ExpectedInRegion, RegionCheck};
use super::collector::{Collector, Seen};
use super::measured::{Measured, as_uploaded, measured};
use super::parameters::SingularityAction;
use super::pending::Pending;
use super::planner::{Change, DensifiedMotion, Planner, SmoothedMotion};
use super::regions::{RegionNumber, Regions};
use super::report::{LeftReason, RegionFigures, RegionTreatment, SingularRegion, SingularityReport};
use crate::contact::Effort;
use crate::geometry::trig;
use crate::motion::Motion;
use crate::process::divided::{DividedBlock, write_division};
use crate::process::fault::{Fault, Warnings, go_on};
use crate::process::pipeline::{KeptMotion, Outgoing, Placed, Rewriter, StepWork, Surveyed};
use crate::process::set_up::Stop;
use crate::process::text::{Inventory, LineMap, Passage, Passages, Stretch};
use crate::program::{Dialect, StepName};
use crate::units::Angle;

/// Largest number of batches that wait for the end of a region. The region then ends there.
const MAX_HELD: usize = 64;
/// The index of a passage that was held back, because it is in no stretch.
const HELD: usize = usize::MAX;

/// The fate of a motion that is held back.
#[derive(Debug, Default)]
struct Fate<'a> {
    change: Change<'a>,
    /// Its region, and its figures as uploaded.
    inside: Option<(RegionNumber, RegionFigures)>,
}

/// The work in progress.
pub(super) struct RegionWork<'a> {
    planner: Planner<'a>,
    pub(super) collector: Collector<'a>,
    rewriter: Rewriter,
    regions: Regions,
    /// Batches that wait for the end of a region.
    held: VecDeque<Passage>,
    /// The fates of their motions and of the current motions.
    fates: VecDeque<Fate<'a>>,
    /// The number of the motion of the first fate, and of the next motion.
    first: u64,
    next: u64,
    effort: Effort<'a>,
    /// Evaluations of the reading back, and blocks read, as last reported.
    spent_elsewhere: [u64; 2],
    blocks_changed: u64,
    warnings: Warnings,
    stop: &'a Stop<'a>,
}

impl<'a> StepWork for RegionWork<'a> {
    type Expected = ExpectedInRegion<'a>;
    type Checker = RegionCheck<'a>;

    fn write(&mut self, stretch: &Stretch, out: &mut Outgoing<ExpectedInRegion<'a>>) -> Result<bool, Fault> {
        stretch.passages.iter().try_for_each(|passage| self.passage(passage, out))?;
        Ok(true)
    }

    fn end(&mut self, out: &mut Outgoing<ExpectedInRegion<'a>>) -> Result<(), Fault> {
        self.close()?;
        self.write_held(out)
    }

    fn hear(&mut self, check: &RegionCheck<'a>, read: &Inventory) -> Result<(), Fault> {
        self.spent_elsewhere = [check.effort.evaluations(), read.blocks];
        self.check_budget()
    }

    fn has_faults(&self) -> bool {
        self.collector.faults.total > 0
    }

    fn refuse(&mut self, _surveyed: &Surveyed<'_>, _passages: &Passages<'_>) -> Result<(), Fault> {
        if self.has_faults() {
            return Err(Fault::Lines(std::mem::take(&mut self.collector.faults)));
        }
        Ok(())
    }

    fn warnings(&mut self) -> &mut Warnings {
        &mut self.warnings
    }

    fn rewriter(&self) -> &Rewriter {
        &self.rewriter
    }
}

impl<'a> RegionWork<'a> {
    pub(super) fn new(planner: Planner<'a>, dialect: Dialect, stop: &'a Stop<'a>) -> Self {
        let cutting = planner.cutting.clone();
        let (sine, _) = trig::sin_cos(planner.singularity.zone.rad());
        let zone = cutting.kinematics.singular_zone(sine);
        Self {
            rewriter: Rewriter::new(planner.survey.numbering),
            planner,
            collector: Collector::new(cutting.clone(), zone, dialect),
            regions: Regions::default(),
            held: VecDeque::new(),
            fates: VecDeque::new(),
            first: 0,
            next: 0,
            effort: cutting.parameters.budget.effort(stop),
            spent_elsewhere: [0; 2],
            blocks_changed: 0,
            warnings: Warnings::default(),
            stop,
        }
    }

    /// Takes one batch, and writes it unless a region continues after it.
    fn passage(&mut self, passage: &Passage, out: &mut Outgoing<ExpectedInRegion<'a>>) -> Result<(), Fault> {
        for motion in &passage.motions {
            self.fates.push_back(Fate::default());
            let index = self.next;
            self.next += 1;
            if self.collector.see(&passage.batch, motion, index) == Seen::Closes && self.collector.is_open() {
                self.close()?;
                self.collector.see(&passage.batch, motion, index);
            }
            if self.collector.is_full() {
                self.close()?;
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
        self.close()?;
        self.write_held(out)?;
        self.write(passage, out)
    }

    /// Closes and plans the current region.
    fn close(&mut self) -> Result<(), Fault> {
        let region = self.collector.take();
        let (Some(first), Some(last)) = (region.first(), region.last()) else { return Ok(()) };
        if (self.stop)().is_break() {
            return Err(Fault::Cancelled);
        }
        let planner = self.planner.on(first);
        let Some(Measured { each, before, nearest }) = measured(&planner, &region, &mut self.effort)? else {
            return Ok(());
        };
        self.check_budget()?;
        let mut changes: Vec<Change<'a>> = region.iter().map(|_| Change::Keep).collect();
        let treatment = match planner.singularity.action {
            SingularityAction::Report => RegionTreatment::Reported,
            SingularityAction::Densify => self.densify(&planner, &region, &mut changes)?,
            // The first smoothing already used up the tolerance of the tool axis.
            SingularityAction::Smooth if planner.survey.borne.steps.has(StepName::Singularity) => {
                RegionTreatment::Left(LeftReason::SmoothedBefore)
            }
            SingularityAction::Smooth => self.smooth(&planner, &region, &mut changes)?,
        };
        let found = as_uploaded([first, last], region.len(), before, &nearest);
        let number = self.regions.add(SingularRegion { treatment, ..found });
        for ((pending, change), found) in region.iter().zip(changes).zip(each) {
            let at = usize::try_from(pending.index - self.first).ok();
            if let Some(fate) = at.and_then(|at| self.fates.get_mut(at)) {
                *fate = Fate { change, inside: Some((number, found)) };
            }
        }
        Ok(())
    }

    fn densify(
        &mut self,
        planner: &Planner<'a>,
        region: &[Pending],
        changes: &mut [Change<'a>],
    ) -> Result<RegionTreatment, Fault> {
        let (mut divided, mut inserted, mut left, mut reason) = (0, 0, 0, None);
        for (pending, change) in region.iter().zip(changes) {
            if (self.stop)().is_break() {
                return Err(Fault::Cancelled);
            }
            let found = planner.densify(pending, &mut self.effort);
            go_on(&self.effort)?;
            match found {
                Ok(None) => {}
                Ok(Some(found)) => {
                    divided += 1;
                    inserted += found.division.nodes.len() as u64 - 1;
                    *change = Change::Divide(Box::new(found));
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
        changes: &mut [Change<'a>],
    ) -> Result<RegionTreatment, Fault> {
        let found = planner.smooth(region, &mut self.effort);
        go_on(&self.effort)?;
        Ok(match found {
            Err(reason) => RegionTreatment::Left(reason),
            Ok(moved) => {
                let mut changed = 0;
                for (change, moved) in changes.iter_mut().zip(moved) {
                    if let Some(moved) = moved {
                        changed += 1;
                        *change = Change::Move(Box::new(moved));
                    }
                }
                RegionTreatment::Smoothed { changed, axis_spent: Angle::ZERO }
            }
        })
    }

    fn write_held(&mut self, out: &mut Outgoing<ExpectedInRegion<'a>>) -> Result<(), Fault> {
        while let Some(passage) = self.held.pop_front() {
            self.write(&passage, out)?;
        }
        Ok(())
    }

    /// Writes a batch. The fates of its motions are known.
    fn write(&mut self, passage: &Passage, out: &mut Outgoing<ExpectedInRegion<'a>>) -> Result<(), Fault> {
        let placed = (HELD, passage);
        self.rewriter.begin(passage, out)?;
        for motion in &passage.motions {
            let Fate { change, inside } = self.fates.pop_front().unwrap_or_default();
            self.first += 1;
            match (change, inside) {
                (Change::Move(moved), Some((region, _))) => self.write_moved(placed, *moved, region, out)?,
                (Change::Divide(divided), Some((region, _))) => {
                    self.write_divided(placed, motion, *divided, region, out)?;
                }
                (_, inside) => {
                    let motion_kept = KeptMotion::of(motion);
                    let expected = ExpectedInRegion::Same { motion: motion_kept, line: motion.line, inside };
                    out.expected.push_back(expected);
                    self.rewriter.leave(placed, motion, out)?;
                }
            }
        }
        self.rewriter.end(placed, out);
        self.check_budget()
    }

    /// Writes the parts of a block.
    fn write_divided(
        &mut self,
        passage: Placed<'_>,
        motion: &Motion,
        divided: DensifiedMotion<'a>,
        region: RegionNumber,
        out: &mut Outgoing<ExpectedInRegion<'a>>,
    ) -> Result<(), Fault> {
        let DensifiedMotion { source, checked, division } = divided;
        let effort = &mut self.effort;
        self.rewriter.anew(passage, motion, out, |emitter, text| {
            write_division(emitter, &passage.1.batch, &checked, motion, &division, effort, text)
        })?;
        go_on(&self.effort)?;
        let parts = division.nodes.len();
        self.blocks_changed += 1;
        self.rewriter.count_inserted(parts as u64 - 1);
        let group = Arc::new(DividedBlock { source, checked, division, correction_mm: 0.0 });
        let part = |index| ExpectedInRegion::Part { group: Arc::clone(&group), index, region };
        out.expected.extend((0..parts).map(part));
        Ok(())
    }

    /// Writes a block with new ends.
    fn write_moved(
        &mut self,
        passage: Placed<'_>,
        moved: SmoothedMotion,
        region: RegionNumber,
        out: &mut Outgoing<ExpectedInRegion<'a>>,
    ) -> Result<(), Fault> {
        let motion = moved.pending.motion;
        let mut words = moved.words.clone();
        let is_written = self.rewriter.rewrite(passage, &motion, &mut words, moved.feed, out)?;
        self.blocks_changed += u64::from(is_written);
        out.expected.push_back(ExpectedInRegion::SmoothedMotion { moved: Box::new(moved), region });
        Ok(())
    }

    fn check_budget(&self) -> Result<(), Fault> {
        let [evaluations, blocks] = self.spent_elsewhere;
        let evaluations = self.effort.evaluations() + evaluations;
        let budget = &self.planner.cutting.parameters.budget;
        budget.check(evaluations, blocks + self.rewriter.inserted())
    }

    /// The report, and the map of inserted lines.
    pub(super) fn report(
        self,
        check: RegionCheck<'a>,
        passages: &Passages<'_>,
    ) -> (SingularityReport, LineMap) {
        let action = self.planner.singularity.action;
        let report = SingularityReport {
            blocks_in: passages.blocks,
            blocks_out: check.blocks(),
            motions_checked: self.collector.checked,
            blocks_changed: self.blocks_changed,
            blocks_inserted: self.rewriter.inserted(),
            feeds_restored: self.rewriter.feeds_restored(),
            warnings: self.warnings.into_list(),
            ..self.regions.report(check.written, passages.dialect(), action)
        };
        (report, self.rewriter.into_lines())
    }
}
