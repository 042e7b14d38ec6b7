//! Computes the poses at the ends of a batch's motions, many at a time: as meant, and as the machine would take them.

use crate::contact::{Station, rotary_rad};
use crate::geometry::Vec3;
use crate::kinematics::{JointLanes, PoseLanes, ToolPose};
use crate::machine::Machine;
use crate::motion::{AxisWords, Interpolation, Motion, MotionKind};
use crate::process::set_up::SetUps;

/// The source's poses at the ends of a batch's motions.
pub(super) struct EndPoses<'a> {
    machine: &'a Machine,
    /// The machine for which the program was made.
    pub(super) source: SetUps,
    /// The interpolation mode that the parameter prescribes, if any.
    interpolation: Option<Interpolation>,
    joints: JointLanes,
    ends: PoseLanes,
    /// The machine as it is, if the program was made for another one.
    real: Option<SetUps>,
    real_ends: PoseLanes,
    lanes: PoseLanes,
}

impl<'a> EndPoses<'a> {
    pub(super) fn new(
        machine: &'a Machine,
        source: SetUps,
        interpolation: Option<Interpolation>,
        real: Option<SetUps>,
    ) -> Self {
        let (joints, ends, real_ends) = (JointLanes::default(), PoseLanes::default(), PoseLanes::default());
        Self { machine, source, interpolation, joints, ends, real, real_ends, lanes: PoseLanes::default() }
    }

    /// Computes the poses at the ends of these motions.
    pub(super) fn prepare(&mut self, motions: &[Motion]) {
        self.ends.clear();
        self.real_ends.clear();
        let mut rest = motions;
        while let Some(first) = rest.first() {
            self.enter(first);
            let alike = rest.iter().take_while(|motion| self.source.is_entered(motion)).count();
            let (now, later) = rest.split_at(alike);
            self.prepare_alike(now);
            rest = later;
        }
    }

    /// Switches to the set-up of a motion.
    pub(super) fn enter(&mut self, motion: &Motion) {
        self.source.enter(motion);
        if let Some(real) = &mut self.real {
            real.enter(motion);
        }
    }

    /// Computes the poses of motions that all have the set-up entered last.
    fn prepare_alike(&mut self, motions: &[Motion]) {
        let machine = self.machine;
        self.joints.fill(motions.iter().map(|motion| {
            // A motion without a known end also has a lane, but nobody reads it.
            let words = motion.end.unwrap_or(AxisWords { linear_mm: [0.0; 3], rotary_deg: [0.0; 2] });
            (words.linear_mm, rotary_rad(machine, words.rotary_deg))
        }));
        self.source.now.kinematics.forward_lanes(&self.joints, &mut self.lanes);
        self.ends.extend(&self.lanes);
        if let Some(real) = &self.real {
            real.now.kinematics.forward_lanes(&self.joints, &mut self.lanes);
            self.real_ends.extend(&self.lanes);
        }
    }

    /// The mode of a motion. The parameter overrides the program's own switches.
    pub(super) fn mode(&self, motion: &Motion) -> Interpolation {
        motion.mode(self.interpolation)
    }

    /// The pose at the end of the motion of this index.
    pub(super) fn pose(&self, motion: &Motion, index: usize, words: &AxisWords) -> ToolPose {
        lane(&self.ends, self.mode(motion), index, words)
    }

    /// The pose that the machine as it is takes for the source's words.
    pub(super) fn real_pose(&self, motion: &Motion, index: usize, words: &AxisWords) -> ToolPose {
        let lanes = if self.real.is_some() { &self.real_ends } else { &self.ends };
        lane(lanes, self.mode(motion), index, words)
    }

    /// The source's station at these words in this mode.
    pub(super) fn station(&self, mode: Interpolation, words: AxisWords) -> Station {
        Station::new(self.machine, &self.source.now.kinematics, mode, words)
    }

    /// The source's pose at these words, in the mode and the set-up of a motion.
    pub(super) fn pose_at(&self, motion: &Motion, words: AxisWords) -> ToolPose {
        self.station(self.mode(motion), words).pose
    }

    /// The tip at these words in this mode \[mm\].
    pub(super) fn tip_mm(&self, mode: Interpolation, words: AxisWords) -> Vec3 {
        self.station(mode, words).pose.tip_mm
    }

    /// The motion at feed that continues from the end of the motion of this index, if there is one. Motions that go
    /// nowhere are skipped. `following` is the first motion after the batch.
    pub(super) fn goes_on<'m>(
        &self,
        motions: &'m [Motion],
        index: usize,
        following: Option<&'m Motion>,
    ) -> Option<&'m Motion> {
        let motion = motions.get(index)?;
        let later = motions.get(index + 1..).unwrap_or_default().iter().chain(following);
        let next = later.into_iter().find(|next| !rests(next))?;
        let goes_on = is_cutting(next)
            && next.start == motion.end
            && self.mode(next) == self.mode(motion)
            && self.source.is_entered(next);
        goes_on.then_some(next)
    }
}

/// One pose. With TCP the linear words are the tip itself.
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

/// Whether this is a straight motion at feed whose end is known.
fn is_cutting(motion: &Motion) -> bool {
    motion.kind == MotionKind::Linear
        && motion.end.is_some()
        && motion.unfollowable.is_none()
        && !motion.offset_changed
}
