//! The inverse for blocks of poses in structure-of-arrays form: directions first, linear words of the chosen
//! solution last. Same operations as the single pose, without fused multiply-add: same bits.

use multiversion::multiversion;

use super::pointing::Pointing;
use super::{InstructionSet, Kinematics, PoseLanes, ToolPose};
use crate::geometry::trig;

/// Poses treated at a time: all arrays of a block stay in the second-nearest cache.
pub(super) const BLOCK: usize = 256;
pub(super) type Lane = [f64; BLOCK];

/// Poses that can be loaded into blocks.
pub(super) trait PoseSource {
    fn count(&self) -> usize;
    fn pose(&self, index: usize) -> ToolPose;
    /// Loads up to a block of poses from `start` on.
    fn load(&self, start: usize, block: &mut PoseBlock) -> usize;
}

/// A block of poses: x y z, i j k.
pub(super) struct PoseBlock {
    pub(super) tip_mm: [Lane; 3],
    pub(super) axis: [Lane; 3],
}

impl PoseBlock {
    pub(super) fn new() -> Self {
        Self { tip_mm: [[0.0; BLOCK]; 3], axis: [[0.0; BLOCK], [0.0; BLOCK], [1.0; BLOCK]] }
    }
}

impl PoseSource for [ToolPose] {
    fn count(&self) -> usize {
        self.len()
    }
    fn pose(&self, index: usize) -> ToolPose {
        self[index]
    }
    fn load(&self, start: usize, block: &mut PoseBlock) -> usize {
        let poses = &self[start..self.len().min(start + BLOCK)];
        for (lane, pose) in poses.iter().enumerate() {
            for k in 0..3 {
                block.tip_mm[k][lane] = pose.tip_mm[k];
                block.axis[k][lane] = pose.axis[k];
            }
        }
        poses.len()
    }
}

impl PoseSource for PoseLanes {
    fn count(&self) -> usize {
        self.len()
    }
    fn pose(&self, index: usize) -> ToolPose {
        ToolPose {
            tip_mm: [self.x_mm[index], self.y_mm[index], self.z_mm[index]].into(),
            axis: [self.i[index], self.j[index], self.k[index]].into(),
        }
    }
    fn load(&self, start: usize, block: &mut PoseBlock) -> usize {
        let end = self.len().min(start + BLOCK);
        let [x, y, z] = &mut block.tip_mm;
        let [i, j, k] = &mut block.axis;
        let pairs =
            [(x, &self.x_mm), (y, &self.y_mm), (z, &self.z_mm), (i, &self.i), (j, &self.j), (k, &self.k)];
        for (lane, from) in pairs {
            lane[..end - start].copy_from_slice(&from[start..end]);
        }
        end - start
    }
}

/// The directions' part of a block.
pub(super) struct PointedBlock {
    /// Words of u, v \[deg\] of the first branch, then of the second.
    pub(super) words_deg: [Lane; 4],
    pub(super) conditioning: Lane,
    /// Not positive where the lane needs care: near pole or reach limit, or no direction.
    pub(super) margin: Lane,
}

impl PointedBlock {
    pub(super) fn new() -> Self {
        Self { words_deg: [[0.0; BLOCK]; 4], conditioning: [0.0; BLOCK], margin: [0.0; BLOCK] }
    }
}

/// Linear words and kinematic angles of chosen words.
pub(super) struct JointBlock {
    /// Words of u, v \[deg\]: what goes in.
    pub(super) words_deg: [Lane; 2],
    /// θ of u, v \[rad\].
    pub(super) rotary_rad: [Lane; 2],
    /// X Y Z \[mm\].
    pub(super) linear_mm: [Lane; 3],
}

impl JointBlock {
    pub(super) fn new() -> Self {
        Self { words_deg: [[0.0; BLOCK]; 2], rotary_rad: [[0.0; BLOCK]; 2], linear_mm: [[0.0; BLOCK]; 3] }
    }
}

/// N and D below this need care: the solutions nearly meet.
const REACH_MARGIN: f64 = 1e-9;

/// Solves the directions of a block; `cone_sin2` is sin² of the half-angle of the pole cone, widened.
pub(super) fn point(
    set: InstructionSet,
    pointing: &Pointing,
    cone_sin2: f64,
    poses: &PoseBlock,
    out: &mut PointedBlock,
) {
    match set {
        InstructionSet::Baseline => point_loop(pointing, cone_sin2, &poses.axis, out),
        InstructionSet::Avx2 => point_avx2(pointing, cone_sin2, &poses.axis, out),
        InstructionSet::Avx512 | InstructionSet::Fastest => {
            point_avx512(pointing, cone_sin2, &poses.axis, out);
        }
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn point_avx2(pointing: &Pointing, cone_sin2: f64, axis: &[Lane; 3], out: &mut PointedBlock) {
    point_loop(pointing, cone_sin2, axis, out);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn point_avx512(pointing: &Pointing, cone_sin2: f64, axis: &[Lane; 3], out: &mut PointedBlock) {
    point_loop(pointing, cone_sin2, axis, out);
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn point_loop(pointing: &Pointing, cone_sin2: f64, axis: &[Lane; 3], out: &mut PointedBlock) {
    let pointing = *pointing;
    #[expect(clippy::needless_range_loop, reason = "many arrays side by side")]
    for lane in 0..BLOCK {
        let (i, j, k) = (axis[0][lane], axis[1][lane], axis[2][lane]);
        let length = (i * i + j * j + k * k).sqrt();
        let pointed = pointing.solve([i / length, j / length, k / length]);
        out.words_deg[0][lane] = pointed.words_deg[0][0];
        out.words_deg[1][lane] = pointed.words_deg[0][1];
        out.words_deg[2][lane] = pointed.words_deg[1][0];
        out.words_deg[3][lane] = pointed.words_deg[1][1];
        out.conditioning[lane] = pointed.conditioning;
        let [sin2, cos2] = pointed.half_tilt;
        let polar = 4.0 * sin2 * cos2 - cone_sin2;
        let reach = if pointed.reach[0] < pointed.reach[1] { pointed.reach[0] } else { pointed.reach[1] };
        let reach = reach - REACH_MARGIN;
        let least = if polar < reach { polar } else { reach };
        // lengths that cannot be squared lose the margin, as does what is not a number
        let sound = length > 1e-100 && length < 1e100;
        out.margin[lane] = if sound { least } else { -1.0 };
    }
}

/// The chain towards the linear words as plain numbers.
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
pub(super) fn join(set: InstructionSet, chain: &LinearChain, tip_mm: &[Lane; 3], block: &mut JointBlock) {
    match set {
        InstructionSet::Baseline => join_any(chain, tip_mm, block),
        InstructionSet::Avx2 => join_avx2(chain, tip_mm, block),
        InstructionSet::Avx512 | InstructionSet::Fastest => join_avx512(chain, tip_mm, block),
    }
}

#[multiversion(targets("x86_64+avx2"))]
fn join_avx2(chain: &LinearChain, tip_mm: &[Lane; 3], block: &mut JointBlock) {
    join_any(chain, tip_mm, block);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn join_avx512(chain: &LinearChain, tip_mm: &[Lane; 3], block: &mut JointBlock) {
    join_any(chain, tip_mm, block);
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn join_any(chain: &LinearChain, tip_mm: &[Lane; 3], block: &mut JointBlock) {
    match chain.head_axes {
        0 => join_loop::<0>(chain, tip_mm, block),
        1 => join_loop::<1>(chain, tip_mm, block),
        _ => join_loop::<2>(chain, tip_mm, block),
    }
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn join_loop<const HEAD_AXES: usize>(chain: &LinearChain, tip_mm: &[Lane; 3], block: &mut JointBlock) {
    let chain = *chain;
    #[expect(clippy::needless_range_loop, reason = "many arrays side by side")]
    for lane in 0..BLOCK {
        let (mut sin, mut cos) = ([0.0; 2], [0.0; 2]);
        for k in 0..2 {
            let angle = chain.sense[k] * block.words_deg[k][lane].to_radians();
            block.rotary_rad[k][lane] = angle;
            (sin[k], cos[k]) = trig::sin_cos(angle);
        }
        let mut from_workpiece = sum([tip_mm[0][lane], tip_mm[1][lane], tip_mm[2][lane]], chain.offset);
        let mut from_tool = [0.0; 3];
        for (count, k) in [1, 0].into_iter().enumerate() {
            if count < HEAD_AXES {
                from_tool = carry(&chain, k, sin[k], cos[k], from_tool);
            }
        }
        for k in 0..2 - HEAD_AXES {
            from_workpiece = carry(&chain, k, -sin[k], cos[k], from_workpiece);
        }
        let p = difference(difference(from_workpiece, chain.offset), from_tool);
        let [cx, cy, cz] = chain.columns;
        for k in 0..3 {
            block.linear_mm[k][lane] = cx[k] * p[0] + cy[k] * p[1] + cz[k] * p[2];
        }
    }
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn carry(chain: &LinearChain, k: usize, sin: f64, cos: f64, p: [f64; 3]) -> [f64; 3] {
    let turned = turn(chain.direction[k], sin, cos, difference(p, chain.point[k]));
    sum(turned, chain.point[k])
}

/// The vector `v` turned about the unit direction `d` (Rodrigues), as the scalar screw does it.
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
