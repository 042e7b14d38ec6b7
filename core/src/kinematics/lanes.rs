//! The inverse for blocks of poses in structure-of-arrays form: directions first, linear words of the chosen
//! solution last. The operations are those of a single pose, without fused multiply-add, so the bits are the
//! same.

use multiversion::multiversion;

use super::pointing::{Aimed, Pointing, SIGNS, Sighted, turn_of_u};
use super::pose_source::Poses;
use super::{InstructionSet, Kinematics, MAX_COORDINATE_MM};
use crate::geometry::trig_lanes;

/// Poses processed together: all arrays of a block stay in the second-nearest cache.
pub(super) const BLOCK: usize = 128;
pub(super) type Lane = [f64; BLOCK];

/// The directions of a block.
#[repr(align(64))]
pub(super) struct PointedBlock {
    /// The angle B \[rad\]; before, its y.
    pub(super) b_rad: Lane,
    /// x of the angle B.
    b_across: Lane,
    /// y and x of the angle η (see [`Aimed`]).
    pub(super) eta: [Lane; 2],
    /// y and x of the angle γ (see [`Sighted`]).
    pub(super) gamma: [Lane; 2],
    pub(super) scratch: [Lane; 3],
    pub(super) conditioning: Lane,
    /// Not positive if the lane needs care: near the pole or the reach limit, without direction, or too far away.
    pub(super) margin: Lane,
}

impl PointedBlock {
    pub(super) fn new() -> Self {
        let lane = [0.0; BLOCK];
        Self {
            b_rad: lane,
            b_across: lane,
            eta: [lane; 2],
            gamma: [lane; 2],
            scratch: [lane; 3],
            conditioning: lane,
            margin: lane,
        }
    }

    /// The words \[deg\] of both solutions of one lane.
    pub(super) fn words_deg(&self, pointing: &Pointing, lane: usize) -> [[f64; 2]; 2] {
        let [eta, gamma] = [&self.eta, &self.gamma].map(|[y, x]| [y[lane], x[lane]]);
        pointing.both_words_deg(self.b_rad[lane], eta, gamma)
    }
}

/// What is computed from chosen words on the way to joints.
#[repr(align(64))]
pub(super) struct JointBlock {
    sin: [Lane; 2],
    cos: [Lane; 2],
    between_mm: [Lane; 3],
}

impl JointBlock {
    pub(super) fn new() -> Self {
        let lane = [0.0; BLOCK];
        Self { sin: [lane; 2], cos: [lane; 2], between_mm: [lane; 3] }
    }
}

/// Chosen words of u, v \[deg\] and the tips \[mm\] of a block.
#[derive(Clone, Copy)]
pub(super) struct Targets<'a> {
    pub(super) words_deg: &'a [Lane; 2],
    pub(super) tip_mm: [&'a Lane; 3],
}

/// Where the joints of a block go.
pub(super) struct Joined<'a> {
    /// X Y Z \[mm\].
    pub(super) linear_mm: [&'a mut Lane; 3],
    /// θ of u, v \[rad\].
    pub(super) rotary_rad: [&'a mut Lane; 2],
}

impl<'a> Joined<'a> {
    /// X Y Z and the rotary axes in the profile's order, which is `swapped` if v comes first.
    pub(super) fn new([x, y, z, first, second]: [&'a mut Lane; 5], swapped: bool) -> Self {
        let rotary_rad = if swapped { [second, first] } else { [first, second] };
        Self { linear_mm: [x, y, z], rotary_rad }
    }
}

/// N and D below this need care: the solutions almost meet.
pub(super) const REACH_MARGIN: f64 = 1e-9;

/// Solves the directions of a block up to the u-angles. `cone_sin2` is sin² of the half-angle of the pole cone,
/// widened.
pub(super) fn point(
    set: InstructionSet,
    pointing: &Pointing,
    cone_sin2: f64,
    poses: Poses<'_>,
    out: &mut PointedBlock,
) {
    match set {
        InstructionSet::Baseline => point_loop(pointing, cone_sin2, poses, out),
        InstructionSet::Avx2 => point_avx2(pointing, cone_sin2, poses, out),
        InstructionSet::Avx512 | InstructionSet::Fastest => {
            point_avx512(pointing, cone_sin2, poses, out);
        }
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn point_avx2(pointing: &Pointing, cone_sin2: f64, poses: Poses<'_>, out: &mut PointedBlock) {
    point_loop(pointing, cone_sin2, poses, out);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn point_avx512(pointing: &Pointing, cone_sin2: f64, poses: Poses<'_>, out: &mut PointedBlock) {
    point_loop(pointing, cone_sin2, poses, out);
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
#[expect(clippy::needless_bitwise_bool, reason = "no branch inside a lane")]
fn point_loop(pointing: &Pointing, cone_sin2: f64, poses: Poses<'_>, out: &mut PointedBlock) {
    let pointing = *pointing;
    let Poses { tip_mm: [x, y, z], axis, .. } = poses;
    let is_near = |value_mm: f64| value_mm.abs() <= MAX_COORDINATE_MM;
    // Several short loops let the processor work on many lanes at a time instead of waiting for one.
    let PointedBlock { b_rad: b, b_across, eta: [eta, eta_across], gamma: [gamma, gamma_across], .. } = out;
    // A root that is waited for holds up the divisions of the lanes behind it, so roots have their own loop.
    let [lengths, ..] = &mut out.scratch;
    for lane in 0..BLOCK {
        let (i, j, k) = (axis[0][lane], axis[1][lane], axis[2][lane]);
        lengths[lane] = (i * i + j * j + k * k).sqrt();
    }
    for lane in 0..BLOCK {
        let (i, j, k) = (axis[0][lane], axis[1][lane], axis[2][lane]);
        let length = lengths[lane];
        // One division instead of three: its rounding scales all of t, and no angle depends on the scale.
        let scale = 1.0 / length;
        let sighted = pointing.sight([i * scale, j * scale, k * scale]);
        let Sighted { half_tilt: [sin2, cos2], reach, gamma: [gamma_y, gamma_x] } = sighted;
        (gamma[lane], gamma_across[lane]) = (gamma_y, gamma_x);
        // Until the next loop.
        [b[lane], b_across[lane]] = reach;
        let polar = 4.0 * sin2 * cos2 - cone_sin2;
        let reach = if reach[0] < reach[1] { reach[0] } else { reach[1] };
        let reach = reach - REACH_MARGIN;
        let least = if polar < reach { polar } else { reach };
        // Lengths that cannot be squared lose the margin, and so does NaN.
        let sound = (length > 1e-100) & (length < 1e100);
        let near = is_near(x[lane]) & is_near(y[lane]) & is_near(z[lane]);
        out.margin[lane] = if sound & near { least } else { -1.0 };
    }
    for lane in 0..BLOCK {
        let aimed = pointing.aim([b[lane], b_across[lane]]);
        let Aimed { b: [b_y, b_x], eta: [eta_y, eta_x], conditioning } = aimed;
        (b[lane], b_across[lane]) = (b_y, b_x);
        (eta[lane], eta_across[lane]) = (eta_y, eta_x);
        out.conditioning[lane] = conditioning;
    }
    trig_lanes::atan2(b, b_across, &mut out.scratch);
}

/// The words \[deg\] of a block that was pointed: u, v of the first branch, then of the second.
pub(super) fn both_words(
    set: InstructionSet,
    pointing: &Pointing,
    pointed: &mut PointedBlock,
    words_deg: [&mut Lane; 4],
) {
    match set {
        InstructionSet::Baseline => both_words_loop(pointing, pointed, words_deg),
        InstructionSet::Avx2 => both_words_avx2(pointing, pointed, words_deg),
        InstructionSet::Avx512 | InstructionSet::Fastest => both_words_avx512(pointing, pointed, words_deg),
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn both_words_avx2(pointing: &Pointing, pointed: &mut PointedBlock, words_deg: [&mut Lane; 4]) {
    both_words_loop(pointing, pointed, words_deg);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn both_words_avx512(pointing: &Pointing, pointed: &mut PointedBlock, words_deg: [&mut Lane; 4]) {
    both_words_loop(pointing, pointed, words_deg);
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn both_words_loop(pointing: &Pointing, pointed: &mut PointedBlock, words_deg: [&mut Lane; 4]) {
    let pointing = *pointing;
    let PointedBlock { b_rad, eta: [eta_y, eta_x], gamma: [gamma_y, gamma_x], scratch, .. } = pointed;
    let [first_u, first_v, second_u, second_v] = words_deg;
    for lane in 0..BLOCK {
        let (eta, gamma) = ([eta_y[lane], eta_x[lane]], [gamma_y[lane], gamma_x[lane]]);
        // Until the next loop.
        [first_u[lane], first_v[lane]] = turn_of_u(SIGNS[0], eta, gamma);
        [second_u[lane], second_v[lane]] = turn_of_u(SIGNS[1], eta, gamma);
    }
    trig_lanes::atan2(first_u, first_v, scratch);
    trig_lanes::atan2(second_u, second_v, scratch);
    for lane in 0..BLOCK {
        [first_u[lane], first_v[lane]] = pointing.words_deg(SIGNS[0], [first_u[lane], b_rad[lane]]);
        [second_u[lane], second_v[lane]] = pointing.words_deg(SIGNS[1], [second_u[lane], b_rad[lane]]);
    }
}

/// The chain for the linear words as plain numbers.
#[derive(Clone, Copy)]
pub(super) struct LinearChain {
    direction: [[f64; 3]; 2],
    point: [[f64; 3]; 2],
    offset: [f64; 3],
    /// Columns of S⁻¹.
    columns: [[f64; 3]; 3],
    sense: [f64; 2],
    head_axes: usize,
}

impl Kinematics {
    pub(super) fn linear_chain(&self) -> LinearChain {
        LinearChain {
            direction: self.screws.map(|screw| screw.direction.into()),
            point: self.screws.map(|screw| screw.point_mm.into()),
            offset: self.work_offset_mm.into(),
            columns: self.linear_words.into(),
            sense: self.sense,
            head_axes: self.head_axes,
        }
    }
}

/// Angles and linear words for chosen words and the tips of a block.
pub(super) fn join(
    set: InstructionSet,
    chain: &LinearChain,
    targets: Targets<'_>,
    block: &mut JointBlock,
    out: Joined<'_>,
) {
    match set {
        InstructionSet::Baseline => join_any(chain, targets, block, out),
        InstructionSet::Avx2 => join_avx2(chain, targets, block, out),
        InstructionSet::Avx512 | InstructionSet::Fastest => join_avx512(chain, targets, block, out),
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn join_avx2(chain: &LinearChain, targets: Targets<'_>, block: &mut JointBlock, out: Joined<'_>) {
    join_any(chain, targets, block, out);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn join_avx512(chain: &LinearChain, targets: Targets<'_>, block: &mut JointBlock, out: Joined<'_>) {
    join_any(chain, targets, block, out);
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn join_any(chain: &LinearChain, targets: Targets<'_>, block: &mut JointBlock, out: Joined<'_>) {
    match chain.head_axes {
        0 => join_loop::<0>(chain, targets, block, out),
        1 => join_loop::<1>(chain, targets, block, out),
        _ => join_loop::<2>(chain, targets, block, out),
    }
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn join_loop<const HEAD_AXES: usize>(
    chain: &LinearChain,
    targets: Targets<'_>,
    block: &mut JointBlock,
    out: Joined<'_>,
) {
    let chain = *chain;
    let Joined { linear_mm: [x, y, z], rotary_rad } = out;
    let Targets { words_deg, tip_mm } = targets;
    let JointBlock { sin, cos, between_mm: [between_x, between_y, between_z] } = block;
    for (k, angles_rad) in rotary_rad.into_iter().enumerate() {
        for lane in 0..BLOCK {
            angles_rad[lane] = chain.sense[k] * words_deg[k][lane].to_radians();
        }
        trig_lanes::sin_cos(angles_rad, &mut sin[k], &mut cos[k]);
    }
    let offset_tip = |lane: usize| sum([tip_mm[0][lane], tip_mm[1][lane], tip_mm[2][lane]], chain.offset);
    // Two turns in two loops: the same number for every machine.
    for lane in 0..BLOCK {
        let turned = if HEAD_AXES < 2 {
            carry(&chain, 0, [-sin[0][lane], cos[0][lane]], offset_tip(lane))
        } else {
            carry(&chain, 1, [sin[1][lane], cos[1][lane]], [0.0; 3])
        };
        [between_x[lane], between_y[lane], between_z[lane]] = turned;
    }
    for lane in 0..BLOCK {
        let turned = [between_x[lane], between_y[lane], between_z[lane]];
        let (p, from_tool) = match HEAD_AXES {
            0 => (carry(&chain, 1, [-sin[1][lane], cos[1][lane]], turned), [0.0; 3]),
            1 => (turned, carry(&chain, 1, [sin[1][lane], cos[1][lane]], [0.0; 3])),
            _ => (offset_tip(lane), carry(&chain, 0, [sin[0][lane], cos[0][lane]], turned)),
        };
        let p = difference(difference(p, chain.offset), from_tool);
        let [cx, cy, cz] = chain.columns;
        [x[lane], y[lane], z[lane]] = std::array::from_fn(|k| cx[k] * p[0] + cy[k] * p[1] + cz[k] * p[2]);
    }
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn carry(chain: &LinearChain, k: usize, [sin, cos]: [f64; 2], p: [f64; 3]) -> [f64; 3] {
    sum(turn(chain.direction[k], sin, cos, difference(p, chain.point[k])), chain.point[k])
}

/// The vector `v` turned about the unit direction `d` (Rodrigues), with the operations of the scalar screw.
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
pub(super) fn turn(d: [f64; 3], sin: f64, cos: f64, v: [f64; 3]) -> [f64; 3] {
    let dot = d[0] * v[0] + d[1] * v[1] + d[2] * v[2];
    let cross = [d[1] * v[2] - d[2] * v[1], d[2] * v[0] - d[0] * v[2], d[0] * v[1] - d[1] * v[0]];
    std::array::from_fn(|k| {
        let along = d[k] * dot;
        along + (v[k] - along) * cos + cross[k] * sin
    })
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
pub(super) fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
pub(super) fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
