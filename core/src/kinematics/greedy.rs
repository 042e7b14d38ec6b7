//! The nearest choice in one pass: each block is examined, chosen and joined while it is in the nearest cache.

use std::ops::Range;

use super::InverseError;
use super::examining::Examination;
use super::grid::{Grid, Stage};
use super::joining::Joiner;
use super::lanes::BLOCK;
use super::pointing::nearest_integer;
use super::pose_source::PoseSource;
use super::steady::{Bounds, Course, follow};
use super::walk::{HELD, PLAIN, Stop, Walk, branch_words, branch_words_mut};
use super::weighing::Weighed;

/// The choice so far.
struct Chosen {
    grid: Grid,
    bounds: Bounds,
    /// Words of u, v of the latest pose \[deg\].
    words_deg: Option<[f64; 2]>,
    /// Its branch.
    branch: usize,
    /// Memory to weigh a block, once there is one to weigh.
    weighed: Option<Weighed>,
}

impl<P: PoseSource + ?Sized, S: Stop + ?Sized> Walk<'_, P, S> {
    /// Solves, chooses the nearest state of each pose, and converts it to joints.
    pub(super) fn take_nearest(&mut self, grid: Grid) -> Result<(), InverseError> {
        let count = self.poses.count();
        let mut examination = self.begin(count);
        let mut chosen = Chosen {
            grid,
            bounds: Bounds::new(&self.kinematics.pointing, grid.travel, self.options.rewind_deg),
            words_deg: self.start,
            branch: 0,
            weighed: None,
        };
        let mut joiner = self.joiner();
        // Poses before this one are joined. Later ones may have to wait at the pole for the first pose outside.
        let mut done = 0;
        for begin in (0..count).step_by(BLOCK) {
            self.go_on()?;
            let end = count.min(begin + BLOCK);
            let before = examination.before;
            self.point(begin, &mut examination);
            let is_steady =
                done == begin && self.keep_course(&mut examination, &mut chosen, &mut joiner, begin..end);
            if !is_steady {
                self.examine(begin, &mut examination)?;
                if examination.is_waiting() && end < count {
                    continue;
                }
                if let Err(error) = self.choose_and_join(&mut chosen, &mut joiner, before, done..end) {
                    // A pose that cannot be solved at all is reported first.
                    self.examine_from(end, &mut examination)?;
                    return Err(error);
                }
            }
            done = end;
        }
        Ok(())
    }

    /// Chooses poses that are examined, and converts them to joints. `before` has both branches' words of the pose
    /// before them.
    fn choose_and_join(
        &mut self,
        chosen: &mut Chosen,
        joiner: &mut Joiner,
        mut before: [f64; 4],
        poses: Range<usize>,
    ) -> Result<(), InverseError> {
        for begin in poses.clone().step_by(BLOCK) {
            let block = begin..poses.end.min(begin + BLOCK);
            // The choice is written over these words.
            let last = self.both(block.end - 1);
            self.choose_nearest(chosen, before, block.clone())?;
            before = last;
            let places = self.places(&block);
            for (words, chosen) in joiner.words_deg.iter_mut().zip(branch_words(&self.out.joints)) {
                words[..block.len()].copy_from_slice(&chosen[places.clone()]);
            }
            self.join(joiner, block, false);
        }
        Ok(())
    }

    /// Goes on along the branch of the pose before, if the block is steady. False if it is not, and then nothing is
    /// changed.
    fn keep_course(
        &mut self,
        examination: &mut Examination,
        chosen: &mut Chosen,
        joiner: &mut Joiner,
        block: Range<usize>,
    ) -> bool {
        let Some(lanes) = &mut examination.lanes else { return false };
        let (begin, size) = (block.start, block.len());
        if lanes.care || (begin == 0 && self.start.is_some()) {
            return false;
        }
        let (set, pointing) = (self.options.instructions, &self.kinematics.pointing);
        if begin == 0 {
            // The first pose is chosen alone, and then entered without a step.
            let stage =
                Stage { words_deg: lanes.pointed.words_deg(pointing, 0), alive: [true; 2], held: false };
            let Some((branch, words)) = chosen.grid.nearest(&stage, None, self.options.rewind_deg) else {
                return false;
            };
            (chosen.branch, chosen.words_deg) = (branch, Some(words));
        }
        let Some(entered_deg) = chosen.words_deg else { return false };
        let course = Course { branch: chosen.branch, entered_deg };
        let words = &mut joiner.words_deg;
        if !follow(set, pointing, &chosen.bounds, course, &mut lanes.pointed, size, words) {
            if begin == 0 {
                chosen.words_deg = None;
            }
            return false;
        }
        if begin == 0 {
            // Without a turn added, so that a zero keeps its sign.
            [words[0][0], words[1][0]] = entered_deg;
        }
        let last_deg = words.each_ref().map(|words| words[size - 1]);
        if !self.join_within(joiner, begin, size) {
            chosen.words_deg = (begin > 0).then_some(entered_deg);
            return false;
        }
        chosen.words_deg = Some(last_deg);
        let places = self.places(&block);
        self.out.conditioning[places].copy_from_slice(&lanes.pointed.conditioning[..size]);
        let [[first_u, first_v], [second_u, second_v]] = lanes.pointed.words_deg(pointing, size - 1);
        examination.before = [first_u, first_v, second_u, second_v];
        true
    }

    /// Chooses the poses of a block. `before` has both branches' words of the pose before: the arrays there already
    /// hold the choice.
    fn choose_nearest(
        &mut self,
        chosen: &mut Chosen,
        before: [f64; 4],
        block: Range<usize>,
    ) -> Result<(), InverseError> {
        let (begin, end) = (block.start, block.end);
        if chosen.weighed.is_none() {
            chosen.weighed = self.lanes_of(chosen.grid);
        }
        if let Some(weighed) = &mut chosen.weighed {
            self.weigh(before, &block, false, weighed);
        }
        let mut pose = begin;
        while pose < end {
            // After a held pose the weights do not apply: they start from a branch's own words, not from the held
            // ones.
            let goes_on = pose > 0 && self.mark(pose - 1) & HELD == 0;
            if let (Some(weighed), Some(mut words), true) = (&chosen.weighed, chosen.words_deg, goes_on) {
                let left = self.places(&(pose..end));
                let place = left.start;
                let plain = self.marks[left].iter().take_while(|mark| **mark == PLAIN).count();
                let run = pose - begin..pose - begin + plain;
                let [u_deg, v_deg, ..] = branch_words_mut(&mut self.out.joints);
                let (u_deg, v_deg) = (&mut u_deg[place..place + plain], &mut v_deg[place..place + plain]);
                let taken = nearest_run(weighed, run, &mut chosen.branch, &mut words, u_deg, v_deg);
                chosen.words_deg = Some(words);
                pose += taken;
                if pose == end {
                    break;
                }
            }
            let stage = self.stage(pose);
            let nearest = chosen.grid.nearest(&stage, chosen.words_deg, self.options.rewind_deg);
            let Some((branch, words)) = nearest else { return Err(self.no_way(pose)) };
            chosen.branch = branch;
            self.choose(pose, words);
            chosen.words_deg = Some(words);
            pose += 1;
        }
        Ok(())
    }
}

/// Follows the nearest branches along lanes until something ties or is out of travel. Returns the number of lanes
/// taken; `branch` and `words` are those of the last one.
fn nearest_run(
    lanes: &Weighed,
    run: std::ops::Range<usize>,
    branch: &mut usize,
    words: &mut [f64; 2],
    u_deg: &mut [f64],
    v_deg: &mut [f64],
) -> usize {
    let Weighed { rules, words: principal_words, weights, .. } = lanes;
    let start = run.start;
    for lane in run.clone() {
        let from = *branch & 1;
        let nearest = weights.nearest[from][lane];
        let to = usize::from(nearest > 0.5);
        if nearest > 0.25 && nearest < 0.75 {
            return lane - start;
        }
        for k in 0..2 {
            let principal = principal_words[2 * to + k][lane];
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
