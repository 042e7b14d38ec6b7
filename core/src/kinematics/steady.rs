//! Blocks in which nothing changes: the path stays on one solution of the direction, and no axis passes ±180°.
//!
//! Most blocks of a smooth path are like this, and one look at all lanes proves it. Then nothing is weighed, and
//! nothing is computed for the other solution.
//!
//! The proof of a lane: let s be the travel |Δu| + |Δv| of the step on this solution. The other solution turns v by 2B
//! or 2π − 2B, so it is at least 2 sin B away from this one. A step to it therefore travels at least 2 sin B − s. If s
//! is clearly below sin B, staying is nearest. If s is also below the threshold of a rewind, no cost outweighs this.
//!
//! The price is a second way to the same choice. [`super::Lanes::Never`] takes the plain way, and the tests compare
//! every bit.

use multiversion::multiversion;

use super::aligned::Aligned;
use super::cost::SLACK_DEG;
use super::lanes::{BLOCK, Lane, PointedBlock};
use super::pointing::{DEG_PER_RAD, Pointing, SIGNS, nearest_integer, turn_of_u};
use super::{InstructionSet, REWIND_DEG};
use crate::geometry::trig_lanes;
use crate::machine::Travel;

/// Part of sin B that a step may use. The rest is for rounding: N and D have an error of a few 1e-16 and are above
/// [`super::lanes::REACH_MARGIN`], so the root of their product has a relative error below 1e-6.
const SHARE: f64 = 0.999;

/// One solution, with the whole turns of its words.
#[derive(Debug, Clone, Copy)]
pub(super) struct Course {
    /// 0 or 1.
    pub(super) branch: usize,
    /// Words of u, v before the block \[deg\].
    pub(super) entered_deg: [f64; 2],
}

/// The bounds on a step and on the words.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    /// Largest |Δu| + |Δv| \[deg\], whatever the conditioning is.
    longest_step_deg: f64,
    /// Bound on |Δu| + |Δv| by conditioning \[deg\].
    deg_per_conditioning: f64,
    /// Travels of u, v; infinite on an unlimited axis.
    range_deg: [[f64; 2]; 2],
}

impl Bounds {
    /// The bounds for the travels of u, v and a threshold of a rewind.
    pub(super) fn new(pointing: &Pointing, travel: [Option<Travel>; 2], rewind_deg: f64) -> Self {
        Self {
            longest_step_deg: rewind_deg.min(REWIND_DEG) - SLACK_DEG,
            deg_per_conditioning: SHARE * DEG_PER_RAD / pointing.product,
            range_deg: travel
                .map(|travel| travel.map_or([f64::NEG_INFINITY, f64::INFINITY], |t| [t.min, t.max])),
        }
    }
}

/// Writes the words of u, v \[deg\] along a course. True if the course is steady up to lane `size`; otherwise the words
/// mean nothing.
pub(super) fn follow(
    set: InstructionSet,
    pointing: &Pointing,
    bounds: &Bounds,
    course: Course,
    pointed: &mut PointedBlock,
    size: usize,
    words_deg: &mut [Lane; 2],
) -> bool {
    let mut room = Aligned([0.0; BLOCK]);
    let task = Task { pointing, bounds, entered_deg: course.entered_deg, sign: SIGNS[course.branch] };
    match set {
        InstructionSet::Baseline => follow_loop(&task, pointed, words_deg, &mut room),
        InstructionSet::Avx2 => follow_avx2(&task, pointed, words_deg, &mut room),
        InstructionSet::Avx512 | InstructionSet::Fastest => {
            follow_avx512(&task, pointed, words_deg, &mut room);
        }
    }
    // Without a branch in the loop. NaN is not positive.
    room[..size].iter().fold(1, |all, room| all & u8::from(*room > 0.0)) == 1
}

struct Task<'a> {
    pointing: &'a Pointing,
    bounds: &'a Bounds,
    entered_deg: [f64; 2],
    /// Of B and η on this solution.
    sign: f64,
}

#[multiversion(targets("x86_64+avx2"))]
fn follow_avx2(task: &Task<'_>, pointed: &mut PointedBlock, words_deg: &mut [Lane; 2], room: &mut Lane) {
    follow_loop(task, pointed, words_deg, room);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn follow_avx512(task: &Task<'_>, pointed: &mut PointedBlock, words_deg: &mut [Lane; 2], room: &mut Lane) {
    follow_loop(task, pointed, words_deg, room);
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
#[expect(clippy::needless_bitwise_bool, reason = "no branch inside a lane")]
fn follow_loop(task: &Task<'_>, pointed: &mut PointedBlock, words_deg: &mut [Lane; 2], room: &mut Lane) {
    let (pointing, bounds) = (*task.pointing, *task.bounds);
    let [us, vs] = words_deg;
    let PointedBlock { b_rad, eta: [eta_y, eta_x], gamma: [gamma_y, gamma_x], conditioning, scratch, .. } =
        pointed;
    for lane in 0..BLOCK {
        // y and x, until the next loop.
        [us[lane], vs[lane]] =
            turn_of_u(task.sign, [eta_y[lane], eta_x[lane]], [gamma_y[lane], gamma_x[lane]]);
    }
    trig_lanes::atan2(us, vs, scratch);
    let first_deg = pointing.words_deg(task.sign, [us[0], b_rad[0]]);
    let turns_deg: [f64; 2] = std::array::from_fn(|k| {
        360.0 * nearest_integer((task.entered_deg[k] - first_deg[k]) * (1.0 / 360.0))
    });
    for lane in 0..BLOCK {
        let words = pointing.words_deg(task.sign, [us[lane], b_rad[lane]]);
        us[lane] = words[0] + turns_deg[0];
        vs[lane] = words[1] + turns_deg[1];
    }
    let lane_room = |[u, v]: [f64; 2], before: [f64; 2], conditioning: f64| {
        let step = (u - before[0]).abs() + (v - before[1]).abs();
        let by_conditioning = conditioning * bounds.deg_per_conditioning - SLACK_DEG;
        let bound =
            if by_conditioning < bounds.longest_step_deg { by_conditioning } else { bounds.longest_step_deg };
        let [range_u, range_v] = bounds.range_deg;
        let within = (u >= range_u[0]) & (u <= range_u[1]) & (v >= range_v[0]) & (v <= range_v[1]);
        if within { bound - step } else { -1.0 }
    };
    room[0] = lane_room([us[0], vs[0]], task.entered_deg, conditioning[0]);
    for lane in 1..BLOCK {
        let (words, before) = ([us[lane], vs[lane]], [us[lane - 1], vs[lane - 1]]);
        room[lane] = lane_room(words, before, conditioning[lane]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::lanes::REACH_MARGIN;
    use crate::kinematics::{Kinematics, Setup};
    use crate::machine::{Machine, PRESETS};

    #[test]
    fn the_share_leaves_room_for_the_rounding_of_sin_b() {
        let mut near = 0;
        for preset in &PRESETS {
            let kinematics = Kinematics::new(&Machine::new(preset.parts()).unwrap(), &Setup::default());
            let pointing = &kinematics.pointing;
            for step in 1..4000 {
                // From the reach limit on, ever farther.
                let b_rad = 1e-5 * 1.003_f64.powi(step);
                let words = [17.0, kinematics.sense[1] * (pointing.b0_rad + b_rad).to_degrees()];
                let pointed = pointing.solve(kinematics.axis_of_words(words).into());
                if b_rad > 3.1 || pointed.reach[0].min(pointed.reach[1]) < REACH_MARGIN {
                    continue;
                }
                let found = pointed.conditioning / (pointing.product * b_rad.sin());
                assert!((found - 1.0).abs() < 0.01 * (1.0 - SHARE), "{} {b_rad}: {found}", preset.id);
                near += u32::from(pointed.reach[0] < 2.0 * REACH_MARGIN);
            }
        }
        assert!(near > 0, "no direction was near the margin");
    }
}
