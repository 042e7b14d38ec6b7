//! The poses of a batch's ends, many at a time: as meant, and as the machine would take them.

use crate::contact::{Station, rotary_rad};
use crate::geometry::Vec3;
use crate::kinematics::{JointLanes, Kinematics, PoseLanes, ToolPose};
use crate::machine::Machine;
use crate::motion::{AxisWords, Interpolation, Motion, MotionKind};

/// The source's poses at the ends of a batch's motions.
pub(super) struct Points<'a> {
    machine: &'a Machine,
    kinematics: &'a Kinematics,
    /// Who interpolates, where the parameter says so.
    interpolation: Option<Interpolation>,
    joints: JointLanes,
    ends: PoseLanes,
    /// The machine as it is, where the program was not made for it.
    real: Option<&'a Kinematics>,
    real_ends: PoseLanes,
}

impl<'a> Points<'a> {
    pub(super) fn new(
        machine: &'a Machine,
        kinematics: &'a Kinematics,
        interpolation: Option<Interpolation>,
        real: Option<&'a Kinematics>,
    ) -> Self {
        let (joints, ends, real_ends) = (JointLanes::default(), PoseLanes::default(), PoseLanes::default());
        Self { machine, kinematics, interpolation, joints, ends, real, real_ends }
    }

    /// Computes the poses at the ends of these motions.
    pub(super) fn prepare(&mut self, motions: &[Motion]) {
        let machine = self.machine;
        self.joints.fill(motions.iter().map(|motion| {
            // A motion without a known end keeps its lane; nobody looks at it.
            let words = motion.end.unwrap_or(AxisWords { linear_mm: [0.0; 3], rotary_deg: [0.0; 2] });
            (words.linear_mm, rotary_rad(machine, words.rotary_deg))
        }));
        self.kinematics.forward_lanes(&self.joints, &mut self.ends);
        if let Some(real) = self.real {
            real.forward_lanes(&self.joints, &mut self.real_ends);
        }
    }

    /// The mode of a motion: the parameter wins over the program's own switches.
    pub(super) fn mode(&self, motion: &Motion) -> Interpolation {
        self.interpolation.unwrap_or(motion.interpolation)
    }

    /// The pose at the end of the motion of this index.
    pub(super) fn pose(&self, motion: &Motion, index: usize, words: &AxisWords) -> ToolPose {
        lane(&self.ends, self.mode(motion), index, words)
    }

    /// The pose that the machine as it is takes for the words of the source.
    pub(super) fn real_pose(&self, motion: &Motion, index: usize, words: &AxisWords) -> ToolPose {
        let lanes = if self.real.is_some() { &self.real_ends } else { &self.ends };
        lane(lanes, self.mode(motion), index, words)
    }

    /// The tip at these words in this mode \[mm\].
    pub(super) fn tip_mm(&self, mode: Interpolation, words: AxisWords) -> Vec3 {
        Station::new(self.machine, self.kinematics, mode, words).pose.tip_mm
    }

    /// Where the next motion at feed leads from the end of the motion of this index \[mm\]; rests are passed over.
    /// `following` is the first motion behind the batch.
    pub(super) fn beyond_mm(
        &self,
        motions: &[Motion],
        index: usize,
        following: Option<&Motion>,
    ) -> Option<Vec3> {
        let motion = motions.get(index)?;
        let mode = self.mode(motion);
        let later = motions.get(index + 1..).unwrap_or_default().iter().chain(following);
        let next = later.into_iter().find(|next| !rests(next))?;
        let goes_on = is_cutting(next) && next.start == motion.end && self.mode(next) == mode;
        next.end.filter(|_| goes_on).map(|words| self.tip_mm(mode, words))
    }
}

/// One pose; with TCP the linear words are the tip themselves.
fn lane(lanes: &PoseLanes, mode: Interpolation, index: usize, words: &AxisWords) -> ToolPose {
    let tip_mm = match mode {
        Interpolation::Machine => Vec3::new(lanes.x_mm[index], lanes.y_mm[index], lanes.z_mm[index]),
        Interpolation::Tcp => Vec3::from(words.linear_mm),
    };
    ToolPose { tip_mm, axis: Vec3::new(lanes.i[index], lanes.j[index], lanes.k[index]) }
}

/// Whether a straight motion goes nowhere.
pub(super) fn rests(motion: &Motion) -> bool {
    matches!(motion.kind, MotionKind::Linear | MotionKind::Rapid)
        && motion.start.is_some()
        && motion.start == motion.end
}

/// A straight motion at feed whose ends are known.
fn is_cutting(motion: &Motion) -> bool {
    motion.kind == MotionKind::Linear
        && motion.end.is_some()
        && motion.unfollowable.is_none()
        && !motion.offset_changed
}
