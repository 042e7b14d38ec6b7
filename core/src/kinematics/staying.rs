//! Costs of a block in which no path changes its solution of the direction.
//!
//! Usually both running paths of the dynamic programming go on along their own solution: a change costs a rewind, or
//! more travel than it can save. One look at all lanes proves it. Then the costs are sums, and no weights of changes
//! are needed.
//!
//! The proof of a lane: let s and s' be the travel of the two paths' own steps, and `d` the distance between the two
//! solutions on an axis. A change of solution turns this axis by at least d − s. If this is above the threshold, it is
//! a rewind more. Otherwise the change travels at least Σd − s, against s' of the path that stays. So nothing changes
//! while the costs of both paths differ by clearly less than Σd − s − s'.
//!
//! The price is a second way to the same choice. [`super::Lanes::Never`] takes the plain way, and the tests compare
//! every bit.

use multiversion::multiversion;

use super::cost::{SLACK_DEG, in_steps};
use super::lanes::{BLOCK, Lane};
use super::pointing::nearest_integer;
use super::two_way::Rules;
use super::{InstructionSet, REWIND_DEG};

/// Both solutions of a block.
#[repr(align(64))]
pub(super) struct Stays {
    /// Travel of the step along each solution \[deg\].
    pub(super) travel_deg: [Lane; 2],
    /// |u| + |v| on each solution, whole turns included \[deg\].
    pub(super) sum_deg: [Lane; 2],
    /// The costs of both paths may differ by less than this \[deg\], as long as their rewinds are the same.
    pub(super) room_deg: Lane,
    /// Sums over the block.
    pub(super) totals: Totals,
    /// All words in steps of 2⁻³⁰°, one before the block first.
    steps: [[f64; BLOCK + 1]; 4],
}

/// Sums of a whole block. They are exact, whatever the order, because all numbers are whole steps.
#[derive(Debug, Clone, Copy, Default)]
#[expect(clippy::struct_field_names, reason = "a name ends with its unit")]
pub(super) struct Totals {
    /// Travel along each solution \[deg\].
    pub(super) travel_deg: [f64; 2],
    /// Σ(|u| + |v|) on each solution \[deg\].
    pub(super) sum_deg: [f64; 2],
    /// Σ|difference of the travels of both solutions|: the costs drift apart by no more \[deg\].
    pub(super) drift_deg: f64,
    /// The least room of a lane \[deg\].
    pub(super) room_deg: f64,
}

impl Stays {
    pub(super) fn new() -> Self {
        let lane = [0.0; BLOCK];
        let totals = Totals::default();
        let steps = [[0.0; BLOCK + 1]; 4];
        Self { travel_deg: [lane; 2], sum_deg: [lane; 2], room_deg: lane, totals, steps }
    }
}

/// Computes the steps along each solution. `before_deg` are the words before the block, `turns_deg` the whole turns of
/// every word: u, v of the first solution, then of the second.
pub(super) fn stay(
    set: InstructionSet,
    rules: &Rules,
    before_deg: [f64; 4],
    turns_deg: [f64; 4],
    words_deg: [&Lane; 4],
    out: &mut Stays,
) {
    match set {
        InstructionSet::Baseline => stay_loop(rules, before_deg, turns_deg, words_deg, out),
        InstructionSet::Avx2 => stay_avx2(rules, before_deg, turns_deg, words_deg, out),
        InstructionSet::Avx512 | InstructionSet::Fastest => {
            stay_avx512(rules, before_deg, turns_deg, words_deg, out);
        }
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn stay_avx2(
    rules: &Rules,
    before_deg: [f64; 4],
    turns_deg: [f64; 4],
    words_deg: [&Lane; 4],
    out: &mut Stays,
) {
    stay_loop(rules, before_deg, turns_deg, words_deg, out);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn stay_avx512(
    rules: &Rules,
    before_deg: [f64; 4],
    turns_deg: [f64; 4],
    words_deg: [&Lane; 4],
    out: &mut Stays,
) {
    stay_loop(rules, before_deg, turns_deg, words_deg, out);
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
#[expect(clippy::needless_bitwise_bool, reason = "no branch inside a lane")]
fn stay_loop(
    rules: &Rules,
    before_deg: [f64; 4],
    turns_deg: [f64; 4],
    words_deg: [&Lane; 4],
    out: &mut Stays,
) {
    let rules = *rules;
    let steps = &mut out.steps;
    for k in 0..4 {
        steps[k][0] = in_steps(before_deg[k]);
        for lane in 0..BLOCK {
            steps[k][lane + 1] = in_steps(words_deg[k][lane]);
        }
    }
    let longest_deg = rules.threshold_deg.min(REWIND_DEG) - SLACK_DEG;
    let apart = |between: f64| (between - 360.0 * nearest_integer(between * (1.0 / 360.0))).abs();
    let [range_u, range_v] = rules.range_deg;
    for lane in 0..BLOCK {
        let (mut longest, mut both, mut within) = (0.0, 0.0, true);
        for branch in 0..2 {
            let [u, v] = [2 * branch, 2 * branch + 1];
            let (to_u, to_v) = (steps[u][lane + 1], steps[v][lane + 1]);
            let travel = (to_u - steps[u][lane]).abs() + (to_v - steps[v][lane]).abs();
            out.travel_deg[branch][lane] = travel;
            out.sum_deg[branch][lane] = (to_u + turns_deg[u]).abs() + (to_v + turns_deg[v]).abs();
            longest = if travel > longest { travel } else { longest };
            both += travel;
            let (turned_u, turned_v) =
                (words_deg[u][lane] + rules.turn_deg[0], words_deg[v][lane] + rules.turn_deg[1]);
            within = within
                & (turned_u >= range_u[0])
                & (turned_u <= range_u[1])
                & (turned_v >= range_v[0])
                & (turned_v <= range_v[1]);
        }
        let apart_u = apart(steps[2][lane + 1] - steps[0][lane + 1]);
        let apart_v = apart(steps[3][lane + 1] - steps[1][lane + 1]);
        let farther = if apart_u > apart_v { apart_u } else { apart_v };
        let is_rewind = farther - longest > rules.threshold_deg + SLACK_DEG;
        let room = if is_rewind { f64::INFINITY } else { apart_u + apart_v - both - SLACK_DEG };
        out.room_deg[lane] = if within & (longest < longest_deg) { room } else { -1.0 };
    }
    out.totals = totals(out);
}

/// Lanes that are summed side by side: one after the other, each would wait for the one before.
const SIDE_BY_SIDE: usize = 16;

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn totals(stays: &Stays) -> Totals {
    let Stays { travel_deg: [first, second], sum_deg: [first_sum, second_sum], room_deg, .. } = stays;
    let mut sums = [[0.0; SIDE_BY_SIDE]; 5];
    let mut least = [f64::INFINITY; SIDE_BY_SIDE];
    for begin in (0..BLOCK).step_by(SIDE_BY_SIDE) {
        for k in 0..SIDE_BY_SIDE {
            let lane = begin + k;
            sums[0][k] += first[lane];
            sums[1][k] += second[lane];
            sums[2][k] += first_sum[lane];
            sums[3][k] += second_sum[lane];
            sums[4][k] += (first[lane] - second[lane]).abs();
            least[k] = if room_deg[lane] < least[k] { room_deg[lane] } else { least[k] };
        }
    }
    let [first, second, first_sum, second_sum, drift_deg] = sums.map(|sums| sums.iter().sum());
    let room_deg = least.into_iter().fold(f64::INFINITY, f64::min);
    Totals { travel_deg: [first, second], sum_deg: [first_sum, second_sum], drift_deg, room_deg }
}
