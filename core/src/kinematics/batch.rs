//! Forward kinematics of many joints at once, in structure-of-arrays form.
//!
//! The loops do the same operations as the scalar chain, one by one and without fused multiply-add. They give
//! the same bits on every instruction set, and the same as [`Kinematics::forward`].

use multiversion::multiversion;

use super::lanes::{difference, sum, turn};
use super::{InstructionSet, Joints, Kinematics, ToolPose};
use crate::geometry::trig;
use crate::machine::Machine;

/// Number of lanes that a loop processes together: all its arrays stay in the nearest cache.
const BLOCK: usize = 64;

/// Joints as arrays of equal length: linear words \[mm\] and kinematic angles \[rad\] in the profile's order.
#[derive(Debug, Clone, PartialEq, Default)]
#[expect(missing_docs, reason = "the letters are those of the type's own doc")]
pub struct JointLanes {
    pub x_mm: Vec<f64>,
    pub y_mm: Vec<f64>,
    pub z_mm: Vec<f64>,
    pub first_rad: Vec<f64>,
    pub second_rad: Vec<f64>,
}

/// Tool poses in W as arrays of equal length: tip \[mm\] and unit axis.
#[derive(Debug, Clone, PartialEq, Default)]
#[expect(missing_docs, reason = "the letters are those of the type's own doc")]
pub struct PoseLanes {
    pub x_mm: Vec<f64>,
    pub y_mm: Vec<f64>,
    pub z_mm: Vec<f64>,
    pub i: Vec<f64>,
    pub j: Vec<f64>,
    pub k: Vec<f64>,
}

impl JointLanes {
    /// The number of complete lanes: the length of the shortest array.
    #[must_use]
    pub fn len(&self) -> usize {
        [&self.x_mm, &self.y_mm, &self.z_mm, &self.first_rad, &self.second_rad]
            .iter()
            .map(|lane| lane.len())
            .min()
            .unwrap_or(0)
    }

    /// Whether there is no complete lane.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Removes all lanes and keeps the memory.
    pub fn clear(&mut self) {
        for lane in self.each_mut() {
            lane.clear();
        }
    }

    pub(super) fn each_mut(&mut self) -> [&mut Vec<f64>; 5] {
        [&mut self.x_mm, &mut self.y_mm, &mut self.z_mm, &mut self.first_rad, &mut self.second_rad]
    }

    /// `N` lanes from `begin` on; `None` if there are fewer.
    pub(super) fn block_mut<const N: usize>(&mut self, begin: usize) -> Option<[&mut [f64; N]; 5]> {
        let end = begin + N;
        let Self { x_mm, y_mm, z_mm, first_rad, second_rad } = self;
        Some([
            x_mm.get_mut(begin..end)?.as_mut_array()?,
            y_mm.get_mut(begin..end)?.as_mut_array()?,
            z_mm.get_mut(begin..end)?.as_mut_array()?,
            first_rad.get_mut(begin..end)?.as_mut_array()?,
            second_rad.get_mut(begin..end)?.as_mut_array()?,
        ])
    }

    /// Replaces all lanes by these: linear words \[mm\] and kinematic angles \[rad\].
    #[inline]
    pub fn fill(&mut self, joints: impl ExactSizeIterator<Item = ([f64; 3], [f64; 2])>) {
        let count = joints.len();
        let Self { x_mm, y_mm, z_mm, first_rad, second_rad } = self;
        for lane in [&mut *x_mm, y_mm, z_mm, first_rad, second_rad] {
            lane.resize(count, 0.0);
        }
        let places = x_mm.iter_mut().zip(y_mm).zip(z_mm).zip(first_rad).zip(second_rad);
        for (((((x, y), z), first), second), (linear_mm, rotary_rad)) in places.zip(joints) {
            [*x, *y, *z] = linear_mm;
            [*first, *second] = rotary_rad;
        }
    }

    /// Adds one lane.
    #[inline]
    pub fn push(&mut self, linear_mm: [f64; 3], rotary_rad: [f64; 2]) {
        self.x_mm.push(linear_mm[0]);
        self.y_mm.push(linear_mm[1]);
        self.z_mm.push(linear_mm[2]);
        self.first_rad.push(rotary_rad[0]);
        self.second_rad.push(rotary_rad[1]);
    }
}

impl PoseLanes {
    /// The number of complete lanes: the length of the shortest array.
    #[must_use]
    pub fn len(&self) -> usize {
        [&self.x_mm, &self.y_mm, &self.z_mm, &self.i, &self.j, &self.k]
            .iter()
            .map(|lane| lane.len())
            .min()
            .unwrap_or(0)
    }

    /// Whether there is no complete lane.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// No lanes, with memory for `count`.
    #[must_use]
    pub fn with_capacity(count: usize) -> Self {
        let mut lanes = Self::default();
        for lane in lanes.each_mut() {
            lane.reserve_exact(count);
        }
        lanes
    }

    /// Removes all lanes and keeps the memory.
    pub fn clear(&mut self) {
        for lane in self.each_mut() {
            lane.clear();
        }
    }

    /// Appends the lanes of `other`.
    pub fn extend(&mut self, other: &Self) {
        let others = [&other.x_mm, &other.y_mm, &other.z_mm, &other.i, &other.j, &other.k];
        for (lane, other) in self.each_mut().into_iter().zip(others) {
            lane.extend_from_slice(other);
        }
    }

    /// The pose of one lane.
    #[inline]
    pub(crate) fn pose(&self, index: usize) -> ToolPose {
        ToolPose {
            tip_mm: [self.x_mm[index], self.y_mm[index], self.z_mm[index]].into(),
            axis: [self.i[index], self.j[index], self.k[index]].into(),
        }
    }

    /// Adds one lane.
    pub fn push(&mut self, pose: ToolPose) {
        let ToolPose { tip_mm, axis } = pose;
        for (lane, value) in
            self.each_mut().into_iter().zip([tip_mm.x, tip_mm.y, tip_mm.z, axis.x, axis.y, axis.z])
        {
            lane.push(value);
        }
    }

    fn each_mut(&mut self) -> [&mut Vec<f64>; 6] {
        [&mut self.x_mm, &mut self.y_mm, &mut self.z_mm, &mut self.i, &mut self.j, &mut self.k]
    }

    fn resize(&mut self, count: usize) {
        for lane in self.each_mut() {
            lane.resize(count, 0.0);
        }
    }
}

/// The chain as plain numbers for the loops.
#[derive(Debug, Clone, Copy)]
struct Chain {
    direction: [[f64; 3]; 2],
    point: [[f64; 3]; 2],
    offset: [f64; 3],
    columns: [[f64; 3]; 3],
}

impl Kinematics {
    /// The poses of all lanes of `joints`, written into `poses`, which gets the same length. Each lane equals
    /// [`Kinematics::forward`] to the bit, on every instruction set.
    pub fn forward_lanes(&self, joints: &JointLanes, poses: &mut PoseLanes) {
        self.forward_lanes_on(InstructionSet::Fastest, joints, poses);
    }

    /// [`Kinematics::forward_lanes`] without instructions wider than `set`: to measure, and to prove that the
    /// bits agree.
    pub fn forward_lanes_on(&self, set: InstructionSet, joints: &JointLanes, poses: &mut PoseLanes) {
        let count = joints.len();
        poses.resize(count);
        let chain = self.chain();
        let mut input = [[0.0; BLOCK]; 5];
        let mut output = [[0.0; BLOCK]; 6];
        for start in (0..count).step_by(BLOCK) {
            let end = (start + BLOCK).min(count);
            let source = [&joints.x_mm, &joints.y_mm, &joints.z_mm, &joints.first_rad, &joints.second_rad];
            for (lane, from) in input.iter_mut().zip(source) {
                lane[..end - start].copy_from_slice(&from[start..end]);
            }
            if self.profile_index[0] == 1 {
                input.swap(3, 4);
            }
            match set {
                InstructionSet::Baseline => forward_block(&chain, self.head_axes, &input, &mut output),
                InstructionSet::Avx2 => forward_avx2(&chain, self.head_axes, &input, &mut output),
                InstructionSet::Avx512 | InstructionSet::Fastest => {
                    forward_avx512(&chain, self.head_axes, &input, &mut output);
                }
            }
            let target =
                [&mut poses.x_mm, &mut poses.y_mm, &mut poses.z_mm, &mut poses.i, &mut poses.j, &mut poses.k];
            for (lane, to) in output.iter().zip(target) {
                to[start..end].copy_from_slice(&lane[..end - start]);
            }
        }
    }

    /// The poses of a few joints at once. Each equals [`Kinematics::forward`] to the bit, on every instruction set.
    #[must_use]
    pub fn forward_few<const N: usize>(&self, joints: &[Joints; N]) -> [ToolPose; N] {
        let mut input = [[0.0; N]; 5];
        for (lane, Joints { linear_mm, rotary_rad }) in joints.iter().enumerate() {
            let [u, v] = self.profile_index;
            let values = [linear_mm.x, linear_mm.y, linear_mm.z, rotary_rad[u], rotary_rad[v]];
            for (to, value) in input.iter_mut().zip(values) {
                to[lane] = value;
            }
        }
        let mut output = [[0.0; N]; 6];
        forward_avx512(&self.chain(), self.head_axes, &input, &mut output);
        let [x, y, z, i, j, k] = output;
        std::array::from_fn(|lane| ToolPose {
            tip_mm: [x[lane], y[lane], z[lane]].into(),
            axis: [i[lane], j[lane], k[lane]].into(),
        })
    }

    fn chain(&self) -> Chain {
        Chain {
            direction: self.screws.map(|screw| screw.direction.into()),
            point: self.screws.map(|screw| screw.point_mm.into()),
            offset: self.work_offset_mm.into(),
            columns: self.linear_directions.into(),
        }
    }
}

/// X Y Z \[mm\] and the angles of u and v \[rad\] of `N` lanes.
type Input<const N: usize> = [[f64; N]; 5];
/// Tip \[mm\] and axis of `N` lanes.
type Output<const N: usize> = [[f64; N]; 6];

#[multiversion(targets("x86_64+avx2"))]
fn forward_avx2<const N: usize>(chain: &Chain, head_axes: usize, joints: &Input<N>, poses: &mut Output<N>) {
    forward_block(chain, head_axes, joints, poses);
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn forward_avx512<const N: usize>(chain: &Chain, head_axes: usize, joints: &Input<N>, poses: &mut Output<N>) {
    forward_block(chain, head_axes, joints, poses);
}

/// The position of the linear axes in the chain is fixed outside the loop.
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn forward_block<const N: usize>(chain: &Chain, head_axes: usize, joints: &Input<N>, poses: &mut Output<N>) {
    match head_axes {
        0 => forward_loop::<0, N>(chain, joints, poses),
        1 => forward_loop::<1, N>(chain, joints, poses),
        _ => forward_loop::<2, N>(chain, joints, poses),
    }
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn forward_loop<const HEAD_AXES: usize, const N: usize>(
    chain: &Chain,
    joints: &Input<N>,
    poses: &mut Output<N>,
) {
    let (mut sin, mut cos) = ([[0.0; N]; 2], [[0.0; N]; 2]);
    for k in 0..2 {
        for lane in 0..N {
            (sin[k][lane], cos[k][lane]) = trig::sin_cos(joints[3 + k][lane]);
        }
    }
    let tool = [Machine::TOOL_AXIS.x, Machine::TOOL_AXIS.y, Machine::TOOL_AXIS.z];
    for lane in 0..N {
        let turned = turn(chain.direction[1], sin[1][lane], cos[1][lane], tool);
        let axis = turn(chain.direction[0], sin[0][lane], cos[0][lane], turned);
        for k in 0..3 {
            poses[3 + k][lane] = axis[k];
        }
    }
    for lane in 0..N {
        let (x, y, z) = (joints[0][lane], joints[1][lane], joints[2][lane]);
        let [cx, cy, cz] = chain.columns;
        let linear: [f64; 3] = std::array::from_fn(|k| cx[k] * x + cy[k] * y + cz[k] * z + chain.offset[k]);
        let mut p = [0.0; 3];
        for (stage, k) in [1, 0].into_iter().enumerate() {
            if stage == HEAD_AXES {
                p = sum(p, linear);
            }
            let turned = turn(chain.direction[k], sin[k][lane], cos[k][lane], difference(p, chain.point[k]));
            p = sum(turned, chain.point[k]);
        }
        if HEAD_AXES == 2 {
            p = sum(p, linear);
        }
        let tip = difference(p, chain.offset);
        for k in 0..3 {
            poses[k][lane] = tip[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Vec3;
    use crate::kinematics::{Joints, Setup};
    use crate::machine::{LocationError, MachineParts, RotaryAxis, RotaryLetter, Side, Squareness};

    fn skewed(sides: [Side; 2]) -> Machine {
        let axis = |letter, side, direction, point_mm| RotaryAxis {
            letter,
            side,
            direction,
            point_mm,
            travel_deg: None,
            reversed: false,
            location_error: LocationError {
                translation_mm: Vec3::new(0.01, -0.02, 0.03),
                rotation_rad: Vec3::new(1e-4, 2e-4, -3e-4),
            },
        };
        Machine::new(MachineParts {
            name: String::new(),
            rotary_axes: vec![
                axis(RotaryLetter::A, sides[0], Vec3::new(1.0, 0.2, 0.0), Vec3::new(1.0, 2.0, -3.0)),
                axis(RotaryLetter::B, sides[1], Vec3::new(0.0, 1.0, 0.4), Vec3::new(1.5, 2.2, 80.0)),
            ],
            linear_travel_mm: [None; 3],
            squareness: Squareness { e_c0y_rad: 1e-4, e_b0z_rad: -2e-4, e_a0z_rad: 3e-4 },
            interpolation_period_s: 0.002,
        })
        .unwrap()
    }

    #[test]
    fn lanes_equal_the_scalar_chain_to_the_bit_on_every_instruction_set() {
        for sides in [
            [Side::Table, Side::Table],
            [Side::Head, Side::Table],
            [Side::Table, Side::Head],
            [Side::Head; 2],
        ] {
            let setup = Setup {
                work_offset_mm: Vec3::new(70.0, -40.0, 95.0),
                tool_length_mm: 50.0,
                apply_errors: true,
            };
            let kinematics = Kinematics::new(&skewed(sides), &setup);
            let mut joints = JointLanes::default();
            for n in 0..203 {
                let f = f64::from(n);
                joints.push([f * 1.3, 50.0 - f, (f * 0.1).sin()], [f * 0.37 - 30.0, f * f * 0.1 - 1000.0]);
            }
            let mut poses = PoseLanes::default();
            for set in [
                InstructionSet::Baseline,
                InstructionSet::Avx2,
                InstructionSet::Avx512,
                InstructionSet::Fastest,
            ] {
                kinematics.forward_lanes_on(set, &joints, &mut poses);
                assert_eq!(poses.len(), joints.len());
                for n in 0..joints.len() {
                    let scalar = kinematics.forward(&Joints {
                        linear_mm: Vec3::new(joints.x_mm[n], joints.y_mm[n], joints.z_mm[n]),
                        rotary_rad: [joints.first_rad[n], joints.second_rad[n]],
                    });
                    let lane_tip = Vec3::new(poses.x_mm[n], poses.y_mm[n], poses.z_mm[n]);
                    let lane_axis = Vec3::new(poses.i[n], poses.j[n], poses.k[n]);
                    assert_eq!((scalar.tip_mm, scalar.axis), (lane_tip, lane_axis), "{set:?} {n}");
                }
            }
        }
    }
}
