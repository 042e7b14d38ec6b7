//! Dynamic programming over branch × turn: the cheapest way through all poses, hard travels included.
//!
//! Cost is lexicographic: rewinds, then travel Σ(|Δu| + |Δv|), then Σ(|u| + |v|) where travels tie. A state is a
//! branch with a whole turn of each limited axis; an unlimited axis takes the nearest turn and needs no state.
//! Few states are compared pair by pair; many through prefix minima along each axis, so that a step costs as
//! many operations as there are states, never their square.

use super::grid::{Grid, Stage};
use super::pointing::nearest_integer;
use super::two_way::Weights;

/// Travels closer than this tie \[deg\].
pub(super) const TIE_DEG: f64 = 1e-6;
/// Words are compared in steps of 2⁻³⁰° so that sums of travels are exact and symmetric solutions tie.
pub(super) const STEPS_PER_DEG: f64 = 1_073_741_824.0;
/// Up to this many states are compared pair by pair.
const PAIRWISE: usize = 12;
/// From this travel on a common part is taken off all states: sums stay exact.
const REBASE_DEG: f64 = 524_288.0;

impl Grid {
    /// The branch and its words \[deg\] nearest to `previous_deg` at a stage (without it: nearest to zero), or `None` if all are
    /// out of travel. Same order of costs as the dynamic programming, one step far.
    #[inline]
    pub(super) fn nearest(
        &self,
        stage: &Stage,
        previous_deg: Option<[f64; 2]>,
        threshold_deg: f64,
    ) -> Option<(usize, [f64; 2])> {
        let from = previous_deg.unwrap_or([0.0; 2]);
        let mut best = NO_WAY;
        let mut chosen = None;
        for branch in 0..2 {
            if !stage.alive[branch] {
                continue;
            }
            let mut words = [0.0; 2];
            let mut reachable = true;
            for k in 0..2 {
                let principal = stage.words_deg[branch][k];
                if k == 0 && stage.held && previous_deg.is_some() {
                    words[k] = from[k];
                    continue;
                }
                words[k] = if previous_deg.is_none() && self.period[k] > 0.0 {
                    principal
                } else {
                    principal + 360.0 * nearest_integer((from[k] - principal) * (1.0 / 360.0))
                };
                if self.within(k, words[k]) {
                    continue;
                }
                let turns = super::inverse::turn_range(principal, self.travel[k]);
                let nearest = turns
                    .map(|turn| principal + 360.0 * f64::from(turn))
                    .min_by(|a, b| (a - from[k]).abs().total_cmp(&(b - from[k]).abs()));
                match nearest {
                    Some(word) => words[k] = word,
                    None => reachable = false,
                }
            }
            if !reachable {
                continue;
            }
            let [du, dv]: [f64; 2] = std::array::from_fn(|k| (in_steps(words[k]) - in_steps(from[k])).abs());
            let rewind = previous_deg.is_some() && (du > threshold_deg || dv > threshold_deg);
            let cost = Cost {
                rewinds: f64::from(u8::from(rewind)),
                travel: if previous_deg.is_some() { du + dv } else { 0.0 },
                sum: words[0].abs() + words[1].abs(),
                from: 0,
            };
            if cost.beats(&best) {
                best = cost;
                chosen = Some((branch, words));
            }
        }
        chosen
    }
}

/// What a way to a state has cost so far; infinite rewinds: there is none.
#[derive(Debug, Clone, Copy)]
struct Cost {
    rewinds: f64,
    travel: f64,
    sum: f64,
    from: u32,
}

const NO_WAY: Cost = Cost { rewinds: f64::INFINITY, travel: 0.0, sum: 0.0, from: 0 };

impl Cost {
    #[inline]
    fn beats(&self, other: &Self) -> bool {
        let travel = self.travel - other.travel;
        self.rewinds < other.rewinds
            || (self.rewinds <= other.rewinds
                && (travel < -TIE_DEG || (travel <= TIE_DEG && self.sum < other.sum)))
    }
    #[inline]
    fn keep_better(&mut self, other: Self) {
        if other.beats(self) {
            *self = other;
        }
    }
    fn plus_travel(self, travel: f64) -> Self {
        Self { travel: self.travel + travel, ..self }
    }
}

/// The running choice: costs of all states at the latest pose and where every state came from.
pub(super) struct Choice {
    pub(super) grid: Grid,
    threshold_deg: f64,
    costs: Vec<Cost>,
    next: Vec<Cost>,
    /// Words of u, v of every state, in steps of 2⁻³⁰°.
    words: Vec<[f64; 2]>,
    next_words: Vec<[f64; 2]>,
    latest: Stage,
    predecessors: Vec<u16>,
    scratch: Vec<Cost>,
    pairwise: bool,
}

fn in_steps(word_deg: f64) -> f64 {
    nearest_integer(word_deg * STEPS_PER_DEG) * (1.0 / STEPS_PER_DEG)
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
            predecessors: Vec::with_capacity(states * poses),
            scratch: vec![NO_WAY; states],
            pairwise: states <= PAIRWISE,
        }
    }

    /// The first pose: free of cost, or stepped to from `start` (words of u, v in degrees).
    pub(super) fn begin(&mut self, stage: &Stage, start_deg: Option<[f64; 2]>) -> bool {
        self.latest = *stage;
        let mut any = false;
        for state in 0..self.grid.states() {
            let (branch, words) = self.grid.words_deg(state, stage, start_deg);
            self.predecessors.push(0);
            self.costs[state] = NO_WAY;
            if !stage.alive[branch] || !(0..2).all(|k| self.grid.within(k, words[k])) {
                continue;
            }
            let mut cost = Cost { rewinds: 0.0, travel: 0.0, sum: words[0].abs() + words[1].abs(), from: 0 };
            self.words[state] = words.map(in_steps);
            if let Some(start) = start_deg {
                // a held axis keeps the start's word: only the state that has this very turn
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

    /// One pose on. False if no state of it can be reached.
    pub(super) fn advance(&mut self, stage: &Stage) -> bool {
        if self.pairwise {
            self.advance_pairwise(stage);
        } else {
            self.advance_by_minima(stage);
        }
        let mut any = false;
        let mut least = f64::INFINITY;
        for (state, cost) in self.next.iter_mut().enumerate() {
            #[expect(clippy::cast_possible_truncation, reason = "states are at most 65535")]
            self.predecessors.push(cost.from as u16);
            if cost.rewinds.is_finite() {
                any = true;
                let words = self.next_words[state];
                cost.sum += words[0].abs() + words[1].abs();
                least = least.min(cost.travel);
            }
        }
        if any && least > REBASE_DEG {
            for cost in &mut self.next {
                cost.travel -= REBASE_DEG;
            }
        }
        std::mem::swap(&mut self.costs, &mut self.next);
        std::mem::swap(&mut self.words, &mut self.next_words);
        self.latest = *stage;
        any
    }

    /// Several poses on, all with both branches alive and not held, by weights made in lanes. Returns how many
    /// poses were reached: fewer than asked for if the next one has no way.
    pub(super) fn advance_lanes(
        &mut self,
        weights: &Weights,
        lanes: std::ops::Range<usize>,
        last: &Stage,
    ) -> usize {
        let (start, end) = (lanes.start, lanes.end);
        let mut costs = [self.costs[0], self.costs[1]];
        // whole turns of each state beyond the principal words of the latest pose
        let mut turns: [[f64; 2]; 2] = std::array::from_fn(|state| {
            std::array::from_fn(|k| {
                let principal = in_steps(self.latest.words_deg[state][k]);
                nearest_integer((self.words[state][k] - principal) * (1.0 / 360.0))
            })
        });
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
        for state in 0..2 {
            self.costs[state] = costs[state];
            self.words[state] =
                std::array::from_fn(|k| in_steps(last.words_deg[state][k]) + 360.0 * turns[state][k]);
        }
        self.latest = *last;
        let least = costs[0].travel.min(costs[1].travel);
        if least > REBASE_DEG {
            for cost in &mut self.costs {
                cost.travel -= REBASE_DEG;
            }
        }
        reached
    }

    /// The words of a target state \[steps\], those of axes without end still principal; `None` out of travel.
    fn target(&self, stage: &Stage, branch: usize, turns: [usize; 2]) -> Option<[f64; 2]> {
        if !stage.alive[branch] {
            return None;
        }
        let words: [f64; 2] =
            std::array::from_fn(|k| stage.words_deg[branch][k] + self.grid.turn_deg(k, turns[k]));
        (0..2).all(|k| self.grid.within(k, words[k])).then(|| words.map(in_steps))
    }

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
                #[expect(clippy::cast_possible_truncation, reason = "states are at most 65535")]
                let cost = Cost {
                    rewinds: source.rewinds + rewind,
                    travel: source.travel + (au + av),
                    from: from as u32,
                    ..source
                };
                if cost.beats(&self.next[state]) {
                    self.next[state] = cost;
                    self.next_words[state] = [self.words[from][0] + du, self.words[from][1] + dv];
                }
            }
        }
    }

    /// Every target by its one predecessor without a rewind, or by the cheapest one with a rewind: the minimum of
    /// cost + |Δu| + |Δv| over all sources, found along v, then along u.
    fn advance_by_minima(&mut self, stage: &Stage) {
        let grid = self.grid;
        let [rows, columns] = grid.count;
        self.next.fill(NO_WAY);
        for (from_branch, to_branch) in [(0, 0), (1, 1), (0, 1), (1, 0)] {
            if !stage.alive[to_branch] || (stage.held && from_branch != to_branch) {
                continue;
            }
            let (base, to_base) = (from_branch * rows * columns, to_branch * rows * columns);
            let to = stage.words_deg[to_branch].map(in_steps);
            let to_word = |k: usize, turn: usize| to[k] + grid.turn_deg(k, turn);
            for row in 0..rows {
                let states = base + row * columns..base + (row + 1) * columns;
                let words = &self.words[states.clone()];
                let sources: Vec<Cost> = states
                    .clone()
                    .map(|state| {
                        #[expect(clippy::cast_possible_truncation, reason = "states are at most 65535")]
                        let from = state as u32;
                        Cost { from, ..self.costs[state] }
                    })
                    .collect();
                let out = &mut self.scratch[row * columns..(row + 1) * columns];
                spread(&grid, 1, &sources, |j| words[j][1], |j| to_word(1, j), out);
            }
            for column in 0..columns {
                let mut reached = vec![NO_WAY; rows];
                if stage.held {
                    for (row, cost) in reached.iter_mut().enumerate() {
                        *cost = self.scratch[row * columns + column];
                    }
                } else {
                    let sources: Vec<Cost> =
                        (0..rows).map(|row| self.scratch[row * columns + column]).collect();
                    let from_word = |row: usize| self.words[sources[row].from as usize][0];
                    spread(&grid, 0, &sources, from_word, |row| to_word(0, row), &mut reached);
                }
                for (row, cost) in reached.into_iter().enumerate() {
                    self.next[to_base + row * columns + column]
                        .keep_better(Cost { rewinds: cost.rewinds + 1.0, ..cost });
                }
            }
            for row in 0..rows {
                for column in 0..columns {
                    self.step_without_rewind(
                        stage,
                        to_base + row * columns + column,
                        base,
                        [row, column],
                        to,
                    );
                }
            }
        }
        for state in 0..grid.states() {
            let (branch, turns) = grid.parts(state);
            match self.target(stage, branch, turns) {
                Some(target) if self.next[state].rewinds.is_finite() => {
                    let from = self.words[self.next[state].from as usize];
                    let du = if stage.held { 0.0 } else { grid.step(0, from[0], target[0]) };
                    self.next_words[state] = [from[0] + du, from[1] + grid.step(1, from[1], target[1])];
                }
                _ => self.next[state] = NO_WAY,
            }
        }
    }

    fn step_without_rewind(
        &mut self,
        stage: &Stage,
        state: usize,
        base: usize,
        turns: [usize; 2],
        to: [f64; 2],
    ) {
        let grid = self.grid;
        let Some(any) = self.words.get(base) else { return };
        let mut source_turns = [0; 2];
        for k in 0..2 {
            let target = to[k] + grid.turn_deg(k, turns[k]);
            // words of a row differ by whole turns from those of the first state
            let principal = self.latest.words_deg[usize::from(base > 0)][k];
            let origin =
                if grid.period[k] > 0.0 { any[k] } else { in_steps(principal) + grid.turn_deg(k, 0) };
            source_turns[k] = if k == 0 && stage.held {
                turns[0]
            } else if grid.period[k] > 0.0 {
                0
            } else {
                let turn = ((target - origin) / 360.0).round();
                if turn < 0.0 {
                    return;
                }
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked below")]
                let turn = turn as usize;
                if turn >= grid.count[k] {
                    return;
                }
                turn
            };
        }
        let from = base + source_turns[0] * grid.count[1] + source_turns[1];
        let source = self.costs[from];
        if source.rewinds.is_infinite() {
            return;
        }
        let words = self.words[from];
        let steps: [f64; 2] = std::array::from_fn(|k| {
            if k == 0 && stage.held {
                0.0
            } else {
                grid.step(k, words[k], to[k] + grid.turn_deg(k, turns[k])).abs()
            }
        });
        if steps[0] <= self.threshold_deg && steps[1] <= self.threshold_deg {
            #[expect(clippy::cast_possible_truncation, reason = "states are at most 65535")]
            let from = from as u32;
            let cost = Cost { travel: source.travel + (steps[0] + steps[1]), from, ..source };
            self.next[state].keep_better(cost);
        }
    }

    /// The states of the cheapest way, first pose first. Empty if there is no way.
    pub(super) fn finish(mut self) -> Vec<u16> {
        let states = self.grid.states();
        let poses = self.predecessors.len() / states;
        let mut best = NO_WAY;
        let mut state = 0;
        for (n, cost) in self.costs.iter().enumerate() {
            if cost.beats(&best) {
                best = *cost;
                state = n;
            }
        }
        if best.rewinds.is_infinite() {
            return Vec::new();
        }
        // the chosen states take the place of the predecessors read
        for pose in (0..poses).rev() {
            let came_from = usize::from(self.predecessors[pose * states + state]);
            #[expect(clippy::cast_possible_truncation, reason = "states are at most 65535")]
            let chosen = state as u16;
            self.predecessors[pose * states] = chosen;
            state = came_from;
        }
        for pose in 0..poses {
            self.predecessors[pose] = self.predecessors[pose * states];
        }
        self.predecessors.truncate(poses);
        self.predecessors
    }
}

/// `out[t] = min over s of sources\[s\] + |to(t) − from(s)|`: prefix and suffix minima on a limited axis; on an
/// axis without end there is one source and one target.
fn spread(
    grid: &Grid,
    k: usize,
    sources: &[Cost],
    from: impl Fn(usize) -> f64,
    to: impl Fn(usize) -> f64,
    out: &mut [Cost],
) {
    out.fill(NO_WAY);
    if grid.period[k] > 0.0 {
        if sources[0].rewinds.is_finite() {
            out[0] = sources[0].plus_travel(grid.step(k, from(0), to(0)).abs());
        }
        return;
    }
    let count = sources.len();
    let usable = |s: usize| sources[s].rewinds.is_finite();
    let (mut best, mut s) = (NO_WAY, 0);
    for (t, out) in out.iter_mut().enumerate() {
        while s < count && (!usable(s) || from(s) <= to(t)) {
            if usable(s) {
                best.keep_better(sources[s].plus_travel(-from(s)));
            }
            s += 1;
        }
        if best.rewinds.is_finite() {
            *out = best.plus_travel(to(t));
        }
    }
    let (mut best, mut s) = (NO_WAY, count);
    for (t, out) in out.iter_mut().enumerate().rev() {
        while s > 0 && (!usable(s - 1) || from(s - 1) >= to(t)) {
            if usable(s - 1) {
                best.keep_better(sources[s - 1].plus_travel(from(s - 1)));
            }
            s -= 1;
        }
        if best.rewinds.is_finite() {
            out.keep_better(best.plus_travel(-to(t)));
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
        for (stage, state) in stages.iter().zip(choice.finish()) {
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
