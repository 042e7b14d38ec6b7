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

use super::cost::in_steps;
use super::lanes::{BLOCK, Lane};
use super::pointing::nearest_integer;
use super::two_way::Rules;
use super::{InstructionSet, REWIND_DEG};

/// Subtracted from every bound \[deg\]: far above ties and rounding.
pub(super) const SLACK_DEG: f64 = 1e-5;

/// Both solutions of a block.
#[repr(align(64))]
pub(super) struct Stays {
    /// Travel of the step along each solution \[deg\].
    pub(super) travel_deg: [Lane; 2],
    /// |u| + |v| on each solution, whole turns included \[deg\].
    pub(super) sum_deg: [Lane; 2],
    /// The costs of both paths may differ by less than this \[deg\], as long as their rewinds are the same.
    pub(super) room_deg: Lane,
    /// All words in steps of 2⁻³⁰°, one before the block first.
    steps: [[f64; BLOCK + 1]; 4],
}

impl Stays {
    pub(super) fn new() -> Self {
        let lane = [0.0; BLOCK];
        Self { travel_deg: [lane; 2], sum_deg: [lane; 2], room_deg: lane, steps: [[0.0; BLOCK + 1]; 4] }
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
}
