//! Reads the written program back as a control would. It checks every motion against the plan, and tool axis and
//! contact from the words that were read.

use std::sync::Arc;

use super::figures::{axis_deviation, figures, great_circle, rotary_steps_deg, time_s};
use super::planner::{Planner, SmoothedMotion};
use super::regions::{RegionFiguresWritten, RegionNumber};
use super::report::RegionFigures;
use crate::contact::{Effort, within_tolerance};
use crate::geometry::angle_between;
use crate::machine::Machine;
use crate::motion::Motion;
use crate::process::divided::{DividedBlock, LAST_BIT};
use crate::process::fault::{Fault, go_on};
use crate::process::pipeline::{
    ARITHMETIC_MM, Expected, KeptMotion, LINEAR_ROUNDING, ReadBack, StepCheck, TIME_ROUNDING, failed,
};
use crate::process::text::Stretch;
use crate::program::Dialect;

/// Error from words that pass through binary fractions \[deg\].
const SAME_STEP_DEG: f64 = 1e-6;
/// The expected next motion of the written program.
#[derive(Debug)]
#[expect(
    clippy::large_enum_variant,
    reason = "nearly all are the large variant; boxing them would cost one allocation per block"
)]
pub(super) enum ExpectedInRegion<'a> {
    /// A block that was left unchanged, with its figures if it is in a region.
    Same { motion: KeptMotion, line: u64, inside: Option<(RegionNumber, RegionFigures)> },
    /// A block with new ends.
    SmoothedMotion { moved: Box<SmoothedMotion>, region: RegionNumber },
    /// Part of a divided block.
    Part { group: Arc<DividedBlock<'a>>, index: usize, region: RegionNumber },
}

impl Expected for ExpectedInRegion<'_> {
    fn line(&self) -> u64 {
        match self {
            Self::Same { line, .. } => *line,
            Self::SmoothedMotion { moved, .. } => moved.pending.motion.line,
            Self::Part { group, .. } => group.source.line,
        }
    }

    fn missing(&self) -> &'static str {
        match self {
            Self::Part { .. } => "a part of a divided block is missing",
            Self::Same { .. } | Self::SmoothedMotion { .. } => "a motion is missing",
        }
    }
}

/// Reads the output back.
pub(super) struct RegionCheck<'a> {
    planner: Planner<'a>,
    read_back: ReadBack<ExpectedInRegion<'a>>,
    pub(super) written: RegionFiguresWritten,
    pub(super) effort: Effort<'a>,
    outcomes: Vec<()>,
}

impl<'a> StepCheck for RegionCheck<'a> {
    type Expected = ExpectedInRegion<'a>;
    type Outcome = ();

    fn read_back(&mut self) -> &mut ReadBack<ExpectedInRegion<'a>> {
        &mut self.read_back
    }

    fn compare(&mut self, _of: &Stretch) -> Result<(), Fault> {
        self.read()
    }

    fn outcomes(&mut self) -> &mut Vec<()> {
        &mut self.outcomes
    }
}

impl<'a> RegionCheck<'a> {
    pub(in crate::process) fn new(
        machine: &Machine,
        planner: Planner<'a>,
        dialect: Dialect,
        effort: Effort<'a>,
    ) -> Self {
        let read_back = ReadBack::new(machine, dialect, &planner.cutting.parameters.program);
        Self { planner, read_back, written: RegionFiguresWritten::default(), outcomes: Vec::new(), effort }
    }

    /// Blocks of the output so far.
    pub(super) fn blocks(&self) -> u64 {
        self.read_back.inventory.blocks
    }

    fn read(&mut self) -> Result<(), Fault> {
        while let Some((motion, next)) = self.read_back.next()? {
            self.effort.pass(1);
            go_on(&self.effort)?;
            match next {
                ExpectedInRegion::Same { motion: source, inside, .. } => {
                    source.check(&motion)?;
                    if let Some((region, found)) = inside {
                        self.written.take(region, &found);
                    }
                }
                ExpectedInRegion::SmoothedMotion { moved, region } => self.moved(&motion, &moved, region)?,
                ExpectedInRegion::Part { group, index, region } => {
                    self.part(&motion, &group, index, region)?;
                }
            }
        }
        Ok(())
    }

    fn moved(&mut self, read: &Motion, moved: &SmoothedMotion, region: RegionNumber) -> Result<(), Fault> {
        let pending = &moved.pending;
        let planner = self.planner.on(pending);
        let line = pending.motion.line;
        let mut planned = pending.motion;
        (planned.start, planned.end) = (Some(moved.ends[0]), Some(moved.ends[1]));
        planned.contact = moved.contact;
        if let Some(feed) = moved.feed {
            planned.feed.raw = feed.value;
        }
        KeptMotion::of(&planned).check(read)?;
        let (Some(start), Some(end)) = (read.start, read.end) else {
            return Err(failed(line, "a moved block has no known ends"));
        };
        let ends = [start, end].map(|words| planner.station(pending.mode, words));
        let (source, pose) = (&pending.ends[1].pose, &ends[1].pose);
        let spent_rad = angle_between(pose.axis, source.axis);
        let tolerance_rad = self.planner.singularity.axis_tolerance.rad();
        if spent_rad.is_nan() || spent_rad > tolerance_rad * (1.0 + LAST_BIT) {
            return Err(failed(line, "the tool axis is too far from the programmed one"));
        }
        let tip_mm = planner.cutting.kept_tip_mm(source, moved.touch.as_ref(), pose.axis);
        let off_mm = (pose.tip_mm - tip_mm).norm();
        if off_mm.is_nan() || off_mm > LINEAR_ROUNDING * moved.half_mm + ARITHMETIC_MM {
            return Err(failed(line, "the tip or the contact of a moved block is not where it was planned"));
        }
        let block = planner.cutting.block(pending.mode, ends, [None, None]);
        let meant = planner.cutting.block(pending.mode, pending.ends, [None, None]);
        let time = time_s(&block, read);
        if self.planner.survey.has_feed_column
            && let (Some(written_s), Some(source_s)) = (time, time_s(&meant, &pending.motion))
            && (written_s - source_s).abs() > TIME_ROUNDING * source_s
        {
            return Err(failed(line, "a moved block does not take the source's time"));
        }
        let limits = self.planner.limits();
        let found = figures(&block, &block.whole(), time, &limits, &mut self.effort);
        self.written.take(region, &found);
        self.written.spent(region, spent_rad);
        Ok(())
    }

    fn part(
        &mut self,
        read: &Motion,
        group: &DividedBlock<'a>,
        index: usize,
        region: RegionNumber,
    ) -> Result<(), Fault> {
        let (line, block) = (group.source.line, &group.checked.block);
        let stated = self.planner.cutting.parameters.program.interpolation;
        let segment = group.check_part(read, index, stated)?;
        let limits = self.planner.limits();
        let found = within_tolerance(block, &segment, limits.tolerance_mm);
        let (Ok(sampled) | Err(sampled)) = found;
        self.effort.spend(sampled.evaluations);
        if found.is_err_and(|sampled| sampled.max_mm > limits.tolerance_mm * (1.0 + LAST_BIT)) {
            return Err(failed(line, "a part of a divided block exceeds the tolerance"));
        }
        let arc = great_circle(block);
        let axis = axis_deviation(block, &segment, &arc, limits.axis_tolerance_rad);
        if axis.sampled_rad > limits.axis_tolerance_rad * (1.0 + LAST_BIT) {
            return Err(failed(line, "the tool axis of a divided block leaves the great circle"));
        }
        let max_step_deg = self.planner.singularity.max_step.deg() + SAME_STEP_DEG;
        if rotary_steps_deg(&segment).into_iter().any(|step| step > max_step_deg) {
            return Err(failed(line, "a rotary axis turns too far in a part of a divided block"));
        }
        group.check_time(read, &segment)?;
        let found = figures(block, &segment, time_s(block, &group.source), &limits, &mut self.effort);
        self.written.take(region, &found);
        Ok(())
    }
}
