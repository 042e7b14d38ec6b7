//! Quick looks at many motions whose contact is the tip, in lanes.
//!
//! Reason: most motions of most programs need only [`quick_look`](super::quick_look). In a program without stated
//! contacts, the tip is the contact of every motion. For an ISO program, judging and writing a block fell from 2130 to
//! 1200 instructions, and preparing it rose from 530 to 900. Price: the formula of the deviation is here a second time,
//! with plain numbers. A test compares every bit with [`quick_look`](super::quick_look), the plain version.

use multiversion::multiversion;

use super::deviation::POINT_LENGTH_MM;
use super::quick::MIDPOINT_SLACK;
use super::{Deviation, QuickLook};
use crate::kinematics::{Kinematics, TipCurvature};
use crate::motion::Interpolation;

/// A quick look at a motion whose contact is the tip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TipLook {
    /// The deviation in the middle \[mm\].
    pub middle_mm: f64,
    /// Bound on the deviation of every point of the motion \[mm\].
    pub at_most_mm: f64,
    /// Length of the contact line \[mm\].
    pub path_mm: f64,
}

impl TipLook {
    /// The same look in the form of one motion.
    #[must_use]
    #[inline]
    pub fn alone(&self) -> QuickLook {
        let middle = Deviation { distance_mm: self.middle_mm, along_normal_mm: 0.0 };
        QuickLook { middle, at_most_mm: self.at_most_mm }
    }

    /// No look at the motion: nothing is known, and no comparison with a bound holds.
    pub const NONE: Self = Self { middle_mm: f64::NAN, at_most_mm: f64::NAN, path_mm: f64::NAN };
}

/// The places of consecutive motions as arrays of equal length. The lane of a motion holds its end; the lane before
/// holds its start. All have the same set-up and interpolation mode.
#[derive(Debug, Clone, Copy)]
pub struct TipPaths<'a> {
    /// Linear words \[mm\].
    pub linear_mm: [&'a [f64]; 3],
    /// Rotary words, profile order \[deg\].
    pub rotary_deg: [&'a [f64]; 2],
    /// Tips in W \[mm\].
    pub tip_mm: [&'a [f64]; 3],
    /// Tips in W half way to the end \[mm\].
    pub middle_mm: [&'a [f64]; 3],
}

/// Motions looked at together.
const LANES: usize = 8;

/// Looks at all motions but the first, which has no lane before it. `looks` gets one entry for each motion.
pub fn look_at_tips(
    kinematics: &Kinematics,
    mode: Interpolation,
    paths: &TipPaths<'_>,
    looks: &mut Vec<TipLook>,
) {
    let count = paths.tip_mm[0].len();
    if count == 0 {
        return;
    }
    looks.push(TipLook::NONE);
    let curvature = match mode {
        Interpolation::Tcp => None,
        Interpolation::Machine => Some(kinematics.tip_curvature()),
    };
    let mut block = Block::new();
    let mut found = [TipLook::NONE; LANES];
    let mut from = 1;
    while from < count {
        let lanes = LANES.min(count - from);
        block.load(paths, from, lanes);
        look_at_block(curvature.as_ref(), &block, &mut found);
        looks.extend_from_slice(&found[..lanes]);
        from += lanes;
    }
}

/// Starts, ends and middles of a few motions.
struct Block {
    linear_mm: [[[f64; LANES]; 3]; 2],
    rotary_deg: [[[f64; LANES]; 2]; 2],
    tip_mm: [[[f64; LANES]; 3]; 2],
    middle_mm: [[f64; LANES]; 3],
}

impl Block {
    fn new() -> Self {
        let lane = [0.0; LANES];
        Self {
            linear_mm: [[lane; 3]; 2],
            rotary_deg: [[lane; 2]; 2],
            tip_mm: [[lane; 3]; 2],
            middle_mm: [lane; 3],
        }
    }

    fn load(&mut self, paths: &TipPaths<'_>, from: usize, lanes: usize) {
        let Self { linear_mm, rotary_deg, tip_mm, middle_mm } = self;
        let copy = |to: &mut [f64; LANES], of: &[f64], from: usize| {
            to[..lanes].copy_from_slice(&of[from..from + lanes]);
        };
        for end in [0, 1] {
            let at = from - 1 + end;
            for (to, of) in linear_mm[end].iter_mut().zip(paths.linear_mm) {
                copy(to, of, at);
            }
            for (to, of) in tip_mm[end].iter_mut().zip(paths.tip_mm) {
                copy(to, of, at);
            }
            for (to, of) in rotary_deg[end].iter_mut().zip(paths.rotary_deg) {
                copy(to, of, at);
            }
        }
        for (to, of) in middle_mm.iter_mut().zip(paths.middle_mm) {
            copy(to, of, from);
        }
    }
}

#[multiversion(targets("x86_64+avx512f+avx512dq+avx512vl", "x86_64+avx2"))]
fn look_at_block(curvature: Option<&TipCurvature>, block: &Block, found: &mut [TipLook; LANES]) {
    let (mut middles, mut bounds, mut lengths) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
    for lane in 0..LANES {
        let [start, end] = [0, 1].map(|end| [0, 1, 2].map(|k| block.tip_mm[end][k][lane]));
        let middle = [0, 1, 2].map(|k| block.middle_mm[k][lane]);
        (lengths[lane], middles[lane]) = off_line(start, end, middle);
    }
    if let Some(curvature) = curvature {
        for lane in 0..LANES {
            let ends = |of: &[[[f64; LANES]; 3]; 2]| [0, 1].map(|end| [0, 1, 2].map(|k| of[end][k][lane]));
            let turns = [0, 1]
                .map(|k| (block.rotary_deg[1][k][lane] - block.rotary_deg[0][k][lane]).abs().to_radians());
            bounds[lane] = curvature.bound_mm(ends(&block.linear_mm), ends(&block.tip_mm), turns);
        }
    }
    for lane in 0..LANES {
        let at_most_mm = middles[lane] + MIDPOINT_SLACK * bounds[lane];
        found[lane] = TipLook { middle_mm: middles[lane], at_most_mm, path_mm: lengths[lane] };
    }
}

/// The length of the line between two points, and the distance of a third point from it \[mm\].
#[inline(always)]
#[expect(clippy::inline_always, reason = "compiled into loops for several instruction sets")]
fn off_line(start: [f64; 3], end: [f64; 3], point: [f64; 3]) -> (f64, f64) {
    let norm = |[x, y, z]: [f64; 3]| (x * x + y * y + z * z).sqrt();
    let along = [0, 1, 2].map(|k| end[k] - start[k]);
    let length = norm(along);
    let is_point = length < POINT_LENGTH_MM;
    let direction = along.map(|k| k / length);
    let to = [0, 1, 2].map(|k| point[k] - start[k]);
    let reach = direction[0] * to[0] + direction[1] * to[1] + direction[2] * to[2];
    let foot = [0, 1, 2].map(|k| if is_point { start[k] } else { start[k] + direction[k] * reach });
    (length, norm([0, 1, 2].map(|k| point[k] - foot[k])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{CutterContact, Station, quick_look};
    use crate::geometry::Vec3;
    use crate::kinematics::Setup;
    use crate::machine::{Machine, PRESETS, Tool};
    use crate::motion::AxisWords;
    use crate::units::Length;

    #[test]
    fn lanes_give_the_bits_of_one_quick_look_at_a_time() {
        let tool = Tool::new(Length::from_mm(5.0), Length::from_mm(5.0)).unwrap();
        for preset in &PRESETS {
            let machine = Machine::new(preset.parts()).unwrap();
            let setup =
                Setup { work_offset_mm: Vec3::new(7.0, -4.0, 9.0), tool_length_mm: 80.0, ..Setup::default() };
            let kinematics = Kinematics::new(&machine, &setup);
            for mode in [Interpolation::Machine, Interpolation::Tcp] {
                // Small and large turns, a rest, and a motion that only turns.
                let words: Vec<AxisWords> = (0..45)
                    .map(|step| {
                        let a = f64::from(step);
                        let turn = if step % 9 == 0 { 40.0 } else { 1.5 };
                        let linear_mm =
                            [20.0 + 3.0 * (0.7 * a).sin(), -11.0 + 0.4 * a, 5.0 * (0.2 * a).cos()];
                        AxisWords { linear_mm, rotary_deg: [turn * (0.3 * a).sin(), 2.0 * a - 17.0] }
                    })
                    .flat_map(|words| {
                        let turned = AxisWords { rotary_deg: [words.rotary_deg[0] + 0.5, 3.0], ..words };
                        [words, words, turned]
                    })
                    .collect();
                let at = |words: AxisWords| Station::new(&machine, &kinematics, mode, words);
                let stations: Vec<Station> = words.iter().map(|words| at(*words)).collect();
                let half = |a: &AxisWords, b: &AxisWords| AxisWords {
                    linear_mm: [0, 1, 2].map(|k| 0.5 * (a.linear_mm[k] + b.linear_mm[k])),
                    rotary_deg: [0, 1].map(|k| 0.5 * (a.rotary_deg[k] + b.rotary_deg[k])),
                };
                let middles: Vec<Station> = (0..words.len())
                    .map(|index| at(half(&words[index.saturating_sub(1)], &words[index])))
                    .collect();
                let lanes = |of: &dyn Fn(usize) -> f64| (0..words.len()).map(of).collect::<Vec<f64>>();
                let linear = [0, 1, 2].map(|k| lanes(&|index| words[index].linear_mm[k]));
                let rotary = [0, 1].map(|k| lanes(&|index| words[index].rotary_deg[k]));
                let tip = [0, 1, 2].map(|k| lanes(&|index| stations[index].pose.tip_mm[k]));
                let middle = [0, 1, 2].map(|k| lanes(&|index| middles[index].pose.tip_mm[k]));
                let paths = TipPaths {
                    linear_mm: linear.each_ref().map(Vec::as_slice),
                    rotary_deg: rotary.each_ref().map(Vec::as_slice),
                    tip_mm: tip.each_ref().map(Vec::as_slice),
                    middle_mm: middle.each_ref().map(Vec::as_slice),
                };
                let mut looks = Vec::new();
                look_at_tips(&kinematics, mode, &paths, &mut looks);
                assert_eq!(looks.len(), words.len());
                let contacts = [&CutterContact::Tip; 2];
                for (index, look) in looks.iter().enumerate().skip(1) {
                    let ends = [&stations[index - 1], &stations[index]];
                    let tips = ends.map(|end| end.pose.tip_mm);
                    let pose = &middles[index].pose;
                    let plain = quick_look(&kinematics, &tool, mode, ends, contacts, tips, pose).unwrap();
                    let bits = [look.middle_mm, look.at_most_mm, look.path_mm].map(f64::to_bits);
                    let expected = [plain.middle.distance_mm, plain.at_most_mm, (tips[1] - tips[0]).norm()];
                    assert_eq!(bits, expected.map(f64::to_bits), "{} {mode:?} {index}", preset.id);
                }
            }
        }
    }
}
