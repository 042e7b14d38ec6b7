//! The states of a choice: branch × whole turns of the limited axes.

use super::COMPUTED_WORD_SLACK;
use super::pointing::nearest_integer;
use super::two_way::Rules;
use crate::machine::Travel;

/// The words of one pose for both branches, as the choice uses them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stage {
    /// Principal words of u, v \[deg\] per branch.
    pub(super) words_deg: [[f64; 2]; 2],
    /// Whether the branch exists and keeps X Y Z within travel.
    pub(super) alive: [bool; 2],
    /// u keeps its word: only the turn of v may change.
    pub(super) held: bool,
}

/// The turns of both axes that can be within travel.
#[derive(Debug, Clone, Copy)]
pub(super) struct Grid {
    pub(super) lowest: [i32; 2],
    pub(super) count: [usize; 2],
    /// 360 on an unlimited axis, otherwise 0.
    pub(super) period: [f64; 2],
    pub(super) travel: [Option<Travel>; 2],
}

impl Grid {
    /// For the travels of u and v; `None` is unlimited.
    pub(super) fn new(travel: [Option<Travel>; 2]) -> Self {
        let mut grid = Self { lowest: [0; 2], count: [1; 2], period: [360.0; 2], travel };
        for (k, travel) in travel.iter().enumerate() {
            if let Some(Travel { min, max }) = travel {
                let (low, high) = (((min - 180.0) / 360.0).ceil(), ((max + 180.0) / 360.0).floor());
                #[expect(
                    clippy::cast_possible_truncation,
                    reason = "travel ends are within a thousand turns"
                )]
                let (low, high) = (low as i32, high as i32);
                grid.lowest[k] = low;
                grid.count[k] = usize::try_from(high - low + 1).unwrap_or(1).max(1);
                grid.period[k] = 0.0;
            }
        }
        grid
    }

    /// Number of states: branches times turns.
    pub(super) fn states(&self) -> usize {
        2 * self.count[0] * self.count[1]
    }

    /// The rules for the lanes of a block, if there are two states per pose.
    pub(super) fn rules(&self, threshold_deg: f64) -> Option<Rules> {
        (self.count == [1, 1]).then(|| Rules {
            period: self.period,
            turn_deg: [self.turn_deg(0, 0), self.turn_deg(1, 0)],
            range_deg: self.travel.map(|travel| {
                travel.map_or([f64::NEG_INFINITY, f64::INFINITY], |t| {
                    [t.min - COMPUTED_WORD_SLACK, t.max + COMPUTED_WORD_SLACK]
                })
            }),
            threshold_deg,
        })
    }

    /// Branch and turns of a state.
    pub(super) fn parts(&self, state: usize) -> (usize, [usize; 2]) {
        let per_branch = self.count[0] * self.count[1];
        if per_branch == 1 {
            return (state, [0; 2]);
        }
        let rest = state % per_branch;
        (state / per_branch, [rest / self.count[1], rest % self.count[1]])
    }

    pub(super) fn turn_deg(&self, k: usize, turn: usize) -> f64 {
        #[expect(clippy::cast_possible_wrap, clippy::cast_possible_truncation, reason = "at most 2001 turns")]
        let turn = turn as i32;
        360.0 * f64::from(self.lowest[k] + turn)
    }

    /// The step of axis k; on an unlimited axis to the nearest turn.
    #[inline]
    pub(super) fn step(&self, k: usize, from: f64, to: f64) -> f64 {
        let step = to - from;
        step - self.period[k] * nearest_integer(step * (1.0 / 360.0))
    }

    /// The word of axis k if it has one turn or is unlimited: then in the turn nearest to `previous_deg`.
    #[inline]
    pub(super) fn nearest_turn(&self, k: usize, principal_deg: f64, previous_deg: f64) -> f64 {
        if self.period[k] > 0.0 {
            principal_deg + 360.0 * nearest_integer((previous_deg - principal_deg) * (1.0 / 360.0))
        } else {
            principal_deg + 360.0 * f64::from(self.lowest[k])
        }
    }

    pub(super) fn within(&self, k: usize, word_deg: f64) -> bool {
        self.travel[k].is_none_or(|travel| travel.contains(word_deg, COMPUTED_WORD_SLACK))
    }

    /// The turns of a principal word that are within travel.
    pub(super) fn live(&self, k: usize, word_deg: f64) -> std::ops::Range<usize> {
        let within = |turn: usize| self.within(k, word_deg + self.turn_deg(k, turn));
        let mut live = 0..self.count[k];
        while live.start < live.end && !within(live.start) {
            live.start += 1;
        }
        while live.start < live.end && !within(live.end - 1) {
            live.end -= 1;
        }
        live
    }

    /// The branch of `state` and its words at a stage. `previous_deg` decides the turn of unlimited axes.
    pub(super) fn words_deg(
        &self,
        state: usize,
        stage: &Stage,
        previous_deg: Option<[f64; 2]>,
    ) -> (usize, [f64; 2]) {
        let (branch, turns) = self.parts(state);
        let words = std::array::from_fn(|k| {
            let principal = stage.words_deg[branch][k];
            match previous_deg {
                Some(previous) if k == 0 && stage.held => previous[0],
                Some(previous) if self.period[k] > 0.0 => self.nearest_turn(k, principal, previous[k]),
                _ if self.period[k] > 0.0 => principal,
                _ => principal + self.turn_deg(k, turns[k]),
            }
        });
        (branch, words)
    }
}
