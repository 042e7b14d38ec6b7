//! The motions of a program as samples of the commands of all axes.

use std::collections::VecDeque;
use std::ops::ControlFlow;

use super::parameters::SimulationParameters;
use crate::contact::{BlockTime, block_time_s, rotary_rad};
use crate::geometry::{Vec3, angle_between};
use crate::kinematics::JointLanes;
use crate::machine::{Machine, Travel};
use crate::motion::{AxisWords, Interpolation, Motion, MotionKind, Unfollowable};
use crate::process::fault::{Fault, LeftOutReason};
use crate::process::set_up::SetUps;
use crate::servo::{AxisLetter, MovingAverage, ServoFault, ToolRun, letters_of};

/// Samples handed to the drives at a time, a multiple of a block of the stepping.
const CHUNK: usize = 1024;

/// Receives the largest contour error of a line \[mm\], line after line.
pub(in crate::process) type LinePeaks<'n> = &'n mut dyn FnMut(u64, f64) -> Result<(), Fault>;

/// One motion at feed.
#[derive(Debug, Clone, Copy)]
pub(in crate::process) struct Piece {
    ends: [AxisWords; 2],
    mode: Interpolation,
    pub(in crate::process) line: u64,
    /// The length that F measures: mm, or degrees if only rotary axes turn.
    pub(in crate::process) length: f64,
    pub(in crate::process) duration_s: f64,
    /// Unit direction of the linear words; `None` if they rest.
    direction: Option<Vec3>,
    /// Distance of its end from the start of the pass, in the unit of `length`.
    end: f64,
}

/// A motion that takes less time than this is skipped \[s\].
const INSTANT_S: f64 = 1e-12;
/// Linear words that change by less than this are at rest \[mm\].
const RESTING_MM: f64 = 1e-9;

impl Piece {
    /// The motion as a piece of a pass; `None` if it has no length.
    ///
    /// # Errors
    /// Why it is not simulated; `None` for a rapid.
    pub(in crate::process) fn of(
        parameters: &SimulationParameters,
        motion: &Motion,
    ) -> Result<Option<Self>, Option<LeftOutReason>> {
        match motion.kind {
            MotionKind::Rapid => return Err(None),
            MotionKind::Arc => return Err(Some(LeftOutReason::Arc)),
            MotionKind::Linear | MotionKind::Opaque => {}
        }
        match motion.unfollowable {
            Some(Unfollowable::Reference | Unfollowable::Return | Unfollowable::TurnToPlane) => {
                return Err(None);
            }
            Some(reason) => return Err(Some(LeftOutReason::NotFollowed(reason))),
            None if motion.offset_changed => return Err(Some(LeftOutReason::WorkOffsetChanged)),
            None => {}
        }
        let (Some(start), Some(end)) = (motion.start, motion.end) else {
            return Err(Some(LeftOutReason::PositionUnknown));
        };
        if start == end {
            return Ok(None);
        }
        let travel = Vec3::from(end.linear_mm) - Vec3::from(start.linear_mm);
        let path_mm = travel.norm();
        let time = BlockTime::of_words([&start, &end], motion.mm_per_unit);
        let duration_s = (motion.feed.mode.zip(motion.feed.value))
            .and_then(|(mode, _)| block_time_s(mode, motion.feed.raw, &time))
            .filter(|duration_s| duration_s.is_finite())
            .ok_or(Some(LeftOutReason::NoFeed))?;
        if duration_s < INSTANT_S {
            return Ok(None);
        }
        Ok(Some(Self {
            ends: [start, end],
            mode: motion.mode(parameters.program.interpolation),
            line: motion.line,
            length: if path_mm > RESTING_MM { path_mm } else { time.turn_deg },
            duration_s,
            direction: (path_mm > RESTING_MM).then(|| travel / path_mm),
            end: 0.0,
        }))
    }
}

/// Turns pieces into samples and hands these to the drives.
pub(in crate::process) struct Sampler<'a> {
    machine: &'a Machine,
    set_ups: SetUps,
    parameters: &'a SimulationParameters,
    pub(in crate::process) axes: [AxisLetter; 5],
    pub(in crate::process) run: ToolRun<'a>,
    /// Pieces on which later samples can lie.
    pieces: VecDeque<Piece>,
    averages: Option<[MovingAverage; 2]>,
    /// Lengths of the averages, if there is a profile.
    average_lengths: Option<[usize; 2]>,
    stop: &'a dyn Fn() -> ControlFlow<()>,
    /// Receives the largest contour error of every line.
    pub(in crate::process) peaks: Option<LinePeaks<'a>>,
    /// The line of the current samples, and its largest error so far \[mm\].
    peak: Option<(u64, f64)>,
    /// Distance of the last piece's end from the start of the pass.
    reached: f64,
    /// Time from the end of the last piece to the next sample \[s\].
    wait_s: f64,
    lanes: JointLanes,
    lines: Vec<u64>,
    samples: u64,
    pub(in crate::process) motions: u64,
    pub(in crate::process) passes: u64,
    pub(in crate::process) duration_s: f64,
}

impl<'a> Sampler<'a> {
    /// `fastest`: the largest speed of the program, which sets the averages of a profile.
    pub(in crate::process) fn new(
        machine: &'a Machine,
        parameters: &'a SimulationParameters,
        fastest: f64,
        stop: &'a dyn Fn() -> ControlFlow<()>,
    ) -> Self {
        let axes = letters_of(machine);
        let SimulationParameters { drives, period_s, plane_normal, .. } = parameters;
        let set_ups = SetUps::new(machine, &parameters.program);
        Self {
            machine,
            run: ToolRun::new(&set_ups.now.kinematics, axes, drives, *period_s, *plane_normal, 0),
            set_ups,
            parameters,
            axes,
            pieces: VecDeque::new(),
            averages: None,
            average_lengths: parameters.profile.map(|profile| profile.averages(fastest, *period_s)),
            stop,
            peaks: None,
            peak: None,
            reached: 0.0,
            wait_s: 0.0,
            lanes: JointLanes::default(),
            lines: Vec::new(),
            samples: 0,
            motions: 0,
            passes: 0,
            duration_s: 0.0,
        }
    }

    /// Adds a motion.
    pub(in crate::process) fn add(&mut self, motion: &Motion, mut piece: Piece) -> Result<(), Fault> {
        let period_s = self.parameters.period_s;
        if !self.set_ups.is_entered(motion) {
            self.lift()?;
            self.set_ups.enter(motion);
            self.run.set_up(&self.set_ups.now.kinematics);
        }
        // A step of position between two motions, for example by a change of interpolation, does not move
        // the axes.
        if self.pieces.back().is_some_and(|last| last.ends[1] != piece.ends[0] || last.mode != piece.mode) {
            self.lift()?;
        }
        let speed = piece.length / piece.duration_s;
        if let Some(last) = self.pieces.back() {
            if self.parameters.profile.is_some() && self.is_corner(last, &piece) {
                self.come_to_rest()?;
            }
        } else {
            self.passes += 1;
            self.averages =
                self.average_lengths.map(|lengths| lengths.map(|length| MovingAverage::new(length, 0.0)));
        }
        self.motions += 1;
        self.duration_s += piece.duration_s;
        let from = self.reached;
        self.reached += piece.length;
        piece.end = self.reached;
        self.pieces.push_back(piece);
        let first_s = self.wait_s;
        let count = ((piece.duration_s - first_s) / period_s).ceil().max(0.0);
        self.check_budget(count)?;
        let mut k = 0.0;
        while k < count {
            self.push(from + speed * (first_s + k * period_s))?;
            k += 1.0;
        }
        self.wait_s = first_s + count * period_s - piece.duration_s;
        Ok(())
    }

    /// Ends the pass. The command comes to rest and stays until the axes are at rest.
    pub(in crate::process) fn lift(&mut self) -> Result<(), Fault> {
        if self.pieces.is_empty() {
            return Ok(());
        }
        self.come_to_rest()?;
        self.flush()?;
        for _ in 0..self.run.settling_samples() {
            self.push(self.reached)?;
        }
        self.flush()?;
        self.run.lift();
        self.tell_peaks(false)?;
        self.pieces.clear();
        self.averages = None;
        (self.reached, self.wait_s) = (0.0, 0.0);
        Ok(())
    }

    /// The end of the last piece becomes a sample, and the averages run out.
    fn come_to_rest(&mut self) -> Result<(), Fault> {
        let dry = self.average_lengths.map_or(0, |[first, second]| first + second);
        self.check_budget(dry as f64)?;
        for _ in 0..=dry {
            self.push(self.reached)?;
        }
        self.wait_s = self.parameters.period_s;
        Ok(())
    }

    fn is_corner(&self, last: &Piece, next: &Piece) -> bool {
        match (last.direction, next.direction) {
            (Some(before), Some(after)) => {
                angle_between(before, after) > self.parameters.stop_at_corners_above_rad
            }
            (None, None) => false,
            _ => true,
        }
    }

    fn check_budget(&self, more: f64) -> Result<(), Fault> {
        let limit = self.parameters.max_samples;
        if self.samples as f64 + more > limit as f64 {
            return Err(Fault::TooCostly { what: "samples of the simulation", limit });
        }
        Ok(())
    }

    /// One sample of the command, this far along the pass.
    fn push(&mut self, distance: f64) -> Result<(), Fault> {
        let distance = match &mut self.averages {
            Some([first, second]) => second.push(first.push(distance)),
            None => distance,
        };
        while self.pieces.len() > 1 && self.pieces.front().is_some_and(|piece| piece.end < distance) {
            self.pieces.pop_front();
        }
        let Some(piece) = self.pieces.front() else { return Ok(()) };
        let u = (1.0 - (piece.end - distance) / piece.length).clamp(0.0, 1.0);
        let [from, to] = &piece.ends;
        let lerp = |a: f64, b: f64| a + (b - a) * u;
        let linear_mm: [f64; 3] = std::array::from_fn(|k| lerp(from.linear_mm[k], to.linear_mm[k]));
        let rotary_deg = std::array::from_fn(|k| lerp(from.rotary_deg[k], to.rotary_deg[k]));
        let rotary_rad = rotary_rad(self.machine, rotary_deg);
        let linear_mm = match piece.mode {
            Interpolation::Machine => linear_mm,
            Interpolation::Tcp => {
                self.set_ups.now.kinematics.linear_mm(Vec3::from(linear_mm), rotary_rad).into()
            }
        };
        self.check_travel(linear_mm, rotary_deg)?;
        self.lanes.push(linear_mm, rotary_rad);
        self.lines.push(piece.line);
        self.samples += 1;
        if self.lines.len() == CHUNK {
            self.flush()?;
        }
        Ok(())
    }

    /// Refuses words outside the machine's travel, as paths do.
    fn check_travel(&self, linear_mm: [f64; 3], rotary_deg: [f64; 2]) -> Result<(), Fault> {
        let linear = self.machine.linear_travel_mm().iter().zip(linear_mm);
        let rotary = self.machine.rotary_axes().iter().map(|axis| &axis.travel_deg).zip(rotary_deg);
        for (axis, (travel, commanded)) in self.axes.iter().zip(linear.chain(rotary)) {
            if let Some(travel) = travel
                && !travel.contains(commanded, Travel::WORD_SLACK)
            {
                let at_s = self.samples as f64 * self.parameters.period_s;
                let (axis, min, max) = (axis.as_char(), travel.min, travel.max);
                return Err(ServoFault::OutOfTravel { at_s, axis, commanded, min, max }.into());
            }
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), Fault> {
        if (self.stop)().is_break() {
            return Err(Fault::Cancelled);
        }
        self.run.follow(&self.lanes, &self.lines)?;
        self.lanes.clear();
        self.lines.clear();
        self.tell_peaks(false)
    }

    /// Hands on the lines that are complete; at the end of the program also the last line.
    pub(in crate::process) fn tell_peaks(&mut self, all: bool) -> Result<(), Fault> {
        let Some(peaks) = &mut self.peaks else { return Ok(()) };
        for (line, peak_mm) in self.run.take_line_peaks() {
            match &mut self.peak {
                Some((same, largest_mm)) if *same == line => *largest_mm = largest_mm.max(peak_mm),
                held => {
                    if let Some((line, largest_mm)) = held.replace((line, peak_mm)) {
                        peaks(line, largest_mm)?;
                    }
                }
            }
        }
        match self.peak.filter(|_| all) {
            Some((line, largest_mm)) => peaks(line, largest_mm),
            None => Ok(()),
        }
    }
}
