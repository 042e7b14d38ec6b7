//! A whole program through the drives of its machine: the effect of servo lag on the part.

use std::ops::ControlFlow;

use super::parameters::SimulationParameters;
use super::sampler::{LinePeaks, Piece, Sampler};
use crate::machine::Machine;
use crate::motion::Motion;
use crate::process::fault::{Fault, LeftOut, LeftOutReason, LeftOuts, LineFaults};
use crate::process::set_up::{Need, SetUps, turns};
use crate::process::text::{LineCursor, Passages, ProgramReading, ProgramSource};
use crate::program::Dialect;
use crate::servo::{AxisLetter, ToolOutcome};

/// The result of a simulation.
#[derive(Debug, Clone, PartialEq)]
pub struct ProgramSimulation {
    /// The dialect in which it was read.
    pub dialect: Dialect,
    /// How the program was read.
    pub reading: ProgramReading,
    /// Blocks: non-empty lines that are not only comments.
    pub blocks: u64,
    /// Number of simulated motions.
    pub motions: u64,
    /// Number of passes: sequences of simulated motions between rapids and motions left out. Each starts from rest.
    pub passes: u64,
    /// Time of the simulated motions \[s\].
    pub duration_s: f64,
    /// X, Y, Z and the rotary axes in the profile's order.
    pub axes: [AxisLetter; 5],
    /// Following errors, contour error and trace.
    pub outcome: ToolOutcome,
    /// Motions that were not simulated.
    pub left_out: Vec<LeftOut>,
}

/// Simulates the motions of a program at feed through the drives (`math.md` §3). It measures the contour error of
/// the tool against the commanded path in W, given by the poses of the commanded samples. Only servo errors count,
/// neither interpolation nor location errors.
///
/// The control's interpolator is ideal: every block runs at its F (G94 along the tip, or degrees if only rotary
/// axes turn; G93 by its time). Axes are linear in machine interpolation, and the tip is straight with TCP. Motions
/// follow each other without a stop, unless a profile asks for one. Rapids and motions that cannot be followed are
/// left out. The next pass starts at rest.
///
/// # Errors
/// The program cannot be read, has no motion to simulate, or takes too many samples; a drive is missing, unstable
/// or too stiff.
pub fn simulate(
    machine: &Machine,
    parameters: &SimulationParameters,
    source: &dyn ProgramSource,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<ProgramSimulation, Fault> {
    simulate_lines(machine, parameters, source, Vec::new(), None, stop)
}

/// [`simulate`] for a program that was written from the upload. `lines` lead to the upload's lines; `peaks` gets
/// the largest contour error of every line.
///
/// # Errors
/// As for [`simulate`].
pub(in crate::process) fn simulate_lines(
    machine: &Machine,
    parameters: &SimulationParameters,
    source: &dyn ProgramSource,
    lines: Vec<LineCursor<'_>>,
    peaks: Option<LinePeaks<'_>>,
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<ProgramSimulation, Fault> {
    let program = parameters.program.with_surveyed_tools(None, Need::LENGTH, machine, source, stop)?;
    let parameters = &SimulationParameters { program, ..parameters.clone() };
    let mut outlook = Outlook::default();
    // Peaks are told line by line, in the order of the text.
    let as_it_runs = peaks.is_none();
    for_each_motion(machine, parameters, source, Vec::new(), as_it_runs, stop, &mut |piece| {
        outlook.see(piece);
        Ok(())
    })?;
    outlook.check(parameters)?;
    let mut sampler = Sampler::new(machine, parameters, outlook.fastest, stop);
    sampler.peaks = match peaks {
        Some(peaks) => Some(peaks),
        None => None,
    };
    sampler.tell_peaks(false)?;
    let mut left_out = LeftOuts::default();
    let mut take = |piece: SeenMotion<'_>| match piece {
        SeenMotion::Piece(motion, piece) => sampler.add(motion, *piece),
        SeenMotion::LeftOut(reason, line) => {
            left_out.add(reason, line);
            sampler.lift()
        }
    };
    let read = for_each_motion(machine, parameters, source, lines, as_it_runs, stop, &mut take)?;
    sampler.lift()?;
    sampler.tell_peaks(true)?;
    let Sampler { run, motions, passes, duration_s, axes, .. } = sampler;
    Ok(ProgramSimulation {
        dialect: read.dialect,
        reading: read.reading,
        blocks: read.blocks,
        motions,
        passes,
        duration_s,
        axes,
        outcome: run.finish()?,
        left_out: left_out.0,
    })
}

/// A motion as the simulation takes it.
#[derive(Clone, Copy)]
enum SeenMotion<'a> {
    Piece(&'a Motion, &'a Piece),
    /// A motion left out, and its line. Rapids have no reason.
    LeftOut(Option<LeftOutReason>, u64),
}

/// What is known of a program after reading it.
struct Text {
    dialect: Dialect,
    reading: ProgramReading,
    blocks: u64,
}

fn for_each_motion(
    machine: &Machine,
    parameters: &SimulationParameters,
    source: &dyn ProgramSource,
    lines: Vec<LineCursor<'_>>,
    as_it_runs: bool,
    stop: &dyn Fn() -> ControlFlow<()>,
    take: &mut dyn FnMut(SeenMotion<'_>) -> Result<(), Fault>,
) -> Result<Text, Fault> {
    let mut passages = Passages::open(source, machine, &parameters.program)?.with_lines(lines);
    if as_it_runs {
        passages = passages.following_its_run(machine, &parameters.program);
    }
    let (mut set_ups, mut faults) = (SetUps::new(machine, &parameters.program), LineFaults::default());
    passages.work(stop, |passage, _, _| {
        for motion in &passage.motions {
            match Piece::of(parameters, motion) {
                Ok(Some(piece)) => {
                    set_ups.enter(motion);
                    if set_ups.now.lacks_foreign_length() && turns(motion) {
                        take(SeenMotion::LeftOut(Some(LeftOutReason::OtherTool), motion.line))?;
                        continue;
                    }
                    // With either interpolation mode, the axis positions depend on the set-up while the tool turns.
                    if let Some(kind) = set_ups.now.missing_for_place().filter(|_| turns(motion)) {
                        faults.add(motion.line, passage.block_text(motion), kind);
                    }
                    take(SeenMotion::Piece(motion, &piece))?;
                }
                Ok(None) => {}
                Err(reason) => take(SeenMotion::LeftOut(reason, motion.line))?,
            }
        }
        Ok(())
    })?;
    if faults.total > 0 {
        return Err(Fault::Lines(faults));
    }
    Ok(Text { dialect: passages.dialect(), reading: passages.reading(), blocks: passages.blocks })
}

/// The result of a first reading: duration, speed and number of passes of the program.
#[derive(Debug, Default)]
struct Outlook {
    duration_s: f64,
    /// Largest speed along the length that F measures [mm/s, or deg/s].
    fastest: f64,
    motions: u64,
    passes: u64,
    left_out: u64,
    first_left_out: Option<(LeftOutReason, u64)>,
    under_way: bool,
}

/// Most samples in the averages of a profile. It limits their memory.
const MAX_AVERAGED: u64 = 1_000_000;

impl Outlook {
    fn see(&mut self, seen: SeenMotion<'_>) {
        match seen {
            SeenMotion::Piece(_, piece) => {
                self.duration_s += piece.duration_s;
                self.fastest = self.fastest.max(piece.length / piece.duration_s);
                self.motions += 1;
                self.passes += u64::from(!self.under_way);
                self.under_way = true;
            }
            SeenMotion::LeftOut(reason, line) => {
                self.left_out += u64::from(reason.is_some());
                self.first_left_out = self.first_left_out.or(reason.map(|reason| (reason, line)));
                self.under_way = false;
            }
        }
    }

    /// Refuses too costly work before it begins.
    fn check(&self, parameters: &SimulationParameters) -> Result<(), Fault> {
        if self.motions == 0 {
            return Err(Fault::NothingToSimulate { left_out: self.left_out, first: self.first_left_out });
        }
        let limit = parameters.max_samples;
        let period_s = parameters.period_s;
        let averages = parameters.profile.map_or([0; 2], |profile| profile.averages(self.fastest, period_s));
        let settling_s = parameters.drives.settling_s(&AxisLetter::ALL);
        let rest = settling_s / period_s + averages[0] as f64 + averages[1] as f64;
        if averages[0].saturating_add(averages[1]) as u64 > MAX_AVERAGED {
            return Err(Fault::TooCostly {
                what: "samples that the feed profile averages",
                limit: MAX_AVERAGED,
            });
        }
        let samples = self.duration_s / period_s + self.passes as f64 * rest;
        if samples <= limit as f64 {
            return Ok(());
        }
        Err(Fault::TooCostly { what: "samples of the simulation", limit })
    }
}
