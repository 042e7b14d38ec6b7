//! Dynamic programming over branch × turn: the cheapest path through all poses, with travels as hard limits.
//!
//! Cost is lexicographic: rewinds, then travel Σ(|Δu| + |Δv|), then Σ(|u| + |v|) if travels tie. A state is a
//! branch with a whole turn of each limited axis. An unlimited axis takes the nearest turn and needs no state. A
//! step costs as many operations as there are states, never their square: see [`super::turns`].

use std::ops::Range;

use super::cost::{Cost, NO_WAY, in_steps};
use super::grid::{Grid, Stage};
use super::pointing::nearest_integer;
use super::staying::Stays;
use super::two_way::Weights;

/// From this travel or Σ|word| on, a common part is subtracted from all states, so that sums stay exact.
const REBASE_DEG: f64 = 524_288.0;

/// The states of a path, first pose first.
#[derive(Default)]
pub(super) struct Way {
    states: Vec<u16>,
    /// Blocks in which no path changes its state, in order.
    kept: Vec<Range<usize>>,
}

impl Way {
    /// The states of these poses.
    pub(super) fn states(&self, poses: Range<usize>) -> &[u16] {
        self.states.get(poses).unwrap_or_default()
    }

    /// Whether it is known that the path enters these poses in one state and keeps it. Then no step passes ±180° or
    /// comes near [`super::REWIND_DEG`].
    pub(super) fn is_kept(&self, poses: &Range<usize>) -> bool {
        let found = self.kept.binary_search_by_key(&poses.start, |kept| kept.start).ok();
        found.and_then(|found| self.kept.get(found)).is_some_and(|kept| kept.end >= poses.end)
    }

    /// The number of poses.
    pub(super) fn len(&self) -> usize {
        self.states.len()
    }
}

/// The running choice: costs of all states at the latest pose, and the origin of every state where a path could
/// change it.
pub(super) struct Choice {
    pub(super) grid: Grid,
    pub(super) threshold_deg: f64,
    pub(super) costs: Vec<Cost>,
    pub(super) next: Vec<Cost>,
    /// Words of u, v of every state, in steps of 2⁻³⁰°.
    pub(super) words: Vec<[f64; 2]>,
    pub(super) next_words: Vec<[f64; 2]>,
    pub(super) latest: Stage,
    predecessors: Vec<u16>,
    /// Poses without predecessors in the list, because every path keeps its state there.
    kept: Vec<Range<usize>>,
    /// The number of poses so far.
    poses: usize,
    /// The number of warnings that every path has.
    pub(super) marked: usize,
    /// For one branch.
    pub(super) scratch: Vec<Cost>,
    /// For one row and one column.
    pub(super) row: Vec<Cost>,
    pairwise: bool,
}

impl Choice {
    pub(super) fn new(grid: Grid, threshold_deg: f64, poses: usize) -> Self {
        let states = grid.states();
        Self {
            grid,
            threshold_deg,
            costs: vec![NO_WAY; states],
            next: vec![NO_WAY; states],
            words: vec![[0.0; 2]; states],
            next_words: vec![[0.0; 2]; states],
            latest: Stage { words_deg: [[0.0; 2]; 2], alive: [false; 2], held: false },
            // Two states keep their state in most blocks.
            predecessors: Vec::with_capacity(if states == 2 { 0 } else { states * poses }),
            kept: Vec::new(),
            poses: 0,
            marked: 0,
            scratch: vec![NO_WAY; states / 2],
            row: vec![NO_WAY; (2 * grid.count[0]).max(grid.count[1])],
            // From half a turn on, more than one turn can be a step without a rewind.
            pairwise: threshold_deg.is_nan() || threshold_deg >= 180.0,
        }
    }

    /// The first pose: without cost, or as a step from `start` (words of u, v in degrees).
    pub(super) fn begin(&mut self, stage: &Stage, start_deg: Option<[f64; 2]>) -> bool {
        self.latest = *stage;
        self.poses = 1;
        let mut any = false;
        for state in 0..self.grid.states() {
            let (branch, words) = self.grid.words_deg(state, stage, start_deg);
            self.predecessors.push(0);
            self.costs[state] = NO_WAY;
            if !stage.alive[branch] || !(0..2).all(|k| self.grid.within(k, words[k])) {
                continue;
            }
            let mut cost = Cost { rewinds: 0.0, sum: words[0].abs() + words[1].abs(), ..NO_WAY };
            self.words[state] = words.map(in_steps);
            if let Some(start) = start_deg {
                // A held axis keeps the start's word: only the state with this very turn is alive.
                let (_, turns) = self.grid.parts(state);
                let turned = stage.words_deg[branch][0] + self.grid.turn_deg(0, turns[0]);
                if stage.held && self.grid.period[0] == 0.0 && (turned - start[0]).abs() > 1.0 {
                    continue;
                }
                let steps: [f64; 2] = std::array::from_fn(|k| (words[k] - start[k]).abs());
                cost.rewinds = f64::from(u8::from(steps[0].max(steps[1]) > self.threshold_deg));
                cost.travel = steps[0] + steps[1];
            }
            self.costs[state] = cost;
            any = true;
        }
        any
    }

    /// Advances one pose. False if no state of it can be reached.
    pub(super) fn advance(&mut self, stage: &Stage) -> bool {
        if self.pairwise {
            self.advance_pairwise(stage);
        } else {
            self.advance_by_turns(stage);
        }
        self.poses += 1;
        let mut any = false;
        let (mut least, mut least_sum) = (f64::INFINITY, f64::INFINITY);
        for (state, cost) in self.next.iter_mut().enumerate() {
            #[expect(clippy::cast_possible_truncation, reason = "states are at most 65535")]
            self.predecessors.push(cost.from as u16);
            if cost.rewinds.is_finite() {
                any = true;
                let words = self.next_words[state];
                cost.sum += words[0].abs() + words[1].abs();
                least = least.min(cost.travel);
                least_sum = least_sum.min(cost.sum);
            }
        }
        if any {
            rebase(&mut self.next, [least, least_sum]);
        }
        std::mem::swap(&mut self.costs, &mut self.next);
        std::mem::swap(&mut self.words, &mut self.next_words);
        self.latest = *stage;
        any
    }

    /// Advances several poses that all have both branches alive and not held, by weights computed in lanes.
    /// Returns the number of poses reached; it is smaller than asked for if no path leads to the next one.
    /// `TIES`: whether ties are marked.
    pub(super) fn advance_lanes<const TIES: bool>(
        &mut self,
        weights: &Weights,
        lanes: Range<usize>,
        last: &Stage,
    ) -> usize {
        let (start, end) = (lanes.start, lanes.end);
        let mut costs = [self.costs[0], self.costs[1]];
        let mut turns = self.turns();
        self.poses += lanes.len();
        self.predecessors.reserve(2 * lanes.len());
        let mut reached = 0;
        for lane in start..end {
            let step = |from: usize, to: usize| {
                let index = 2 * from + to;
                Cost {
                    rewinds: costs[from].rewinds + weights.rewinds[index][lane],
                    travel: costs[from].travel + weights.travel[index][lane],
                    ..costs[from]
                }
            };
            let mut next = costs;
            let mut next_turns = turns;
            for to in 0..2 {
                let (from_first, from_second) = (step(0, to), step(1, to));
                let from = usize::from(from_second.beats(&from_first));
                next[to] = if from == 1 { from_second } else { from_first };
                if TIES {
                    next[to].tied |= from_first.ties(&from_second);
                }
                let index = 2 * from + to;
                next_turns[to] = [
                    turns[from][0] + weights.turns_u[index][lane],
                    turns[from][1] + weights.turns_v[index][lane],
                ];
                let u = weights.words[2 * to][lane] + 360.0 * next_turns[to][0];
                let v = weights.words[2 * to + 1][lane] + 360.0 * next_turns[to][1];
                next[to].sum += u.abs() + v.abs();
                self.predecessors.push(u16::from(from == 1));
            }
            if next[0].rewinds.is_infinite() && next[1].rewinds.is_infinite() {
                break;
            }
            (costs, turns) = (next, next_turns);
            reached += 1;
        }
        self.costs.copy_from_slice(&costs);
        self.arrive_at(last, turns);
        reached
    }

    /// Advances several poses along both branches, if no path changes its branch there. False if one could, and then
    /// nothing is changed.
    pub(super) fn stay(&mut self, stays: &Stays, size: usize, last: &Stage) -> bool {
        let [mut first, mut second] = [self.costs[0], self.costs[1]];
        #[expect(clippy::float_cmp, reason = "small whole numbers")]
        let equal = first.rewinds == second.rewinds && first.rewinds.is_finite();
        if !equal {
            return false;
        }
        let totals = &stays.totals;
        let is_far_from_a_change = (first.travel - second.travel).abs() + totals.drift_deg < totals.room_deg;
        if !is_far_from_a_change {
            let (mut apart, mut clear) = (first.travel - second.travel, true);
            for lane in 0..size {
                clear &= apart.abs() < stays.room_deg[lane];
                apart += stays.travel_deg[0][lane] - stays.travel_deg[1][lane];
            }
            if !clear {
                return false;
            }
        }
        for (k, cost) in [&mut first, &mut second].into_iter().enumerate() {
            cost.travel += totals.travel_deg[k];
            cost.sum += totals.sum_deg[k];
        }
        let turns = self.turns();
        self.kept.push(self.poses..self.poses + size);
        self.poses += size;
        self.costs.copy_from_slice(&[first, second]);
        self.arrive_at(last, turns);
        true
    }

    /// Whole turns of each of two states beyond the principal words of the latest pose.
    pub(super) fn turns(&self) -> [[f64; 2]; 2] {
        std::array::from_fn(|state| {
            std::array::from_fn(|k| {
                let principal = in_steps(self.latest.words_deg[state][k]);
                nearest_integer((self.words[state][k] - principal) * (1.0 / 360.0))
            })
        })
    }

    /// The words of both of two states at the latest pose, and a common part off their travel if it grows large.
    fn arrive_at(&mut self, last: &Stage, turns: [[f64; 2]; 2]) {
        for ((words, principal), turns) in self.words.iter_mut().zip(last.words_deg).zip(turns) {
            *words = std::array::from_fn(|k| in_steps(principal[k]) + 360.0 * turns[k]);
        }
        self.latest = *last;
        let [first, second] = [self.costs[0], self.costs[1]];
        rebase(&mut self.costs, [first.travel.min(second.travel), first.sum.min(second.sum)]);
    }

    /// The words of a target state \[steps\]. Those of unlimited axes are still principal. `None` if out of
    /// travel.
    fn target(&self, stage: &Stage, branch: usize, turns: [usize; 2]) -> Option<[f64; 2]> {
        if !stage.alive[branch] {
            return None;
        }
        let words: [f64; 2] =
            std::array::from_fn(|k| stage.words_deg[branch][k] + self.grid.turn_deg(k, turns[k]));
        (0..2).all(|k| self.grid.within(k, words[k])).then(|| words.map(in_steps))
    }

    /// Every state from every other: for any threshold, and as a proof for the faster steps.
    fn advance_pairwise(&mut self, stage: &Stage) {
        let grid = self.grid;
        for state in 0..grid.states() {
            let (branch, turns) = grid.parts(state);
            self.next[state] = NO_WAY;
            let Some(target) = self.target(stage, branch, turns) else { continue };
            for from in 0..grid.states() {
                let source = self.costs[from];
                let (source_branch, source_turns) = grid.parts(from);
                if source.rewinds.is_infinite()
                    || (stage.held && (source_branch, source_turns[0]) != (branch, turns[0]))
                {
                    continue;
                }
                let du = if stage.held { 0.0 } else { grid.step(0, self.words[from][0], target[0]) };
                let dv = grid.step(1, self.words[from][1], target[1]);
                let (au, av) = (du.abs(), dv.abs());
                let rewind = f64::from(u8::from(au > self.threshold_deg || av > self.threshold_deg));
                let cost = source.plus_travel(au + av).coming_from(from);
                let cost = Cost { rewinds: cost.rewinds + rewind, ..cost };
                let better = cost.beats(&self.next[state]);
                self.next[state].keep_better(cost);
                if better {
                    self.next_words[state] = [self.words[from][0] + du, self.words[from][1] + dv];
                }
            }
        }
    }

    /// The final state of the cheapest path, if there is a path.
    pub(super) fn best(&self) -> Option<usize> {
        let mut best = NO_WAY;
        let mut state = None;
        for (n, cost) in self.costs.iter().enumerate() {
            if cost.rewinds.is_finite() && cost.beats(&best) {
                best = *cost;
                state = Some(n);
            }
        }
        state
    }

    /// Whether the paths that end in these states cost the same, except for Σ|word|.
    pub(super) fn ties(&self, state: usize, other: usize) -> bool {
        self.costs[state].ties(&self.costs[other])
    }

    /// The number of warnings along the path to this state: those of every path, and one for each rewind.
    pub(super) fn warnings(&self, state: usize) -> usize {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of poses")]
        let rewinds = self.costs[state].rewinds as usize;
        self.marked + rewinds
    }

    /// Whether the path to this state is the only one of its cost.
    pub(super) fn is_only(&self, state: usize) -> bool {
        !self.costs[state].tied
    }

    /// The path that ends in `state`.
    pub(super) fn way(&self, mut state: usize) -> Way {
        let mut way = vec![0; self.poses];
        let mut predecessors = self.predecessors.chunks_exact(self.grid.states()).rev();
        let mut kept = self.kept.iter().rev().peekable();
        let mut end = self.poses;
        while end > 0 {
            #[expect(clippy::cast_possible_truncation, reason = "states are at most 65535")]
            let chosen = state as u16;
            if let Some(range) = kept.next_if(|range| range.end == end) {
                way[range.clone()].fill(chosen);
                end = range.start;
                continue;
            }
            end -= 1;
            way[end] = chosen;
            let Some(from) = predecessors.next() else { break };
            state = usize::from(from[state]);
        }
        Way { states: way, kept: self.kept.clone() }
    }
}

/// Subtracts what the least travel and the least Σ|word| \[deg\] have beyond [`REBASE_DEG`] from all states.
fn rebase(costs: &mut [Cost], [travel, sum]: [f64; 2]) {
    if travel.max(sum) > REBASE_DEG {
        let [travel, sum] = [travel, sum].map(|least| REBASE_DEG * (least * (1.0 / REBASE_DEG)).floor());
        for cost in costs {
            cost.travel -= travel;
            cost.sum -= sum;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Travel;

    fn stream(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64) * 2.0_f64.powi(-52) - 1.0
        }
    }

    fn outcome(
        grid: Grid,
        stages: &[Stage],
        start: Option<[f64; 2]>,
        pairwise: bool,
    ) -> Option<(f64, f64, f64)> {
        let mut choice = Choice::new(grid, 120.0, stages.len());
        choice.pairwise = pairwise;
        for (n, stage) in stages.iter().enumerate() {
            if !(if n == 0 { choice.begin(stage, start) } else { choice.advance(stage) }) {
                return None;
            }
        }
        let (mut rewinds, mut travel, mut sum, mut previous) = (0.0, 0.0, 0.0, start);
        for (stage, state) in
            stages.iter().zip(choice.best().map(|state| choice.way(state)).unwrap_or_default().states)
        {
            let (_, words) = grid.words_deg(usize::from(state), stage, previous);
            if let Some(previous) = previous {
                let (du, dv) = ((words[0] - previous[0]).abs(), (words[1] - previous[1]).abs());
                rewinds += f64::from(u8::from(du.max(dv) > 120.0));
                travel += du + dv;
            }
            sum += words[0].abs() + words[1].abs();
            previous = Some(words);
        }
        Some((rewinds, travel, sum))
    }

    #[test]
    fn prefix_minima_find_what_pairs_find() {
        let travels = [
            None,
            Some(Travel { min: -120.0, max: 120.0 }),
            Some(Travel { min: -360.0, max: 360.0 }),
            Some(Travel { min: -200.0, max: 900.0 }),
            Some(Travel { min: 300.0, max: 1500.0 }),
        ];
        let mut compared = 0;
        for seed in 0..600_u32 {
            let mut next = stream(u64::from(seed) + 1);
            let mut pick = || travels[(0..4).map(|_| usize::from(next() > 0.0)).sum::<usize>()];
            let grid = Grid::new([pick(), pick()]);
            let step = [5.0, 60.0, 170.0][seed as usize % 3];
            let mut words = [[next() * 180.0, next() * 180.0], [next() * 180.0, next() * 180.0]];
            let mut stages = Vec::new();
            for n in 0..25 {
                let held = n > 0 && next() > 0.7;
                for branch in &mut words {
                    for (k, word) in branch.iter_mut().enumerate() {
                        if !(held && k == 0) {
                            *word += next() * step;
                            *word -= 360.0 * (*word / 360.0).round();
                        }
                    }
                }
                stages.push(Stage { words_deg: words, alive: [next() > -0.9, next() > -0.7], held });
            }
            let (by_pairs, by_minima) =
                (outcome(grid, &stages, None, true), outcome(grid, &stages, None, false));
            match (by_pairs, by_minima) {
                (Some(a), Some(b)) => {
                    compared += 1;
                    assert!((a.0 - b.0).abs() < 0.5, "rewinds, seed {seed}");
                    assert!((a.1 - b.1).abs() < 2e-6, "travel, seed {seed}: {a:?} {b:?}");
                }
                (a, b) => assert_eq!(a.is_some(), b.is_some(), "seed {seed}"),
            }
        }
        assert!(compared > 100, "{compared}");
    }
}
