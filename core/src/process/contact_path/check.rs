//! Reads the written program back as a control would, and checks it block by block against the source.
//!
//! Every block that was left unchanged must keep its meaning. Every part of a divided block must be where it was
//! planned. Its deviation from the source block's line is sampled from the words that were read.

use std::sync::Arc;

use super::milestones::Milestones;
use super::parameters::CcParameters;
use crate::contact::{Correction, Effort, Sampled, sample_until_sure, within_tolerance};
use crate::machine::Machine;
use crate::motion::{Motion, MotionKind};
use crate::process::divided::{DividedBlock, LAST_BIT};
use crate::process::fault::{Fault, go_on};
use crate::process::pipeline::{
    BeforeAfter, Expected, KeptMotion, MotionChange, Outgoing, ReadBack, StepCheck, failed,
};
use crate::process::text::Stretch;
use crate::program::Dialect;

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
        machine: &Machine,
        parameters: &'a CcParameters,
        dialect: Dialect,
        effort: Effort<'a>,
    ) -> Self {
        Self {
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
        let (line, block) = (group.source.line, &group.checked.block);
        let segment = group.check_part(read, index, self.parameters.program.interpolation)?;
        let tolerance_mm = self.parameters.tolerance.mm();
        let found = if self.parameters.correction == Correction::Seed {
            sample_until_sure(block, &segment, tolerance_mm)
        } else {
            within_tolerance(block, &segment, tolerance_mm)
                .or_else(|found| {
                    let limit_mm = tolerance_mm * (1.0 + LAST_BIT);
                    if found.max_mm <= limit_mm { Ok(found) } else { Err(found) }
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
        self.parts.push((segment.fraction[1] - segment.fraction[0], found));
        group.check_time(read, &segment)?;
        if index + 1 < group.division.nodes.len() {
            return Ok(None);
        }
        let after = Sampled::join(self.parts.drain(..));
        self.found.record(line, block.line.length_mm, &group.checked.before, &after);
        Ok(Some(after))
    }
}
