//! Weights of all steps of a block whose poses have just two states: one turn of each axis, or no limit.
//!
//! Everything that does not depend on earlier choices is computed in lanes: travel, rewind and change of whole
//! turns of the four steps between the branches of neighbouring poses, and the nearest of them. Only additions
//! and comparisons remain to be done pose by pose.

use multiversion::multiversion;

use super::InstructionSet;
use super::cost::{TIE_DEG, in_steps};
use super::lanes::{BLOCK, Lane};
use super::pointing::nearest_integer;

/// The values on which the weights depend.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rules {
    /// 360 on an unlimited axis, otherwise 0, for u and v.
    pub(super) period: [f64; 2],
    /// The one turn of a limited axis \[deg\], for u and v.
    pub(super) turn_deg: [f64; 2],
    /// Smallest and largest principal word within travel, for u and v.
    pub(super) range_deg: [[f64; 2]; 2],
    pub(super) threshold_deg: f64,
}

/// Steps into the lanes of a block, with index `2·from + to` for the four steps.
#[repr(align(64))]
pub(super) struct Weights {
    /// Principal words of u, v of the first branch, then of the second, in steps of 2⁻³⁰°.
    pub(super) words: [Lane; 4],
    pub(super) travel: [Lane; 4],
    /// 1 for a rewind, infinite into a word out of travel.
    pub(super) rewinds: [Lane; 4],
    /// Whole turns to add to the word of u.
    pub(super) turns_u: [Lane; 4],
    /// Whole turns to add to the word of v.
    pub(super) turns_v: [Lane; 4],
    /// The nearest branch from each branch; 0.5 if they tie or both are out of travel.
    pub(super) nearest: [Lane; 2],
}

impl Weights {
    pub(super) fn new() -> Self {
        let lane = [0.0; BLOCK];
        Self {
            words: [lane; 4],
            travel: [lane; 4],
            rewinds: [lane; 4],
            turns_u: [lane; 4],
            turns_v: [lane; 4],
            nearest: [lane; 2],
        }
    }
}

/// Computes the weights of the steps into every lane. Those into the first lane come from the words `previous`.
/// With `all` false only the nearest branches are computed.
pub(super) fn weigh(
    set: InstructionSet,
    rules: &Rules,
    previous: [f64; 4],
    words: &[Lane; 4],
    all: bool,
    out: &mut Weights,
) {
    match set {
        InstructionSet::Baseline => weigh_any(rules, previous, words, all, out),
        InstructionSet::Avx2 => weigh_avx2(rules, previous, words, all, out),
        InstructionSet::Avx512 | InstructionSet::Fastest => weigh_avx512(rules, previous, words, all, out),
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn weigh_avx2(rules: &Rules, previous: [f64; 4], words: &[Lane; 4], all: bool, out: &mut Weights) {
    weigh_any(rules, previous, words, all, out);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn weigh_avx512(rules: &Rules, previous: [f64; 4], words: &[Lane; 4], all: bool, out: &mut Weights) {
    weigh_any(rules, previous, words, all, out);
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn weigh_any(rules: &Rules, previous: [f64; 4], words: &[Lane; 4], all: bool, out: &mut Weights) {
    if all {
        weigh_loop::<true>(rules, previous, words, out);
    } else {
        weigh_loop::<false>(rules, previous, words, out);
    }
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
#[expect(clippy::needless_bitwise_bool, reason = "no branch inside a lane")]
fn weigh_loop<const ALL: bool>(rules: &Rules, previous: [f64; 4], words: &[Lane; 4], out: &mut Weights) {
    let rules = *rules;
    let mut steps = [[0.0; BLOCK + 1]; 4];
    for k in 0..4 {
        steps[k][0] = in_steps(previous[k]);
        for lane in 0..BLOCK {
            let word = in_steps(words[k][lane]);
            steps[k][lane + 1] = word;
            if ALL {
                out.words[k][lane] = word;
            }
        }
    }
    for lane in 0..BLOCK {
        let (mut travel, mut rewinds) = ([0.0; 4], [0.0; 4]);
        for to in 0..2 {
            let [u, v] =
                [words[2 * to][lane] + rules.turn_deg[0], words[2 * to + 1][lane] + rules.turn_deg[1]];
            let [range_u, range_v] = rules.range_deg;
            let within = (u >= range_u[0]) & (u <= range_u[1]) & (v >= range_v[0]) & (v <= range_v[1]);
            let dead = if within { 0.0 } else { f64::INFINITY };
            for from in 0..2 {
                let du = steps[2 * to][lane + 1] - steps[2 * from][lane];
                let dv = steps[2 * to + 1][lane + 1] - steps[2 * from + 1][lane];
                let (tu, tv) = (nearest_integer(du * (1.0 / 360.0)), nearest_integer(dv * (1.0 / 360.0)));
                let au = (du - rules.period[0] * tu).abs();
                let av = (dv - rules.period[1] * tv).abs();
                let more = if au > av { au } else { av };
                let rewind = if more > rules.threshold_deg { 1.0 } else { 0.0 };
                let index = 2 * from + to;
                travel[index] = au + av;
                rewinds[index] = rewind + dead;
                if ALL {
                    out.travel[index][lane] = travel[index];
                    out.rewinds[index][lane] = rewinds[index];
                    out.turns_u[index][lane] = rules.period[0] * (-1.0 / 360.0) * tu;
                    out.turns_v[index][lane] = rules.period[1] * (-1.0 / 360.0) * tv;
                }
            }
        }
        for from in 0..2 {
            let (r0, r1) = (rewinds[2 * from], rewinds[2 * from + 1]);
            let (t0, t1) = (travel[2 * from], travel[2 * from + 1]);
            let by_travel = if t1 < t0 - TIE_DEG { 1.0 } else { 0.5 };
            let by_travel = if t1 > t0 + TIE_DEG { 0.0 } else { by_travel };
            let by_rewinds = if r1 < r0 { 1.0 } else { by_travel };
            let nearest = if r1 > r0 { 0.0 } else { by_rewinds };
            let fewest = if r1 < r0 { r1 } else { r0 };
            out.nearest[from][lane] = if fewest > 1.5 { 0.5 } else { nearest };
        }
    }
}
