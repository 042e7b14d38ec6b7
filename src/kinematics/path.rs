//! One set of joints for each pose of a path: `path` selection of §1.

use std::ops::ControlFlow;

use super::choice::{Choice, Grid, Stage};
use super::inverse::{ROTARY_RANK, least_excess, turn_range};
use super::lanes::{BLOCK, JointBlock, PointedBlock, PoseBlock, PoseSource, join, point};
use super::pointing::principal_deg;
use super::{
    InstructionSet, InverseError, JointLanes, Joints, Kinematics, PoseLanes, REACH_SLACK_RAD, ToolPose,
};
use crate::machine::{Motion, Travel};

/// A rotary step over this is a rewind [deg].
pub const REWIND_DEG: f64 = 120.0;
/// Largest number of poses times combinations of branch and turn that one path may have: bounds its memory.
pub const MAX_CELLS: usize = 1 << 26;
/// With more states than this the travels are first left out: if the way found then fits, it is the best.
const RELAX_ABOVE: usize = 64;

/// How one candidate of each pose is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Selection {
    /// The cheapest way through all poses (dynamic programming).
    #[default]
    Cheapest,
    /// At each pose the candidate nearest to the previous one: faster, but may run into a travel's end.
    Nearest,
}

/// What a path may assume.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathOptions {
    /// NC words of the rotary axes before the first pose, in the profile's order \[deg\]; without them the first
    /// pose costs nothing.
    pub start_words_deg: Option<[f64; 2]>,
    /// A rotary step over this is a rewind [deg].
    pub rewind_deg: f64,
    /// How to choose.
    pub selection: Selection,
    /// The widest instructions to use; the result does not depend on them.
    pub instructions: InstructionSet,
    /// Examine every pose singly instead of in lanes; the result is the same. For proving that.
    pub singly: bool,
}

impl Default for PathOptions {
    fn default() -> Self {
        Self {
            start_words_deg: None,
            rewind_deg: REWIND_DEG,
            selection: Selection::Cheapest,
            instructions: InstructionSet::Fastest,
            singly: false,
        }
    }
}

/// What is worth knowing about a pose of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathWarning {
    /// 0-based index of the pose.
    pub pose: usize,
    /// What happened.
    pub kind: WarningKind,
    /// Angle by which the tool axis misses the pose's [rad].
    pub axis_residual_rad: f64,
}

/// Kinds of [`PathWarning`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WarningKind {
    /// A rotary axis turns by more than the threshold to get here.
    Rewind,
    /// Inside the pole cone: the axis next to the workpiece was held.
    PoleHold,
    /// Beyond the reach limit by no more than the tilt of the location errors: best fit.
    ReachLimit,
}

/// Joints along a path, one set per pose.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Path {
    /// Axis positions; words through [`crate::machine::RotaryAxis::word_deg`].
    pub joints: JointLanes,
    /// |t·(u × v′)| of each pose: 0 at the pole and at the reach limit.
    pub conditioning: Vec<f64>,
    /// In the order of the poses.
    pub warnings: Vec<PathWarning>,
}

impl Path {
    /// The joints of one pose.
    #[must_use]
    pub fn get(&self, pose: usize) -> Option<Joints> {
        Some(Joints {
            linear_mm: [
                *self.joints.x_mm.get(pose)?,
                *self.joints.y_mm.get(pose)?,
                *self.joints.z_mm.get(pose)?,
            ]
            .into(),
            rotary_rad: [*self.joints.first_rad.get(pose)?, *self.joints.second_rad.get(pose)?],
        })
    }
}

impl Kinematics {
    /// Chooses one set of joints for each pose. Travels are hard, for X Y Z too; an unlimited axis takes the
    /// nearest turn. Cost: rewinds first, then travel Σ(|Δu| + |Δv|); travels within 1e-6° tie and the smaller
    /// Σ|angle| wins. Inside the pole cone ([`Kinematics::pole_cone_rad`]) u keeps its previous word (first pose:
    /// the start's, else that of the next pose outside, else 0), v fits best, the tip stays exact.
    ///
    /// `stop` is asked once per block of poses.
    ///
    /// # Errors
    /// The first pose without direction, out of reach or out of travel; too many turns; stopped.
    pub fn path(
        &self,
        poses: &[ToolPose],
        options: &PathOptions,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Path, InverseError> {
        self.path_of(poses, options, stop)
    }

    /// [`Kinematics::path`] for poses in arrays: faster, nothing is rearranged.
    ///
    /// # Errors
    /// As [`Kinematics::path`].
    pub fn path_lanes(
        &self,
        poses: &PoseLanes,
        options: &PathOptions,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Path, InverseError> {
        self.path_of(poses, options, stop)
    }

    /// Combinations of branch and turns kept per pose: for estimates before the work starts.
    #[must_use]
    pub fn path_states(&self) -> usize {
        let states = Grid::new(self.travel_deg).states();
        if states > RELAX_ABOVE { 2 } else { states }
    }

    fn path_of<P: PoseSource + ?Sized>(
        &self,
        poses: &P,
        options: &PathOptions,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Path, InverseError> {
        let start = options.start_words_deg.map(|words| self.profile_index.map(|index| words[index]));
        if let Some(words) = start {
            self.check_start(words)?;
        }
        if poses.count() == 0 {
            return Ok(Path::default());
        }
        let mut walk =
            Walk { kinematics: self, poses, options, start, stop, out: Path::default(), marks: Vec::new() };
        let grid = Grid::new(self.travel_deg);
        walk.examine()?;
        let chosen = match options.selection {
            Selection::Nearest => walk.choose_nearest(grid)?,
            Selection::Cheapest => match walk.choose_relaxed(grid)? {
                Some(chosen) => chosen,
                None => walk.choose_cheapest(grid)?,
            },
        };
        walk.join(&chosen)?;
        Ok(walk.out)
    }

    fn check_start(&self, words_deg: [f64; 2]) -> Result<(), InverseError> {
        for k in 0..2 {
            let commanded = words_deg[k];
            let axis = Motion::Rotary(self.profile_index[k]);
            let max_abs = crate::machine::Machine::MAX_TRAVEL_DEG;
            let Travel { min, max } = self.travel_deg[k].unwrap_or(Travel { min: -max_abs, max: max_abs });
            // what is not a number is outside too
            if !(Travel { min, max }).contains(commanded, super::TRAVEL_SLACK) {
                return Err(InverseError::StartOutOfTravel { axis, commanded, min, max });
            }
        }
        Ok(())
    }
}

const ALIVE: [u8; 2] = [1, 2];
const HELD: u8 = 4;
/// Near pole or reach limit: has a residual to be told.
const LIMIT: u8 = 8;

/// One path being solved. Until [`Walk::join`] the output's arrays hold the words of both branches: `x`, `y` those
/// of u, v of the first, `z`, `first` those of the second.
struct Walk<'a, P: ?Sized> {
    kinematics: &'a Kinematics,
    poses: &'a P,
    options: &'a PathOptions,
    /// In the order u, v [deg].
    start: Option<[f64; 2]>,
    stop: &'a dyn Fn() -> ControlFlow<()>,
    out: Path,
    marks: Vec<u8>,
}

/// The words of u, v of every pose \[deg\], whole turns included.
struct Chosen {
    u_deg: Vec<f64>,
    v_deg: Vec<f64>,
}

impl<P: PoseSource + ?Sized> Walk<'_, P> {
    fn go_on(&self) -> Result<(), InverseError> {
        match (self.stop)() {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(InverseError::Stopped),
        }
    }

    /// Solves all directions; poses near pole, reach limit or travel ends singly.
    fn examine(&mut self) -> Result<(), InverseError> {
        let count = self.poses.count();
        let kinematics = self.kinematics;
        let joints = &mut self.out.joints;
        for lane in [&mut joints.x_mm, &mut joints.y_mm, &mut joints.z_mm, &mut joints.first_rad] {
            lane.resize(count, 0.0);
        }
        self.out.conditioning.resize(count, 0.0);
        self.marks.resize(count, ALIVE[0] | ALIVE[1]);
        let cone = kinematics.pole_cone_rad();
        let cone_sin2 = (1.001 * cone).sin().powi(2);
        let linear_limited = kinematics.linear_travel_mm.iter().any(Option::is_some);
        let (mut block, mut pointed) = (Box::new(PoseBlock::new()), Box::new(PointedBlock::new()));
        // principal words of u of the latest pose, per branch, for those held; none yet: poses wait
        let mut held_u: Option<[f64; 2]> = self.start.map(|words| [principal_deg(words[0]); 2]);
        let mut waiting = 0;
        for begin in (0..count).step_by(BLOCK) {
            self.go_on()?;
            let size = self.poses.load(begin, &mut block);
            point(self.options.instructions, &kinematics.pointing, cone_sin2, &block, &mut pointed);
            let joints = &mut self.out.joints;
            joints.x_mm[begin..begin + size].copy_from_slice(&pointed.words_deg[0][..size]);
            joints.y_mm[begin..begin + size].copy_from_slice(&pointed.words_deg[1][..size]);
            joints.z_mm[begin..begin + size].copy_from_slice(&pointed.words_deg[2][..size]);
            joints.first_rad[begin..begin + size].copy_from_slice(&pointed.words_deg[3][..size]);
            self.out.conditioning[begin..begin + size].copy_from_slice(&pointed.conditioning[..size]);
            for (lane, margin) in pointed.margin[..size].iter().enumerate() {
                let tip_ok = (0..3).all(|k| block.tip_mm[k][lane].abs() <= super::MAX_COORDINATE_MM);
                let careful = !(*margin > 0.0) || !tip_ok || linear_limited || self.options.singly;
                if !careful {
                    continue;
                }
                let pose = begin + lane;
                if self.examine_one(pose, cone)? {
                    // inside the cone
                    if let Some(u_deg) = self.entry(pose, held_u) {
                        held_u = Some(u_deg);
                        self.hold(pose, u_deg)?;
                    }
                }
            }
            // poses before the first one outside the cone take its words
            if held_u.is_none() {
                let end = begin + size;
                while waiting < end && self.marks[waiting] & HELD != 0 {
                    waiting += 1;
                }
                if waiting < end || end == count {
                    let words = if waiting < count { self.u_words(waiting) } else { [0.0; 2] };
                    held_u = Some(words);
                    for pose in 0..waiting {
                        self.hold(pose, words)?;
                    }
                    for pose in waiting..end {
                        if self.marks[pose] & HELD != 0 {
                            let u_deg = self.entry(pose, held_u).unwrap_or(words);
                            self.hold(pose, u_deg)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// The words of u that a held pose keeps: those of the pose before, or what the path begins with.
    fn entry(&self, pose: usize, begins_with: Option<[f64; 2]>) -> Option<[f64; 2]> {
        let begins_with = begins_with?;
        Some(if pose == 0 { begins_with } else { self.u_words(pose - 1) })
    }

    fn u_words(&self, pose: usize) -> [f64; 2] {
        [self.out.joints.x_mm[pose], self.out.joints.z_mm[pose]]
    }

    /// Examines a pose singly; true if it is inside the pole cone.
    fn examine_one(&mut self, index: usize, cone_rad: f64) -> Result<bool, InverseError> {
        let kinematics = self.kinematics;
        let pose = self.poses.pose(index);
        let solution = kinematics.solution(index, &pose)?;
        let held = solution.polar_distance_rad <= cone_rad;
        if held {
            self.marks[index] = HELD;
            return Ok(true);
        }
        let words = solution.words_deg;
        self.set_words(index, words);
        self.out.conditioning[index] = solution.conditioning;
        let mut mark = if solution.axis_residual_rad > REACH_SLACK_RAD { LIMIT } else { 0 };
        for branch in 0..solution.branches {
            if self.linear_fits(index, words[branch]) {
                mark |= ALIVE[branch];
            }
        }
        self.marks[index] = mark;
        Ok(false)
    }

    fn set_words(&mut self, index: usize, words: [[f64; 2]; 2]) {
        let joints = &mut self.out.joints;
        joints.x_mm[index] = words[0][0];
        joints.y_mm[index] = words[0][1];
        joints.z_mm[index] = words[1][0];
        joints.first_rad[index] = words[1][1];
    }

    fn linear_fits(&self, index: usize, words_deg: [f64; 2]) -> bool {
        let tip_mm = self.poses.pose(index).tip_mm;
        let linear_mm = self.kinematics.joints_at(tip_mm, words_deg).linear_mm;
        self.kinematics.linear_miss(index, linear_mm).is_none()
    }

    /// Holds u at these words (one per branch by which the cone was entered); v fits best.
    fn hold(&mut self, index: usize, u_deg: [f64; 2]) -> Result<(), InverseError> {
        let pose = self.poses.pose(index);
        let axis = super::inverse::usable_axis(&pose).ok_or(InverseError::NoDirection { pose: index })?;
        let words = u_deg.map(|u| [u, self.kinematics.held_word_deg(axis, u)]);
        self.set_words(index, words);
        let mut mark = HELD;
        for branch in 0..2 {
            if self.linear_fits(index, words[branch]) {
                mark |= ALIVE[branch];
            }
        }
        self.marks[index] = mark;
        Ok(())
    }

    fn stage(&self, pose: usize) -> Stage {
        let joints = &self.out.joints;
        let mark = self.marks[pose];
        Stage {
            words_deg: [[joints.x_mm[pose], joints.y_mm[pose]], [joints.z_mm[pose], joints.first_rad[pose]]],
            alive: [mark & ALIVE[0] != 0, mark & ALIVE[1] != 0],
            held: mark & HELD != 0,
        }
    }

    /// Why no state of this pose can be reached.
    fn no_way(&self, pose: usize) -> InverseError {
        if self.marks[pose] & HELD == 0 {
            if let Err(error) = self.kinematics.candidates(pose, &self.poses.pose(pose), 0.0) {
                return error;
            }
            return InverseError::NoWay { pose };
        }
        let stage = self.stage(pose);
        let kinematics = self.kinematics;
        let mut told: Option<(f64, InverseError)> = None;
        for words in stage.words_deg {
            let linear_mm = kinematics.joints_at(self.poses.pose(pose).tip_mm, words).linear_mm;
            let mut misses = kinematics.linear_miss(pose, linear_mm);
            for k in 0..2 {
                if let (true, Some(travel)) =
                    (turn_range(words[k], kinematics.travel_deg[k]).is_empty(), kinematics.travel_deg[k])
                {
                    let (commanded, excess) = least_excess(words[k], travel);
                    let axis = Motion::Rotary(kinematics.profile_index[k]);
                    let (min, max) = (travel.min, travel.max);
                    let error = InverseError::OutOfTravel { pose, axis, commanded, min, max };
                    misses = Some((ROTARY_RANK + excess, error));
                }
            }
            if let Some((excess, error)) = misses
                && told.is_none_or(|(least, _)| excess < least)
            {
                told = Some((excess, error));
            }
        }
        told.map_or(InverseError::NoWay { pose }, |(_, error)| error)
    }

    fn choose_cheapest(&mut self, grid: Grid) -> Result<Chosen, InverseError> {
        let poses = self.poses.count();
        let states = grid.states();
        if states > usize::from(u16::MAX) || states.saturating_mul(poses) > MAX_CELLS {
            return Err(InverseError::TooManyStates { poses, states, max_cells: MAX_CELLS });
        }
        let mut choice = Choice::new(grid, self.options.rewind_deg, poses);
        for pose in 0..poses {
            if pose % BLOCK == 0 {
                self.go_on()?;
            }
            let stage = self.stage(pose);
            let reached = if pose == 0 { choice.begin(&stage, self.start) } else { choice.advance(&stage) };
            if !reached {
                return Err(self.no_way(pose));
            }
        }
        let states = choice.finish();
        Ok(self.follow(&grid, &states))
    }

    /// The words along the chosen states; those of axes without end by the nearest turn.
    fn follow(&mut self, grid: &Grid, states: &[u16]) -> Chosen {
        let mut previous = self.start;
        let (mut u_deg, mut v_deg) = (Vec::with_capacity(states.len()), Vec::with_capacity(states.len()));
        for (pose, state) in states.iter().enumerate() {
            let (_, words) = grid.words_deg(usize::from(*state), &self.stage(pose), previous);
            u_deg.push(words[0]);
            v_deg.push(words[1]);
            previous = Some(words);
        }
        Chosen { u_deg, v_deg }
    }

    /// With many turns: the way as if those axes had no end. No way within travels is cheaper, so if it fits after
    /// a shift by whole turns it is the answer.
    fn choose_relaxed(&mut self, grid: Grid) -> Result<Option<Chosen>, InverseError> {
        if grid.states() <= RELAX_ABOVE {
            return Ok(None);
        }
        let travel = self.kinematics.travel_deg;
        let one_turn = |k: usize| {
            let mut alone = [None; 2];
            alone[k] = travel[k];
            Grid::new(alone).states() > 2
        };
        let relaxed: [Option<Travel>; 2] =
            std::array::from_fn(|k| if one_turn(k) { None } else { travel[k] });
        let Ok(mut chosen) = self.choose_cheapest(Grid::new(relaxed)) else {
            self.go_on()?;
            return Ok(None);
        };
        for k in 0..2 {
            let (Some(travel), None) = (travel[k], relaxed[k]) else { continue };
            let words = if k == 0 { &mut chosen.u_deg } else { &mut chosen.v_deg };
            let Some(shift) = best_shift(words, travel, self.start.is_some()) else { return Ok(None) };
            for word in words {
                *word += shift;
            }
        }
        Ok(Some(chosen))
    }

    fn choose_nearest(&mut self, grid: Grid) -> Result<Chosen, InverseError> {
        let count = self.poses.count();
        let mut previous = self.start;
        let (mut u_deg, mut v_deg) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for pose in 0..count {
            if pose % BLOCK == 0 {
                self.go_on()?;
            }
            let stage = self.stage(pose);
            let Some(words) = grid.nearest(&stage, previous, self.options.rewind_deg) else {
                return Err(self.no_way(pose));
            };
            u_deg.push(words[0]);
            v_deg.push(words[1]);
            previous = Some(words);
        }
        Ok(Chosen { u_deg, v_deg })
    }

    /// Turns the chosen words into joints, block by block, and collects the warnings.
    fn join(&mut self, chosen: &Chosen) -> Result<(), InverseError> {
        let kinematics = self.kinematics;
        let chain = kinematics.linear_chain();
        let (mut block, mut joined) = (Box::new(PoseBlock::new()), Box::new(JointBlock::new()));
        self.out.joints.second_rad.resize(self.poses.count(), 0.0);
        let swapped = kinematics.profile_index[0] == 1;
        let mut previous = self.start;
        for begin in (0..self.poses.count()).step_by(BLOCK) {
            self.go_on()?;
            let size = self.poses.load(begin, &mut block);
            let end = begin + size;
            joined.words_deg[0][..size].copy_from_slice(&chosen.u_deg[begin..end]);
            joined.words_deg[1][..size].copy_from_slice(&chosen.v_deg[begin..end]);
            join(self.options.instructions, &chain, &block.tip_mm, &mut joined);
            let (first, second) = if swapped { (1, 0) } else { (0, 1) };
            let joints = &mut self.out.joints;
            joints.x_mm[begin..end].copy_from_slice(&joined.linear_mm[0][..size]);
            joints.y_mm[begin..end].copy_from_slice(&joined.linear_mm[1][..size]);
            joints.z_mm[begin..end].copy_from_slice(&joined.linear_mm[2][..size]);
            joints.first_rad[begin..end].copy_from_slice(&joined.rotary_rad[first][..size]);
            joints.second_rad[begin..end].copy_from_slice(&joined.rotary_rad[second][..size]);
            for lane in 0..size {
                let words = [joined.words_deg[0][lane], joined.words_deg[1][lane]];
                let step = previous.map_or(0.0, |p: [f64; 2]| {
                    let (du, dv) = ((words[0] - p[0]).abs(), (words[1] - p[1]).abs());
                    if du > dv { du } else { dv }
                });
                previous = Some(words);
                if step > self.options.rewind_deg || self.marks[begin + lane] & (HELD | LIMIT) != 0 {
                    self.warn(begin + lane, step, words);
                }
            }
        }
        Ok(())
    }

    fn warn(&mut self, index: usize, step_deg: f64, words_deg: [f64; 2]) {
        let mark = self.marks[index];
        let mut residual_rad = 0.0;
        if mark & (HELD | LIMIT) != 0 {
            let pose = self.poses.pose(index);
            let axis = super::inverse::usable_axis(&pose).unwrap_or(pose.axis);
            let (conditioning, residual) = self.kinematics.held_quality(axis, words_deg);
            residual_rad = residual;
            if mark & HELD != 0 {
                self.out.conditioning[index] = conditioning;
            }
        }
        let mut warn = |kind, axis_residual_rad| {
            self.out.warnings.push(PathWarning { pose: index, kind, axis_residual_rad });
        };
        if step_deg > self.options.rewind_deg {
            warn(WarningKind::Rewind, residual_rad);
        }
        if mark & HELD != 0 {
            warn(WarningKind::PoleHold, residual_rad);
        }
        if mark & LIMIT != 0 {
            warn(WarningKind::ReachLimit, residual_rad);
        }
    }
}

/// The shift by whole turns that brings all words into the travel with the smallest Σ|word|; with a start given
/// only no shift.
fn best_shift(words_deg: &[f64], travel: Travel, fixed: bool) -> Option<f64> {
    let (low, high) = words_deg
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), word| (low.min(*word), high.max(*word)));
    let slack = super::TRAVEL_SLACK;
    let first = ((travel.min - slack - low) / 360.0).ceil();
    let last = ((travel.max + slack - high) / 360.0).floor();
    if first > last || (fixed && !(first..=last).contains(&0.0)) {
        return None;
    }
    if fixed {
        return Some(0.0);
    }
    // Σ|word + 360 k| is least where the median word comes nearest to zero
    let mut sorted = words_deg.to_vec();
    sorted.sort_by(f64::total_cmp);
    let middle = (-sorted[sorted.len() / 2] / 360.0).round();
    let sum = |turns: f64| words_deg.iter().map(|word| (word + 360.0 * turns).abs()).sum::<f64>();
    [middle - 1.0, middle, middle + 1.0]
        .map(|turns| turns.clamp(first, last))
        .into_iter()
        .min_by(|a, b| sum(*a).total_cmp(&sum(*b)))
        .map(|turns| 360.0 * turns)
}
