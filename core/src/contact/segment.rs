//! A block as motion: two stations and the machine's motion between them.

use std::sync::Arc;

use super::{Carry, ContactLine};
use crate::geometry::Vec3;
use crate::kinematics::{Joints, Kinematics, ToolPose};
use crate::machine::{Machine, Tool};
use crate::motion::{AxisWords, Interpolation};

/// One programmed point: its words, and the pose that they give.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// Linear words \[mm\] and rotary words \[deg\].
    pub words: AxisWords,
    /// The tool in W.
    pub pose: ToolPose,
}

impl Station {
    /// The station reached with these words. In machine interpolation the linear words are axis positions; with
    /// TCP they are the tip in W.
    #[must_use]
    pub fn new(machine: &Machine, kinematics: &Kinematics, mode: Interpolation, words: AxisWords) -> Self {
        let linear = Vec3::from(words.linear_mm);
        let rotary_rad = rotary_rad(machine, words.rotary_deg);
        let pose = match mode {
            Interpolation::Machine => kinematics.forward(&Joints { linear_mm: linear, rotary_rad }),
            Interpolation::Tcp => ToolPose { tip_mm: linear, axis: kinematics.axis(rotary_rad) },
        };
        Self { words, pose }
    }
}

/// Kinematic angles \[rad\] of rotary words \[deg\], in the profile's order.
#[must_use]
#[inline]
pub fn rotary_rad(machine: &Machine, rotary_deg: [f64; 2]) -> [f64; 2] {
    let [first, second] = machine.rotary_axes();
    [first.angle_rad(rotary_deg[0]), second.angle_rad(rotary_deg[1])]
}

/// The point in W \[mm\] that three linear words give together with these rotary words. Under tool-centre-point control
/// it is the words themselves. In machine interpolation the kinematics give it.
#[must_use]
#[inline]
pub fn stated_point_mm(
    machine: &Machine,
    kinematics: &Kinematics,
    mode: Interpolation,
    words_mm: [f64; 3],
    rotary_deg: [f64; 2],
) -> Vec3 {
    match mode {
        Interpolation::Tcp => Vec3::from(words_mm),
        Interpolation::Machine => kinematics.tip_mm(Vec3::from(words_mm), rotary_rad(machine, rotary_deg)),
    }
}

/// One linear block of a program with everything needed to judge it: the machine, the tool, the path of the
/// contact over the tool, and the line it should follow in W.
#[derive(Debug, Clone)]
pub struct SourceBlock<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// The machine with its set-up.
    pub kinematics: Arc<Kinematics>,
    /// The cutter.
    pub tool: Tool,
    /// Interpolation mode: of the axes, or of the tip in W.
    pub mode: Interpolation,
    /// Start and end as programmed.
    pub ends: [Station; 2],
    /// The path of the contact over the tool.
    pub carry: Carry,
    /// The line from the contact at the start to the contact at the end.
    pub line: ContactLine,
}

/// A stretch of a source block that the machine runs as one linear block: the whole block, or an inserted part.
#[derive(Debug, Clone, Copy)]
pub struct Segment {
    /// Its start and end.
    pub ends: [Station; 2],
    /// The fractions of the source block at its ends.
    pub fraction: [f64; 2],
}

impl<'a> SourceBlock<'a> {
    /// The block between two stations whose contacts are known.
    #[must_use]
    pub fn new(
        machine: &'a Machine,
        kinematics: &Arc<Kinematics>,
        tool: Tool,
        mode: Interpolation,
        ends: [Station; 2],
        carry: Carry,
    ) -> Self {
        let contact = |k: usize| {
            let pose = &ends[k].pose;
            #[expect(clippy::cast_precision_loss, reason = "0 or 1")]
            let u = k as f64;
            pose.tip_mm + carry.at(&tool, u, pose.axis).offset_mm
        };
        let line = ContactLine::new(contact(0), contact(1));
        Self { machine, kinematics: Arc::clone(kinematics), tool, mode, ends, carry, line }
    }

    /// The whole block, as the machine runs it.
    #[must_use]
    pub fn whole(&self) -> Segment {
        Segment { ends: self.ends, fraction: [0.0, 1.0] }
    }

    /// The words at the fraction `u` of the source block, unrounded.
    #[must_use]
    pub fn words_at(&self, u: f64) -> AxisWords {
        interpolate(&self.ends, u)
    }

    /// The tool's pose at `s` in [0, 1] of a segment: all five words linear in machine interpolation, with TCP
    /// the tip straight in W.
    #[must_use]
    pub fn pose_at(&self, segment: &Segment, s: f64) -> ToolPose {
        Station::new(self.machine, &self.kinematics, self.mode, interpolate(&segment.ends, s)).pose
    }

    /// [`Self::pose_at`] at several places, to the same bits.
    #[must_use]
    pub(super) fn poses_at<const N: usize>(&self, segment: &Segment, places: &[f64; N]) -> [ToolPose; N] {
        let joints = places.map(|s| {
            let words = interpolate(&segment.ends, s);
            let rotary_rad = rotary_rad(self.machine, words.rotary_deg);
            Joints { linear_mm: Vec3::from(words.linear_mm), rotary_rad }
        });
        let mut poses = self.kinematics.forward_few(&joints);
        if self.mode == Interpolation::Tcp {
            for (pose, joints) in poses.iter_mut().zip(&joints) {
                pose.tip_mm = joints.linear_mm;
            }
        }
        poses
    }
}

fn interpolate(ends: &[Station; 2], s: f64) -> AxisWords {
    let (a, b) = (&ends[0].words, &ends[1].words);
    let lerp = |from: f64, to: f64| from + (to - from) * s;
    AxisWords {
        linear_mm: std::array::from_fn(|k| lerp(a.linear_mm[k], b.linear_mm[k])),
        rotary_deg: std::array::from_fn(|k| lerp(a.rotary_deg[k], b.rotary_deg[k])),
    }
}
