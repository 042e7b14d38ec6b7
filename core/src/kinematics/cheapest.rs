//! The cheapest choice: costs of all paths, block by block, and then the cheapest path from its end.

use std::ops::Range;

use super::choice::{Choice, Way};
use super::cost::SLACK_DEG;
use super::decided::{Along, Course};
use super::grid::Grid;
use super::joining::has_step_over;
use super::lanes::BLOCK;
use super::pointing::nearest_integer;
use super::pose_source::PoseSource;
use super::staying::{Stays, stay};
use super::walk::{HELD, LIMIT, PLAIN, Stop, Walk, branch_words};
use super::weighing::Weighed;
use super::{InverseError, MAX_CELLS, REWIND_DEG};

impl<P: PoseSource + ?Sized, S: Stop + ?Sized> Walk<'_, P, S> {
    /// Solves, chooses the cheapest path, and converts it to joints.
    pub(super) fn take_cheapest(&mut self, grid: Grid) -> Result<(), InverseError> {
        self.examine_all()?;
        let course = self.decide(grid)?;
        let mut previous = self.start;
        self.join_all(|walk, block, words| walk.follow_course(&course, block, &mut previous, words))
    }

    /// The cheapest way through all poses.
    pub(super) fn decide(&mut self, grid: Grid) -> Result<Course, InverseError> {
        if let Some(course) = self.relaxed(grid)? {
            return Ok(course);
        }
        let choice = self.costs::<false>(grid)?;
        let Some(state) = choice.best() else {
            return Ok(Course { along: Along::States(grid, Way::default()), warnings: 0 });
        };
        let warnings = choice.warnings(state);
        Ok(Course { along: Along::States(grid, choice.way(state)), warnings })
    }

    /// The costs of all paths; `TIES`: whether ties are marked.
    pub(super) fn costs<const TIES: bool>(&mut self, grid: Grid) -> Result<Choice, InverseError> {
        let poses = self.poses.count();
        let states = grid.states();
        if states > usize::from(u16::MAX) || states.saturating_mul(poses) > MAX_CELLS {
            self.bring_rest(0)?;
            return Err(InverseError::TooManyStates { poses, states, max_cells: MAX_CELLS });
        }
        let mut choice = Choice::new(grid, self.options.rewind_deg, poses);
        let mut lanes = self.lanes_of(grid);
        for begin in (0..poses).step_by(BLOCK) {
            self.go_on()?;
            let block = begin..poses.min(begin + BLOCK);
            self.bring(block.clone())?;
            choice.marked += self.marked(&block);
            if let Some(lanes) = &mut lanes {
                if self.stay(&mut choice, block.clone(), lanes) {
                    continue;
                }
                self.weigh(self.both(begin.saturating_sub(1)), &block, true, lanes);
            }
            let end = block.end;
            if let Err(error) = self.advance::<TIES>(&mut choice, block, lanes.as_ref()) {
                // A pose that cannot be solved at all is reported first.
                self.bring_rest(end)?;
                return Err(error);
            }
        }
        Ok(choice)
    }

    /// The number of marks in a block that are a warning each.
    fn marked(&self, block: &Range<usize>) -> usize {
        let marks = &self.marks[self.places(block)];
        marks.iter().map(|mark| usize::from(mark & HELD != 0) + usize::from(mark & LIMIT != 0)).sum()
    }

    /// Advances through a block, wherever the paths go.
    fn advance<const TIES: bool>(
        &self,
        choice: &mut Choice,
        block: Range<usize>,
        lanes: Option<&Weighed>,
    ) -> Result<(), InverseError> {
        let (begin, end) = (block.start, block.end);
        let mut pose = begin;
        while pose < end {
            let plain =
                self.marks[self.places(&(pose..end))].iter().take_while(|mark| **mark == PLAIN).count();
            if let (Some(lanes), true) = (lanes, pose > 0 && plain > 0) {
                let last = self.stage(pose + plain - 1);
                let run = pose - begin..pose - begin + plain;
                let reached = choice.advance_lanes::<TIES>(&lanes.weights, run, &last);
                if reached < plain {
                    return Err(self.no_way(pose + reached));
                }
                pose += plain;
                continue;
            }
            let stage = self.stage(pose);
            let reached = if pose == 0 { choice.begin(&stage, self.start) } else { choice.advance(&stage) };
            if !reached {
                return Err(self.no_way(pose));
            }
            pose += 1;
        }
        Ok(())
    }

    /// Advances through a whole block in which no path changes its branch. False if one could.
    fn stay(&self, choice: &mut Choice, block: Range<usize>, lanes: &mut Weighed) -> bool {
        let (begin, size) = (block.start, block.len());
        let places = self.places(&block);
        if begin == 0
            || size < BLOCK
            || self.marks[places.clone()].iter().fold(0, |any, mark| any | (mark ^ PLAIN)) != 0
        {
            return false;
        }
        let [first_u, first_v, second_u, second_v] =
            branch_words(&self.out.joints).map(|words| words[places.clone()].as_array());
        let (Some(first_u), Some(first_v), Some(second_u), Some(second_v)) =
            (first_u, first_v, second_u, second_v)
        else {
            return false;
        };
        let words_deg = [first_u, first_v, second_u, second_v];
        let [first, second] = choice.turns();
        let turns_deg = [first[0], first[1], second[0], second[1]].map(|turns| 360.0 * turns);
        let Weighed { rules, stays, .. } = lanes;
        let stays = stays.get_or_insert_with(|| Box::new(Stays::new()));
        stay(self.options.instructions, rules, self.both(begin - 1), turns_deg, words_deg, stays);
        choice.stay(stays, size, &self.stage(begin + size - 1))
    }

    /// The words of u and v along a path in a block. Unlimited axes take the nearest turn. True if it is known that all
    /// steps are clearly below [`REWIND_DEG`].
    pub(super) fn follow(
        &self,
        grid: &Grid,
        way: &Way,
        block: Range<usize>,
        previous: &mut Option<[f64; 2]>,
        words_deg: [&mut [f64]; 2],
    ) -> bool {
        let places = self.places(&block);
        let [first_u, first_v, second_u, second_v] =
            branch_words(&self.out.joints).map(|words| &words[places.clone()]);
        let branches = [[first_u, first_v], [second_u, second_v]];
        let [us, vs] = words_deg;
        let marks = &self.marks[places];
        let is_kept = way.is_kept(&block);
        let way = way.states(block.clone());
        let plain = grid.count == [1, 1];
        if let (true, Some(entered_deg), Some(state)) = (plain, *previous, way.first()) {
            let is_one_course = is_kept
                || (way.iter().fold(0, |all, here| all | (here ^ state)) == 0
                    && marks.iter().fold(0, |all, mark| all | mark) & HELD == 0);
            if is_one_course {
                grid.turn_once(branches[usize::from(*state) & 1], entered_deg, [&mut *us, &mut *vs]);
                if is_kept || has_short_steps(entered_deg, [us, vs]) {
                    *previous = us.last().zip(vs.last()).map(|(u, v)| [*u, *v]);
                    return true;
                }
            }
        }
        for (lane, state) in way.iter().enumerate() {
            let words = match *previous {
                Some([u, v]) if plain && marks[lane] & HELD == 0 => {
                    let [us, vs] = branches[usize::from(*state) & 1];
                    [grid.nearest_turn(0, us[lane], u), grid.nearest_turn(1, vs[lane], v)]
                }
                _ => grid.words_deg(usize::from(*state), &self.stage(block.start + lane), *previous).1,
            };
            [us[lane], vs[lane]] = words;
            *previous = Some(words);
        }
        false
    }
}

impl Grid {
    /// The words in the turn of the first: right if no later word is in another turn.
    fn turn_once(&self, principal_deg: [&[f64]; 2], entered_deg: [f64; 2], words_deg: [&mut [f64]; 2]) {
        for (k, words) in words_deg.into_iter().enumerate() {
            let Some(first) = principal_deg[k].first() else { return };
            let turn_deg = if self.period[k] > 0.0 {
                360.0 * nearest_integer((entered_deg[k] - first) * (1.0 / 360.0))
            } else {
                self.turn_deg(k, 0)
            };
            for (word, principal) in words.iter_mut().zip(principal_deg[k]) {
                *word = principal + turn_deg;
            }
        }
    }
}

/// Whether all steps are clearly below [`REWIND_DEG`].
fn has_short_steps(entered_deg: [f64; 2], words_deg: [&[f64]; 2]) -> bool {
    (0..2).all(|k| !has_step_over(REWIND_DEG - SLACK_DEG, entered_deg[k], words_deg[k]))
}
