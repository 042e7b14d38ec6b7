//! The work behind `path`: examine all directions, choose a way, make joints of it.

use std::ops::ControlFlow;

use super::choice::Choice;
use super::grid::{Grid, Stage};
use super::inverse::{ROTARY_RANK, least_excess, turn_range};
use super::lanes::{BLOCK, JointBlock, Lane, PointedBlock, PoseBlock, PoseSource, join, point};
use super::pointing::{nearest_integer, principal_deg};
use super::two_way::{Rules, Weights, weigh};
use super::{
    InverseError, Kinematics, MAX_CELLS, Path, PathOptions, PathWarning, REACH_SLACK_RAD, Selection,
    WarningKind,
};
use crate::geometry::trig;
use crate::machine::Motion;

const ALIVE: [u8; 2] = [1, 2];
/// Both branches, nothing to watch.
const PLAIN: u8 = 3;
const HELD: u8 = 4;
/// Near pole or reach limit: has a residual to be told.
const LIMIT: u8 = 8;

/// One path being solved. Until a choice is made the output's arrays hold the words of both branches: `x`, `y` those
/// of u, v of the first, `z`, `first` those of the second. Then `x`, `y` hold the chosen words of u, v, whole turns
/// included, until [`Walk::join`] makes joints of them.
pub(super) struct Walk<'a, P: ?Sized> {
    pub(super) kinematics: &'a Kinematics,
    pub(super) poses: &'a P,
    pub(super) options: &'a PathOptions,
    /// In the order u, v \[deg\].
    pub(super) start: Option<[f64; 2]>,
    pub(super) stop: &'a dyn Fn() -> ControlFlow<()>,
    pub(super) out: &'a mut Path,
    pub(super) marks: Vec<u8>,
}

impl<P: PoseSource + ?Sized> Walk<'_, P> {
    pub(super) fn go_on(&self) -> Result<(), InverseError> {
        match (self.stop)() {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(InverseError::Stopped),
        }
    }

    /// Solves all directions; poses near pole, reach limit or travel ends singly.
    pub(super) fn examine(&mut self) -> Result<(), InverseError> {
        let count = self.poses.count();
        let kinematics = self.kinematics;
        let joints = &mut self.out.joints;
        for lane in [
            &mut joints.x_mm,
            &mut joints.y_mm,
            &mut joints.z_mm,
            &mut joints.first_rad,
            &mut joints.second_rad,
        ] {
            lane.resize(count, 0.0);
        }
        self.out.warnings.clear();
        self.marks.clear();
        self.out.conditioning.resize(count, 0.0);
        self.marks.resize(count, ALIVE[0] | ALIVE[1]);
        let cone = kinematics.pole_cone_rad();
        let cone_sin2 = trig::sin_cos(1.001 * cone).0.powi(2);
        let linear_limited = kinematics.linear_travel_mm.iter().any(Option::is_some);
        let (mut block, mut pointed) = (Box::new(PoseBlock::new()), Box::new(PointedBlock::new()));
        // principal words of u of the latest pose, per branch, for those held; none yet: poses wait
        let mut held_u: Option<[f64; 2]> = self.start.map(|words| [principal_deg(words[0]); 2]);
        let mut waiting = 0;
        for begin in (0..count).step_by(BLOCK) {
            self.go_on()?;
            let (size, poses) = self.poses.block(begin, &mut block);
            point(self.options.instructions, &kinematics.pointing, cone_sin2, poses.axis, &mut pointed);
            let joints = &mut self.out.joints;
            joints.x_mm[begin..begin + size].copy_from_slice(&pointed.words_deg[0][..size]);
            joints.y_mm[begin..begin + size].copy_from_slice(&pointed.words_deg[1][..size]);
            joints.z_mm[begin..begin + size].copy_from_slice(&pointed.words_deg[2][..size]);
            joints.first_rad[begin..begin + size].copy_from_slice(&pointed.words_deg[3][..size]);
            self.out.conditioning[begin..begin + size].copy_from_slice(&pointed.conditioning[..size]);
            let sound = |lane: usize| {
                let tip_ok = |k: usize| u8::from(poses.tip_mm[k][lane].abs() <= super::MAX_COORDINATE_MM);
                u8::from(pointed.margin[lane] > 0.0) & tip_ok(0) & tip_ok(1) & tip_ok(2)
            };
            let all_singly = linear_limited || self.options.singly;
            // without a branch in the loop
            let none_singly = !all_singly && (0..size).fold(1, |all, lane| all & sound(lane)) == 1;
            for lane in 0..if none_singly { 0 } else { size } {
                if !all_singly && sound(lane) == 1 {
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
            for (k, word) in words.into_iter().enumerate() {
                if let (true, Some(travel)) =
                    (turn_range(word, kinematics.travel_deg[k]).is_empty(), kinematics.travel_deg[k])
                {
                    let (commanded, excess) = least_excess(word, travel);
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

    pub(super) fn choose_cheapest(&mut self, grid: Grid) -> Result<(), InverseError> {
        let choice = self.costs::<false>(grid)?;
        let way = choice.best().map(|state| choice.way(state)).unwrap_or_default();
        let mut words = [Vec::with_capacity(way.len()), Vec::with_capacity(way.len())];
        self.follow(&grid, &way, &mut words);
        self.choose_all(&words);
        Ok(())
    }

    /// The costs of all ways; `TIES`: whether ties are marked.
    pub(super) fn costs<const TIES: bool>(&mut self, grid: Grid) -> Result<Choice, InverseError> {
        let poses = self.poses.count();
        let states = grid.states();
        if states > usize::from(u16::MAX) || states.saturating_mul(poses) > MAX_CELLS {
            return Err(InverseError::TooManyStates { poses, states, max_cells: MAX_CELLS });
        }
        let mut choice = Choice::new(grid, self.options.rewind_deg, poses);
        let rules = grid.rules(self.options.rewind_deg).filter(|_| !self.options.singly);
        let mut weights = Box::new(Weights::new());
        let mut words = Box::new([[0.0; BLOCK]; 4]);
        for begin in (0..poses).step_by(BLOCK) {
            self.go_on()?;
            let end = poses.min(begin + BLOCK);
            if let Some(rules) = &rules {
                let before = self.both(begin.saturating_sub(1));
                self.weigh(before, begin, end, rules, &mut words, &mut weights);
            }
            let mut pose = begin;
            while pose < end {
                let plain = self.marks[pose..end].iter().take_while(|mark| **mark == PLAIN).count();
                if rules.is_some() && pose > 0 && plain > 0 {
                    let last = self.stage(pose + plain - 1);
                    let lanes = pose - begin..pose - begin + plain;
                    let reached = choice.advance_lanes::<TIES>(&weights, lanes, &last);
                    if reached < plain {
                        return Err(self.no_way(pose + reached));
                    }
                    pose += plain;
                    continue;
                }
                let stage = self.stage(pose);
                let reached =
                    if pose == 0 { choice.begin(&stage, self.start) } else { choice.advance(&stage) };
                if !reached {
                    return Err(self.no_way(pose));
                }
                pose += 1;
            }
        }
        Ok(choice)
    }

    /// The weights of the steps into the poses `begin..end`, from the words `before` on.
    fn weigh(
        &self,
        before: [f64; 4],
        begin: usize,
        end: usize,
        rules: &Rules,
        words: &mut [Lane; 4],
        weights: &mut Weights,
    ) {
        let joints = &self.out.joints;
        let stored = [&joints.x_mm, &joints.y_mm, &joints.z_mm, &joints.first_rad];
        for (lane, from) in words.iter_mut().zip(stored) {
            lane[..end - begin].copy_from_slice(&from[begin..end]);
        }
        let all = self.options.selection == Selection::Cheapest;
        weigh(self.options.instructions, rules, before, words, all, weights);
    }

    /// The words of u and of v along the states of a way; those of axes without end by the nearest turn.
    pub(super) fn follow(&self, grid: &Grid, way: &[u16], words_deg: &mut [Vec<f64>; 2]) {
        let mut previous = self.start;
        let joints = &self.out.joints;
        let branches = [(&joints.x_mm, &joints.y_mm), (&joints.z_mm, &joints.first_rad)];
        let plain = grid.count == [1, 1];
        for (pose, state) in way.iter().enumerate() {
            let words = match previous {
                Some([u, v]) if plain && self.marks[pose] & HELD == 0 => {
                    let (us, vs) = branches[usize::from(*state) & 1];
                    [grid.nearest_turn(0, us[pose], u), grid.nearest_turn(1, vs[pose], v)]
                }
                _ => grid.words_deg(usize::from(*state), &self.stage(pose), previous).1,
            };
            words_deg[0].push(words[0]);
            words_deg[1].push(words[1]);
            previous = Some(words);
        }
    }

    fn choose(&mut self, pose: usize, words_deg: [f64; 2]) {
        self.out.joints.x_mm[pose] = words_deg[0];
        self.out.joints.y_mm[pose] = words_deg[1];
    }

    pub(super) fn choose_all(&mut self, words_deg: &[Vec<f64>; 2]) {
        self.out.joints.x_mm.copy_from_slice(&words_deg[0]);
        self.out.joints.y_mm.copy_from_slice(&words_deg[1]);
    }

    pub(super) fn choose_nearest(&mut self, grid: Grid) -> Result<(), InverseError> {
        let count = self.poses.count();
        let mut previous = self.start;
        let rules = grid.rules(self.options.rewind_deg).filter(|_| !self.options.singly);
        let mut weights = Box::new(Weights::new());
        let mut lanes = Box::new([[0.0; BLOCK]; 4]);
        let mut branch = 0;
        // both branches' words of the pose before the block: the arrays there hold the choice already
        let mut before = [0.0; 4];
        for begin in (0..count).step_by(BLOCK) {
            self.go_on()?;
            let end = count.min(begin + BLOCK);
            if let Some(rules) = &rules {
                self.weigh(before, begin, end, rules, &mut lanes, &mut weights);
            }
            before = self.both(end - 1);
            let mut pose = begin;
            while pose < end {
                if let (Some(rules), Some(mut words), true) = (&rules, previous, pose > 0) {
                    let plain = self.marks[pose..end].iter().take_while(|mark| **mark == PLAIN).count();
                    let run = pose - begin..pose - begin + plain;
                    let joints = &mut self.out.joints;
                    let u_deg = &mut joints.x_mm[pose..pose + plain];
                    let v_deg = &mut joints.y_mm[pose..pose + plain];
                    let taken =
                        nearest_run(rules, &weights, &lanes, run, &mut branch, &mut words, u_deg, v_deg);
                    previous = Some(words);
                    pose += taken;
                    if pose == end {
                        break;
                    }
                }
                let stage = self.stage(pose);
                let Some((chosen, words)) = grid.nearest(&stage, previous, self.options.rewind_deg) else {
                    return Err(self.no_way(pose));
                };
                branch = chosen;
                self.choose(pose, words);
                previous = Some(words);
                pose += 1;
            }
        }
        Ok(())
    }

    fn both(&self, pose: usize) -> [f64; 4] {
        let joints = &self.out.joints;
        [joints.x_mm[pose], joints.y_mm[pose], joints.z_mm[pose], joints.first_rad[pose]]
    }

    /// Turns the chosen words into joints, block by block, and collects the warnings.
    pub(super) fn join(&mut self) -> Result<(), InverseError> {
        let kinematics = self.kinematics;
        let chain = kinematics.linear_chain();
        let (mut block, mut joined) = (Box::new(PoseBlock::new()), Box::new(JointBlock::new()));
        let swapped = kinematics.profile_index[0] == 1;
        let mut previous = self.start;
        for begin in (0..self.poses.count()).step_by(BLOCK) {
            self.go_on()?;
            let (size, poses) = self.poses.block(begin, &mut block);
            let end = begin + size;
            joined.words_deg[0][..size].copy_from_slice(&self.out.joints.x_mm[begin..end]);
            joined.words_deg[1][..size].copy_from_slice(&self.out.joints.y_mm[begin..end]);
            join(self.options.instructions, &chain, poses.tip_mm, &mut joined);
            let (first, second) = if swapped { (1, 0) } else { (0, 1) };
            let joints = &mut self.out.joints;
            joints.x_mm[begin..end].copy_from_slice(&joined.linear_mm[0][..size]);
            joints.y_mm[begin..end].copy_from_slice(&joined.linear_mm[1][..size]);
            joints.z_mm[begin..end].copy_from_slice(&joined.linear_mm[2][..size]);
            joints.first_rad[begin..end].copy_from_slice(&joined.rotary_rad[first][..size]);
            joints.second_rad[begin..end].copy_from_slice(&joined.rotary_rad[second][..size]);
            let entered = previous.unwrap_or([joined.words_deg[0][0], joined.words_deg[1][0]]);
            previous = Some([joined.words_deg[0][size - 1], joined.words_deg[1][size - 1]]);
            let marked = self.marks[begin..end].iter().fold(0, |all, mark| all | mark) & (HELD | LIMIT) != 0;
            let wide = (0..2)
                .any(|k| has_step_over(self.options.rewind_deg, entered[k], &joined.words_deg[k][..size]));
            if !marked && !wide {
                continue;
            }
            let mut previous = Some(entered);
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

/// Whether a step between neighbours is over the threshold: no branch in the loop.
fn has_step_over(threshold_deg: f64, entered_deg: f64, words_deg: &[f64]) -> bool {
    let over = |from: f64, to: f64| u8::from((to - from).abs() > threshold_deg);
    let first = words_deg.first().map_or(0, |word| over(entered_deg, *word));
    let before = words_deg.iter();
    before.zip(words_deg.get(1..).unwrap_or_default()).fold(first, |any, (from, to)| any | over(*from, *to))
        != 0
}

/// Follows the nearest branches along lanes as far as nothing ties and nothing is out of travel. Returns how many
/// lanes were taken; `branch` and `words` are those of the last one.
#[expect(clippy::too_many_arguments, reason = "slices of arrays that are borrowed apart")]
fn nearest_run(
    rules: &Rules,
    weights: &Weights,
    lanes: &[Lane; 4],
    run: std::ops::Range<usize>,
    branch: &mut usize,
    words: &mut [f64; 2],
    u_deg: &mut [f64],
    v_deg: &mut [f64],
) -> usize {
    let start = run.start;
    for lane in run.clone() {
        let from = *branch & 1;
        let nearest = weights.nearest[from][lane];
        let to = usize::from(nearest > 0.5);
        if nearest > 0.25 && nearest < 0.75 {
            return lane - start;
        }
        for k in 0..2 {
            let principal = lanes[2 * to + k][lane];
            words[k] = if rules.period[k] > 0.0 {
                principal + 360.0 * nearest_integer((words[k] - principal) * (1.0 / 360.0))
            } else {
                principal + rules.turn_deg[k]
            };
        }
        *branch = to;
        u_deg[lane - start] = words[0];
        v_deg[lane - start] = words[1];
    }
    run.len()
}
