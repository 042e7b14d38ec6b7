//! One step of the dynamic programming for axes with several turns.
//!
//! A target is reached without a rewind from only one turn of each branch, by a step that is the same for all
//! turns. With a rewind it can be reached from every state. The minimum of cost + |Δu| + |Δv| over all of them is
//! found along v, then along u, by prefix and suffix minima. A rewind only helps a target that costs a rewind more
//! than the cheapest source, so most steps need no minima at all.

use std::ops::Range;

use super::choice::Choice;
use super::cost::{Cost, NO_WAY, in_steps};
use super::grid::{Grid, Stage};
use super::pointing::nearest_integer;

/// The step from the words of one branch to those of another.
struct Leg {
    /// Index of the first state of the source branch and of the target branch.
    base: [usize; 2],
    /// Step between the words of equal turns, for u and v \[deg\].
    between_deg: [f64; 2],
    /// Step by the nearest turn \[deg\].
    nearest_deg: [f64; 2],
    /// Number of turns by which the nearest one is beyond its target's; 0 on an unlimited axis.
    shift: [isize; 2],
    /// u keeps its word.
    held: bool,
}

impl Leg {
    fn new(grid: &Grid, from: &Stage, to: &Stage, branches: [usize; 2]) -> Self {
        let mut leg = Self {
            base: branches.map(|branch| branch * grid.count[0] * grid.count[1]),
            between_deg: [0.0; 2],
            nearest_deg: [0.0; 2],
            shift: [0; 2],
            held: to.held,
        };
        for k in usize::from(to.held)..2 {
            let between = in_steps(to.words_deg[branches[1]][k]) - in_steps(from.words_deg[branches[0]][k]);
            let turns = nearest_integer(between * (1.0 / 360.0));
            leg.between_deg[k] = between;
            leg.nearest_deg[k] = between - 360.0 * turns;
            if grid.period[k] == 0.0 {
                leg.shift[k] = whole(turns);
            }
        }
        leg
    }
}

/// A number of turns as an integer: principal words are less than two apart.
fn whole(turns: f64) -> isize {
    #[expect(clippy::cast_possible_truncation, reason = "−1, 0 or 1")]
    let turns = turns as isize;
    turns
}

impl Choice {
    /// Advances one pose, for thresholds below half a turn.
    pub(super) fn advance_by_turns(&mut self, stage: &Stage) {
        let grid = self.grid;
        self.next.fill(NO_WAY);
        let fewest = self.costs.iter().map(|cost| cost.rewinds).fold(f64::INFINITY, f64::min);
        for to in 0..2 {
            if !stage.alive[to] {
                continue;
            }
            let live: [Range<usize>; 2] = std::array::from_fn(|k| grid.live(k, stage.words_deg[to][k]));
            let legs = [0, 1].map(|from| Leg::new(&grid, &self.latest, stage, [from, to]));
            let legs = || legs.iter().enumerate().filter(|(from, _)| !stage.held || *from == to);
            for (_, leg) in legs() {
                self.step_without_rewind(leg, &live);
            }
            let base = to * grid.count[0] * grid.count[1];
            let needy = |row: usize| {
                let row = base + row * grid.count[1];
                self.next[row + live[1].start..row + live[1].end].iter().any(|cost| cost.rewinds > fewest)
            };
            if live[0].clone().any(needy) {
                for (_, leg) in legs() {
                    self.step_with_rewind(leg, &live);
                }
            }
            for row in live[0].clone() {
                for column in live[1].clone() {
                    self.arrive(stage, to, [row, column]);
                }
            }
        }
    }

    fn step_without_rewind(&mut self, leg: &Leg, live: &[Range<usize>; 2]) {
        let [du, dv] = leg.nearest_deg.map(f64::abs);
        if du > self.threshold_deg || dv > self.threshold_deg {
            return;
        }
        let [rows, columns] = self.grid.count;
        for row in live[0].clone() {
            let Some(source_row) = row.checked_add_signed(leg.shift[0]).filter(|row| *row < rows) else {
                continue;
            };
            for column in live[1].clone() {
                let Some(source) = column.checked_add_signed(leg.shift[1]).filter(|turn| *turn < columns)
                else {
                    continue;
                };
                let from = leg.base[0] + source_row * columns + source;
                let cost = self.costs[from].plus_travel(du + dv).coming_from(from);
                self.next[leg.base[1] + row * columns + column].keep_better(cost);
            }
        }
    }

    fn step_with_rewind(&mut self, leg: &Leg, live: &[Range<usize>; 2]) {
        let grid = self.grid;
        let [rows, columns] = grid.count;
        for row in 0..rows {
            let begin = leg.base[0] + row * columns;
            for (column, cost) in self.costs[begin..begin + columns].iter().enumerate() {
                self.row[column] = cost.coming_from(begin + column);
            }
            let out = &mut self.scratch[row * columns..(row + 1) * columns];
            spread(&grid, leg, 1, &self.row[..columns], live[1].clone(), out);
        }
        for column in live[1].clone() {
            for row in 0..rows {
                self.row[row] = self.scratch[row * columns + column];
            }
            let (from, out) = self.row.split_at_mut(rows);
            let reached = if leg.held {
                &*from
            } else {
                spread(&grid, leg, 0, from, live[0].clone(), out);
                &*out
            };
            for row in live[0].clone() {
                let cost = reached[row];
                self.next[leg.base[1] + row * columns + column]
                    .keep_better(Cost { rewinds: cost.rewinds + 1.0, ..cost });
            }
        }
    }

    /// The words of a state that was reached.
    fn arrive(&mut self, stage: &Stage, branch: usize, turns: [usize; 2]) {
        let grid = self.grid;
        let state = (branch * grid.count[0] + turns[0]) * grid.count[1] + turns[1];
        let cost = self.next[state];
        if cost.rewinds.is_infinite() {
            return;
        }
        let from = self.words[cost.from as usize];
        self.next_words[state] = std::array::from_fn(|k| {
            let principal = in_steps(stage.words_deg[branch][k]);
            if k == 0 && stage.held {
                from[0]
            } else if grid.period[k] > 0.0 {
                from[k] + grid.step(k, from[k], principal)
            } else {
                principal + grid.turn_deg(k, turns[k])
            }
        });
    }
}

/// `out[t] = min over s of sources\[s\] + |Δ + 360 (t − s)|` for the targets `live`: prefix and suffix minima on a
/// limited axis. An unlimited axis has one source and one target.
fn spread(grid: &Grid, leg: &Leg, k: usize, sources: &[Cost], live: Range<usize>, out: &mut [Cost]) {
    if grid.period[k] > 0.0 {
        out[0] = sources[0].plus_travel(leg.nearest_deg[k].abs());
        return;
    }
    let between = leg.between_deg[k];
    // Sources up to this many turns beyond a target are below it.
    let below = whole((between * (1.0 / 360.0)).floor());
    let word = |turn: usize| 360.0 * turn as f64;
    let split =
        |target: usize| target.saturating_add(1).checked_add_signed(below).unwrap_or(0).min(sources.len());
    let (mut best, mut s) = (NO_WAY, 0);
    for t in live.clone() {
        while s < split(t) {
            best.keep_better(sources[s].plus_travel(-word(s)));
            s += 1;
        }
        out[t] = best.plus_travel(word(t) + between);
    }
    let (mut best, mut s) = (NO_WAY, sources.len());
    for t in live.rev() {
        while s > split(t) {
            s -= 1;
            best.keep_better(sources[s].plus_travel(word(s)));
        }
        out[t].keep_better(best.plus_travel(-(word(t) + between)));
    }
}
