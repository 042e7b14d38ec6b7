//! Computes what a stretch needs before it is judged, many motions at a time. Meanwhile the stretch before is judged.

use super::parameters::CcParameters;
use crate::contact::rotary_rad;
use crate::geometry::Vec3;
use crate::kinematics::{JointLanes, PoseLanes};
use crate::machine::Machine;
use crate::motion::{AxisWords, Interpolation, Motion};
use crate::process::pipeline::Prepare;
use crate::process::set_up::{SetUps, ToolVectors};
use crate::process::text::{Inventory, MotionPoses, Passage, Stretch};

/// Prepares stretch after stretch, in the order of the program.
pub(in crate::process) struct Preparation<'a> {
    machine: &'a Machine,
    set_ups: SetUps,
    /// The interpolation mode that the parameter prescribes, if any.
    interpolation: Option<Interpolation>,
    vectors: ToolVectors,
    joints: JointLanes,
    poses: PoseLanes,
    /// The inventory of everything prepared so far.
    inventory: Inventory,
}

impl Prepare for Preparation<'_> {
    /// Resolves the words of motions that state vectors, computes the poses, and counts the content of the stretch.
    fn prepare(&mut self, stretch: &mut Stretch) {
        stretch.resolve(&mut self.vectors);
        for passage in &mut stretch.passages {
            self.inventory.see(&passage.batch);
            self.work_out(passage);
        }
    }

    fn resolves_vectors(&self) -> bool {
        true
    }

    fn inventory(&self) -> &Inventory {
        &self.inventory
    }
}

impl<'a> Preparation<'a> {
    pub(in crate::process) fn new(machine: &'a Machine, parameters: &CcParameters) -> Self {
        Self {
            machine,
            set_ups: SetUps::new(machine, &parameters.program),
            interpolation: parameters.program.interpolation,
            vectors: ToolVectors::new(machine, &parameters.program),
            joints: JointLanes::default(),
            poses: PoseLanes::default(),
            inventory: Inventory::default(),
        }
    }

    fn work_out(&mut self, Passage { motions, poses, .. }: &mut Passage) {
        poses.clear();
        let mut rest = motions.as_slice();
        while let Some(first) = rest.first() {
            self.set_ups.enter(first);
            let alike = rest.iter().take_while(|motion| self.set_ups.is_entered(motion)).count();
            let (now, later) = rest.split_at(alike);
            self.work_out_alike(now, poses);
            rest = later;
        }
    }

    /// Computes the poses of motions that all have the set-up entered last.
    fn work_out_alike(&mut self, motions: &[Motion], poses: &mut Vec<MotionPoses>) {
        let (machine, count) = (self.machine, motions.len());
        let joints = |words: Option<AxisWords>| {
            let words = words.unwrap_or(AxisWords { linear_mm: [0.0; 3], rotary_deg: [0.0; 2] });
            (words.linear_mm, rotary_rad(machine, words.rotary_deg))
        };
        // The lanes hold all ends first, then all middles.
        self.joints.fill((0..2 * count).map(|lane| {
            joints(if lane < count { motions[lane].end } else { half_way(&motions[lane - count]) })
        }));
        self.set_ups.now.kinematics.forward_lanes(&self.joints, &mut self.poses);
        poses.extend(motions.iter().enumerate().map(|(index, motion)| {
            let mut found =
                MotionPoses { end: self.poses.pose(index), middle: self.poses.pose(count + index) };
            // With TCP the linear words are the tip itself.
            if motion.mode(self.interpolation) == Interpolation::Tcp {
                let tip_mm = |words: Option<AxisWords>| words.map(|words| Vec3::from(words.linear_mm));
                found.end.tip_mm = tip_mm(motion.end).unwrap_or(found.end.tip_mm);
                found.middle.tip_mm = tip_mm(half_way(motion)).unwrap_or(found.middle.tip_mm);
            }
            found
        }));
    }
}

/// The words half way along a motion whose ends are known.
fn half_way(motion: &Motion) -> Option<AxisWords> {
    let (a, b) = (motion.start.as_ref()?, motion.end.as_ref()?);
    Some(AxisWords {
        linear_mm: std::array::from_fn(|k| 0.5 * (a.linear_mm[k] + b.linear_mm[k])),
        rotary_deg: std::array::from_fn(|k| 0.5 * (a.rotary_deg[k] + b.rotary_deg[k])),
    })
}
