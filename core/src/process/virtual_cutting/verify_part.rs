//! The course of a verification.

use std::sync::Arc;

use super::cut::CutPath;
use super::parameters::VerificationParameters;
use super::report::{Convergence, Effort, MotionCounts, ResidualSummary, Verification};
use crate::contact::CutterBody;
use crate::machine::{Machine, Tool};
use crate::motion::{Motion, MotionKind};
use crate::process::arc_path::ArcModes;
use crate::process::fault::{Fault, LeftOutReason, LeftOuts, LineFaults, WarningKind, Warnings};
use crate::process::set_up::{Need, SetUps, Stop};
use crate::process::text::{Passages, ProgramReading, ProgramSource};
use crate::program::{Batch, Dialect};
use crate::side_by_side::SideBySide;
use crate::surface::SurfacePoint;
use crate::units::Length;
use crate::wear::{CutLeave, NeedleBed, Residual, SweepBatch};

/// Number of pieces in the first batch.
const FIRST_BATCH: usize = 64;
/// Most pairs in one batch, estimated from the batch before: some tenths of a second.
const PAIRS_AT_ONCE: u64 = 4_000_000;
/// Factor by which the second computation is finer.
const FINER: f64 = 8.0;
/// Number of samples with the largest residuals that are cut again, and of evenly chosen ones.
const CUT_AGAIN: usize = 128;

/// Cuts a program virtually. Compares the result with the nominal surface, sample by sample, along the normal (P3
/// §4.2). [`NeedleBed`] defines the residual.
///
/// Every motion cuts. G1 and arcs follow the true path of the machine or of the tip, with turning rotary axes, and
/// with location errors if the set-up applies them. G0 is straight in its words, although controls may run each
/// axis at its own speed. Motions of unknown course are left out and counted: their cuts are missing. Travel is not
/// checked. The pieces of a motion are nowhere farther than `resolution` from it. A few hundred samples are then
/// cut again eight times finer, to show how far residuals change.
///
/// # Errors
/// Invalid parameters or samples; a program that cannot be read, has no motion that can be followed, or divides
/// into too many pieces.
pub fn verify_part(
    machine: &Machine,
    parameters: &VerificationParameters,
    samples: &[SurfacePoint],
    source: &dyn ProgramSource,
    parts: &dyn SideBySide,
    stop: &Stop<'_>,
) -> Result<Verification, Fault> {
    let faults = parameters.faults(samples);
    if !faults.is_empty() {
        return Err(Fault::Verification(faults));
    }
    let need =
        Need { cutter: true, stated_by: "`tool`", agreement: true, leaves_unknown: true, ..Need::LENGTH };
    let program = parameters.program.with_surveyed_tools(parameters.tool, need, machine, source, stop)?;
    let parameters = &VerificationParameters { program, ..parameters.clone() };
    let workshop = Workshop { machine, parameters, source, parts, stop };
    let found = workshop.cut(samples, parameters.resolution, parameters.max_pieces)?;
    if found.motions.total() == 0 {
        let first = found.left_out.0.iter().min_by_key(|kind| kind.first_line);
        return Err(Fault::NothingToCut {
            left_out: found.left_out.0.iter().map(|kind| kind.count).sum(),
            first: first.map(|kind| (kind.reason, kind.first_line)),
        });
    }
    let residuals = found.bed.residuals();
    let convergence = workshop.cut_again(samples, &residuals)?;
    let counts = found.bed.counts();
    let summary = ResidualSummary::of(samples, &residuals, parameters.limit);
    let mut warnings = found.warnings;
    if summary.uncut > 0 {
        warnings.add(WarningKind::Uncut, None).count = summary.uncut;
    }
    Ok(Verification {
        dialect: found.dialect,
        reading: found.reading,
        blocks: found.blocks,
        motions: found.motions,
        left_out: found.left_out.0,
        warnings: warnings.into_list(),
        summary,
        convergence,
        effort: Effort { pieces: found.pieces, pairs: counts.pairs, cuts: counts.cuts },
        residuals,
    })
}

/// Everything that stays the same for all cuts.
struct Workshop<'a> {
    machine: &'a Machine,
    parameters: &'a VerificationParameters,
    source: &'a dyn ProgramSource,
    parts: &'a dyn SideBySide,
    stop: &'a Stop<'a>,
}

/// The result of a cut.
struct Found {
    bed: NeedleBed,
    dialect: Dialect,
    reading: ProgramReading,
    blocks: u64,
    motions: MotionCounts,
    left_out: LeftOuts,
    warnings: Warnings,
    pieces: u64,
}

impl Workshop<'_> {
    /// Cuts these samples with the whole program.
    fn cut(&self, samples: &[SurfacePoint], resolution: Length, max_pieces: u64) -> Result<Found, Fault> {
        let Self { machine, parameters, .. } = *self;
        let bed = NeedleBed::new(samples, parameters.stock, self.stop).ok_or(Fault::Cancelled)?;
        let mut passages = Passages::open(self.source, machine, &parameters.program)?
            .following_its_run(machine, &parameters.program);
        let mut faults = LineFaults::default();
        let mut mill = Mill {
            workshop: self,
            set_ups: SetUps::new(machine, &parameters.program),
            body: None,
            resolution_mm: resolution.mm(),
            max_pieces,
            bed,
            batch: SweepBatch::new(),
            modes: ArcModes::default(),
            full: FIRST_BATCH,
            motions: MotionCounts::default(),
            left_out: LeftOuts::default(),
            warnings: Warnings::default(),
            pieces: 0,
        };
        passages.work(self.stop, |passage, _, _| {
            let mut seen = 0;
            for motion in &passage.motions {
                mill.scan(&passage.batch, &mut seen, motion.block as usize + 1);
                if !mill.enter(motion)? {
                    mill.left_out.add(Some(LeftOutReason::OtherTool), motion.line);
                    continue;
                }
                match CutPath::of(parameters, mill.modes, &passage.batch, motion) {
                    Ok(Some(course)) => {
                        let missing = mill.set_ups.now.missing_for_place();
                        if let Some(kind) = missing.filter(|_| course.hangs_on_set_up()) {
                            faults.add(motion.line, passage.block_text(motion), kind);
                        }
                        if faults.total == 0 {
                            mill.run(&course)?;
                        }
                    }
                    Ok(None) => {}
                    Err(reason) => mill.left_out.add(Some(reason), motion.line),
                }
            }
            mill.scan(&passage.batch, &mut seen, passage.batch.blocks().len());
            Ok(())
        })?;
        if faults.total > 0 {
            return Err(Fault::Lines(faults));
        }
        mill.flush()?;
        passages.warn(&mut mill.warnings);
        let Mill { bed, motions, left_out, warnings, pieces, .. } = mill;
        let (dialect, blocks) = (passages.dialect(), passages.blocks);
        let reading = passages.reading();
        Ok(Found { bed, dialect, reading, blocks, motions, left_out, warnings, pieces })
    }

    /// Cuts some samples again with finer pieces.
    fn cut_again(
        &self,
        samples: &[SurfacePoint],
        residuals: &[Option<Residual>],
    ) -> Result<Convergence, Fault> {
        let resolution = Length::from_mm(self.parameters.resolution.mm() / FINER);
        // The number of pieces grows with the root of the resolution, so never beyond this.
        let max_pieces = self.parameters.max_pieces.saturating_mul(4);
        let chosen = chosen(residuals);
        let again: Vec<SurfacePoint> = chosen.iter().map(|&index| samples[index]).collect();
        let finer = self.cut(&again, resolution, max_pieces)?.bed.residuals();
        let mut max_change_mm: f64 = 0.0;
        let mut cut_once = 0;
        for (&index, finer) in chosen.iter().zip(finer) {
            match (residuals[index], finer) {
                (Some(before), Some(after)) => {
                    max_change_mm = max_change_mm.max((before.residual_mm - after.residual_mm).abs());
                }
                (None, None) => {}
                _ => cut_once += 1,
            }
        }
        let max_change = Length::from_mm(max_change_mm);
        Ok(Convergence { samples: chosen.len() as u64, resolution, max_change, cut_once })
    }
}

/// Indices of the samples with the largest residuals and of evenly chosen ones, each once and in order.
fn chosen(residuals: &[Option<Residual>]) -> Vec<usize> {
    let size = |index: usize| residuals[index].map_or(-1.0, |residual| residual.residual_mm.abs());
    let mut order: Vec<usize> = (0..residuals.len()).collect();
    if order.len() > CUT_AGAIN {
        order.select_nth_unstable_by(CUT_AGAIN, |&a, &b| size(b).total_cmp(&size(a)).then(a.cmp(&b)));
        order.truncate(CUT_AGAIN);
    }
    order.extend((0..CUT_AGAIN).map(|k| k * residuals.len() / CUT_AGAIN));
    order.sort_unstable();
    order.dedup();
    order
}

/// The cutting in progress.
struct Mill<'a> {
    workshop: &'a Workshop<'a>,
    set_ups: SetUps,
    /// The body of the tool in the spindle.
    body: Option<(Tool, CutterBody)>,
    resolution_mm: f64,
    max_pieces: u64,
    bed: NeedleBed,
    batch: SweepBatch,
    modes: ArcModes,
    /// Number of pieces worth cutting together, estimated from the last batch.
    full: usize,
    motions: MotionCounts,
    left_out: LeftOuts,
    warnings: Warnings,
    pieces: u64,
}

impl Mill<'_> {
    /// Looks for codes that motions do not show, in the blocks from `seen` on.
    fn scan(&mut self, batch: &Batch, seen: &mut usize, end: usize) {
        for block in batch.blocks().get(*seen..end).unwrap_or_default() {
            self.modes.see(batch.words(block));
        }
        *seen = end;
    }

    /// Changes to the set-up and cutter of a motion. Returns whether its tool is known.
    fn enter(&mut self, motion: &Motion) -> Result<bool, Fault> {
        self.set_ups.enter(motion);
        let Some(tool) = self.set_ups.now.cutter() else { return Ok(false) };
        if self.body.as_ref().is_none_or(|(known, _)| *known != tool) {
            // The pieces of the tool before are cut with its body.
            self.flush()?;
            let body = self.workshop.parameters.body(&tool);
            let body = body.map_err(|fault| Fault::Verification(vec![fault.into()]))?;
            self.body = Some((tool, body));
        }
        Ok(true)
    }

    /// Cuts along one motion.
    fn run(&mut self, course: &CutPath) -> Result<(), Fault> {
        let machine = self.workshop.machine;
        let kinematics = &*Arc::clone(&self.set_ups.now.kinematics);
        let by_rapid = course.kind == MotionKind::Rapid;
        match course.kind {
            MotionKind::Rapid => self.motions.rapids += 1,
            MotionKind::Arc => self.motions.arcs += 1,
            MotionKind::Linear | MotionKind::Opaque => self.motions.linear += 1,
        }
        let Some((_, body)) = self.body else { return Ok(()) };
        let pieces = course.pieces(machine, kinematics, &body, self.resolution_mm);
        self.pieces = self.pieces.saturating_add(pieces);
        if self.pieces > self.max_pieces {
            let what = "straight pieces that the program's motions divide into";
            return Err(Fault::TooCostly { what, limit: self.max_pieces });
        }
        let mut from = course.pose_at(machine, kinematics, 0.0);
        for index in 1..=pieces {
            let to = course.pose_at(machine, kinematics, index as f64 / pieces as f64);
            self.batch.push(&body, [&from, &to], self.resolution_mm, course.line, by_rapid);
            if self.batch.len() >= self.full {
                self.flush()?;
            }
            from = to;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), Fault> {
        if (self.workshop.stop)().is_break() {
            return Err(Fault::Cancelled);
        }
        let Some((_, body)) = &self.body else { return Ok(()) };
        let before = self.bed.counts().work();
        let max_pairs = self.workshop.parameters.max_pairs;
        // One more than allowed: if the work stops at this limit, it has exceeded the allowance.
        let leave = CutLeave::new(max_pairs.saturating_sub(before).saturating_add(1), self.workshop.stop);
        let done = self.bed.cut(body, &self.batch, &leave, self.workshop.parts);
        self.batch.clear();
        let pairs = self.bed.counts().work();
        if pairs > max_pairs {
            let what = "comparisons of samples with straight pieces of motion";
            return Err(Fault::TooCostly { what, limit: max_pairs });
        }
        if done.is_break() {
            return Err(Fault::Cancelled);
        }
        // Many samples in one place: fewer pieces together, so that a stop takes effect soon.
        let share = PAIRS_AT_ONCE as f64 / (pairs - before).max(1) as f64;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "between 1 and a batch")]
        let full = (self.full as f64 * share.clamp(0.25, 4.0)).clamp(1.0, SweepBatch::FULL as f64) as usize;
        self.full = full;
        Ok(())
    }
}
