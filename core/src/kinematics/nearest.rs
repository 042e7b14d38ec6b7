//! The greedy choice: at each pose the state nearest to the pose before.

use super::cost::{Cost, NO_WAY, in_steps};
use super::grid::{Grid, Stage};
use super::pointing::nearest_integer;

impl Grid {
    /// The branch and its words \[deg\] nearest to `previous_deg` at a stage (without it: nearest to zero), or
    /// `None` if all are out of travel. The order of costs is that of the dynamic programming, for one step.
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
                tied: false,
            };
            if cost.beats(&best) {
                best = cost;
                chosen = Some((branch, words));
            }
        }
        chosen
    }
}
