//! Reads the written program back as a control would, and checks it block by block against the source.
//!
//! Every block that was left unchanged must keep its meaning. Every part of a divided block must be where it was
//! planned. Its deviation from the source block's line is sampled from the words that were read.

use std::sync::Arc;

use super::division::Division;
use super::judge::Checked;
use super::milestones::Milestones;
use super::parameters::CcParameters;
use crate::contact::{
    BlockTime, Correction, Effort, Sampled, Segment, Station, block_time_s, sample_until_sure,
    within_tolerance,
};
use crate::machine::Machine;
use crate::motion::{ContactWords, Motion, MotionKind};
use crate::process::fault::{Fault, go_on};
use crate::process::pipeline::TIME_ROUNDING;
use crate::process::pipeline::{
    BeforeAfter, Expected, KeptMotion, MotionChange, Outgoing, ReadBack, SAME_READ_BACK, StepCheck, failed,
    same_words,
};
use crate::process::text::Stretch;
use crate::program::Dialect;

/// The extruder word of a part may be rounded beyond the block's ends by this \[program units\].
const SAME_EXTRA: f64 = 1e-3;
/// A part is measured if a proof found at least this share of the largest deviation so far.
const NEAR_LARGEST: f64 = 0.9;

/// The expected next motion of the written program.
#[derive(Debug)]
pub(in crate::process) enum ExpectedMotion<'a> {
    /// A block that was left unchanged.
    Same {
        motion: SourceMotion,
        /// Contact path length and deviation, if the motion was checked.
        checked: Option<(f64, Sampled)>,
    },
    /// Part of a divided block.
    Part { group: Arc<DividedBlock<'a>>, index: usize },
}

/// A motion of the source.
#[derive(Debug)]
pub(in crate::process) enum SourceMotion {
    /// By its place in the stretch from which the current text was written.
    At { passage: usize, motion: usize, line: u64 },
    /// Kept from a stretch that is finished.
    Kept(Box<KeptMotion>),
}

impl SourceMotion {
    pub(in crate::process) fn line(&self) -> u64 {
        match self {
            Self::At { line, .. } => *line,
            Self::Kept(meaning) => meaning.line,
        }
    }
}

/// A divided block with its plan.
#[derive(Debug)]
pub(in crate::process) struct DividedBlock<'a> {
    pub(in crate::process) source: Motion,
    pub(in crate::process) checked: Checked<'a>,
    pub(in crate::process) division: Division,
    /// Largest distance of a part's end from where the source block has it \[mm\].
    pub(in crate::process) correction_mm: f64,
}

impl Expected for ExpectedMotion<'_> {
    fn line(&self) -> u64 {
        match self {
            Self::Same { motion, .. } => motion.line(),
            Self::Part { group, .. } => group.source.line,
        }
    }

    fn missing(&self) -> &'static str {
        match self {
            Self::Same { .. } => "a motion is missing",
            Self::Part { .. } => "a part of a divided block is missing",
        }
    }
}

/// The outcome for one motion of the source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::process) struct Judged {
    pub(in crate::process) line: u64,
    pub(in crate::process) kind: MotionKind,
    /// Largest deviation before and after \[mm\]; 0 if the motion was not checked.
    pub(in crate::process) deviation_mm: [f64; 2],
    /// Largest distance of a part's end from where the source block has it \[mm\].
    pub(in crate::process) correction_mm: f64,
    /// The number of blocks that the motion has now.
    pub(in crate::process) parts: u32,
}

impl Judged {
    pub(in crate::process) fn undivided(line: u64, kind: MotionKind, deviation_mm: f64) -> Self {
        Self { line, kind, deviation_mm: [deviation_mm; 2], correction_mm: 0.0, parts: 1 }
    }

    /// The outcome in the form that all steps of a program share.
    pub(super) fn change(&self) -> MotionChange {
        let [before_mm, after_mm] = self.deviation_mm;
        let mut change = MotionChange::none(self.line, self.kind);
        (change.cc_mm, change.blocks_out) = (self.correction_mm, self.parts);
        change.error.before.interpolation_mm = before_mm;
        change.error.after.interpolation_mm = after_mm;
        change
    }

    fn divided(group: &DividedBlock<'_>, after: &Sampled) -> Self {
        Self {
            line: group.source.line,
            kind: group.source.kind,
            deviation_mm: [group.checked.before.max_mm, after.max_mm],
            correction_mm: group.correction_mm,
            parts: u32::try_from(group.division.nodes.len()).unwrap_or(u32::MAX),
        }
    }
}

/// Reads the output back and sums up what it leaves.
pub(in crate::process) struct PathCheck<'a> {
    machine: &'a Machine,
    parameters: &'a CcParameters,
    pub(in crate::process) read_back: ReadBack<ExpectedMotion<'a>>,
    parts: Vec<(f64, Sampled)>,
    /// The place of the motion read last, if it was left unchanged and ends to the bit where the source's motion
    /// does.
    pub(in crate::process) exact: Option<(usize, usize)>,
    pub(in crate::process) milestones: Milestones,
    pub(in crate::process) found: BeforeAfter,
    /// The outcomes of the motions read back, for the caller to collect.
    pub(in crate::process) judged: Vec<Judged>,
    pub(in crate::process) effort: Effort<'a>,
}

impl<'a> StepCheck for PathCheck<'a> {
    type Expected = ExpectedMotion<'a>;
    type Outcome = Judged;

    fn read_back(&mut self) -> &mut ReadBack<ExpectedMotion<'a>> {
        &mut self.read_back
    }

    fn compare(&mut self, of: &Stretch) -> Result<(), Fault> {
        self.read(of)
    }

    fn take(&mut self, written: &mut Outgoing<ExpectedMotion<'a>>, of: &Stretch) -> Result<(), Fault> {
        self.look_at(written, of)
    }

    fn outcomes(&mut self) -> &mut Vec<Judged> {
        &mut self.judged
    }
}

impl<'a> PathCheck<'a> {
    pub(in crate::process) fn new(
        machine: &'a Machine,
        parameters: &'a CcParameters,
        dialect: Dialect,
        effort: Effort<'a>,
    ) -> Self {
        Self {
            machine,
            parameters,
            read_back: ReadBack::new(machine, dialect, &parameters.program).eager(),
            parts: Vec::new(),
            exact: None,
            milestones: Milestones::default(),
            found: BeforeAfter::default(),
            judged: Vec::new(),
            effort,
        }
    }

    /// The number of output blocks so far.
    pub(in crate::process) fn blocks(&self) -> u64 {
        self.read_back.inventory.blocks
    }

    /// Reads all text that is available. Unchanged motions are those of `stretch`.
    pub(in crate::process) fn read(&mut self, stretch: &Stretch) -> Result<(), Fault> {
        while self.read_back.advance()? {
            self.effort.pass(1);
            go_on(&self.effort)?;
            self.milestones.reach(self.read_back.blocks_before(), self.found.after.max_mm());
            self.exact = None;
            match self.read_back.pair() {
                Some((read, ExpectedMotion::Same { motion, checked })) => {
                    let (line, kind) = match motion {
                        SourceMotion::Kept(source) => {
                            source.check(read)?;
                            (source.line, source.kind)
                        }
                        SourceMotion::At { passage, motion, line } => {
                            let source = stretch.motion(*passage, *motion);
                            let source = source.ok_or(failed(*line, "a motion is missing"))?;
                            KeptMotion::of(source).check(read)?;
                            let is_exact = read.end.is_some()
                                && read.end == source.end
                                && (read.linear_end_mm, read.tool_axis)
                                    == (source.linear_end_mm, source.tool_axis)
                                && read.contact == source.contact;
                            self.exact = is_exact.then_some((*passage, *motion));
                            (source.line, source.kind)
                        }
                    };
                    let found = checked.as_ref();
                    if let Some((path_mm, found)) = found {
                        self.found.record(line, *path_mm, found, found);
                    }
                    let deviation_mm = found.map_or(0.0, |(_, found)| found.max_mm);
                    self.judged.push(Judged::undivided(line, kind, deviation_mm));
                }
                Some((read, ExpectedMotion::Part { group, index })) => {
                    let (read, group, index) = (*read, Arc::clone(group), *index);
                    if let Some(after) = self.part(&read, &group, index)? {
                        self.judged.push(Judged::divided(&group, &after));
                    }
                }
                None => {}
            }
            self.read_back.drop_pair();
        }
        Ok(())
    }

    /// Checks one part. The last part of a block returns the deviation of all its parts.
    fn part(
        &mut self,
        read: &Motion,
        group: &DividedBlock<'a>,
        index: usize,
    ) -> Result<Option<Sampled>, Fault> {
        let line = group.source.line;
        let node = group.division.nodes.get(index).ok_or(failed(line, "there is a part too many"))?;
        let block = &group.checked.block;
        let mode = self.parameters.program.interpolation.unwrap_or(read.interpolation);
        let (Some(start), Some(end)) = (read.start, read.end) else {
            return Err(failed(line, "a part of a divided block has no known end"));
        };
        let planned_start = match index.checked_sub(1) {
            None => block.ends[0].words,
            Some(before) => group.division.nodes[before].station.words,
        };
        let same_modes = read.kind == MotionKind::Linear
            && read.unfollowable.is_none()
            && mode == block.mode
            && read.feed.mode == group.source.feed.mode
            && read.incremental == group.source.incremental;
        if !same_modes {
            return Err(failed(line, "a part of a divided block is another kind of motion"));
        }
        if !same_words(Some(start), Some(planned_start)) || !same_words(Some(end), Some(node.station.words)) {
            return Err(failed(line, "a part of a divided block is not where it was planned"));
        }
        Self::carried_along(read, group, index)?;
        let from = index.checked_sub(1).map_or(0.0, |before| group.division.nodes[before].fraction);
        let ends = [start, end].map(|words| Station::new(self.machine, &block.kinematics, mode, words));
        let segment = Segment { ends, fraction: [from, node.fraction] };
        let tolerance_mm = self.parameters.tolerance.mm();
        let found = if self.parameters.correction == Correction::Seed {
            sample_until_sure(block, &segment, tolerance_mm)
        } else {
            within_tolerance(block, &segment, tolerance_mm)
                .or_else(|found| {
                    // A difference in the last bit of a word may push a block that was just inside over the limit.
                    let slack = 1.0 + 1e-9;
                    if found.max_mm <= tolerance_mm * slack { Ok(found) } else { Err(found) }
                })
                .map_err(|_found| failed(line, "a part of a divided block exceeds the tolerance"))?
        };
        self.effort.spend(found.evaluations);
        // A deviation that may become the largest of the report is measured, not only bounded.
        let found = if found.max_mm > NEAR_LARGEST * self.found.after.max_mm() {
            let measured = sample_until_sure(block, &segment, tolerance_mm);
            self.effort.spend(measured.evaluations);
            measured
        } else {
            found
        };
        self.parts.push((node.fraction - from, found));
        Self::time(read, group, &segment)?;
        if index + 1 < group.division.nodes.len() {
            return Ok(None);
        }
        let after = Sampled::join(self.parts.drain(..));
        self.found.record(line, block.line.length_mm, &group.checked.before, &after);
        Ok(Some(after))
    }

    /// Checks the words that move with the axes: contact words of the same kind, and the extruder. Both end where the
    /// source block ends them. The extruder stays between its values at the block's ends.
    pub(in crate::process) fn carried_along(
        read: &Motion,
        group: &DividedBlock<'a>,
        index: usize,
    ) -> Result<(), Fault> {
        let (line, source) = (group.source.line, &group.source);
        let last = index + 1 == group.division.nodes.len();
        let same_kind = std::mem::discriminant(&read.contact) == std::mem::discriminant(&source.contact);
        // If the block began without a contact, only its last part may state one.
        let fits = match group.checked.start_contact {
            Some(_) => same_kind,
            None => last || read.contact == ContactWords::None,
        };
        if !fits || (last && !same_contact(read.contact, source.contact)) {
            return Err(failed(line, "a part of a divided block has other contact words than planned"));
        }
        match (read.extra, source.extra) {
            (None, None) => Ok(()),
            (Some(part), Some(whole)) => {
                let start = whole.start.unwrap_or(whole.end);
                let between = part.end >= start.min(whole.end) - SAME_EXTRA
                    && part.end <= start.max(whole.end) + SAME_EXTRA;
                let ends = !last || (part.end - whole.end).abs() <= SAME_READ_BACK;
                if between && ends {
                    Ok(())
                } else {
                    Err(failed(line, "the extruder of a divided block goes to another place than planned"))
                }
            }
            _ => Err(failed(line, "the extruder word of a divided block is missing or was added")),
        }
    }

    /// Checks that every part takes its share of the source block's time.
    pub(in crate::process) fn time(
        read: &Motion,
        group: &DividedBlock<'a>,
        segment: &Segment,
    ) -> Result<(), Fault> {
        let (source, block) = (&group.source, &group.checked.block);
        let Some(mode) = source.feed.mode.filter(|_| group.division.carries_feed) else { return Ok(()) };
        let time_s = |feed, segment: &Segment| {
            block_time_s(mode, feed, &BlockTime::of(block, segment, source.mm_per_unit, source.feed.paths))
        };
        // In G95 the time depends on the spindle, so only the formula of the plan is available.
        let Some(whole_s) = time_s(source.feed.raw, &block.whole()) else { return Ok(()) };
        let share_s = whole_s * (segment.fraction[1] - segment.fraction[0]);
        match time_s(read.feed.raw, segment) {
            Some(part_s) if (part_s - share_s).abs() <= TIME_ROUNDING * share_s => Ok(()),
            _ => Err(failed(source.line, "a part of a divided block does not take its share of the time")),
        }
    }
}

fn same_contact(a: ContactWords, b: ContactWords) -> bool {
    match (a, b) {
        (ContactWords::Point(a), ContactWords::Point(b))
        | (ContactWords::Normal(a), ContactWords::Normal(b)) => {
            a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= SAME_READ_BACK)
        }
        (a, b) => a == b,
    }
}
