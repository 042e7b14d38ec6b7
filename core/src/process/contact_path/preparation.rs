//! Computes what a stretch needs before it is judged, many motions at a time. Meanwhile the stretch before is judged.

use super::parameters::CcParameters;
use crate::contact::{TipLook, TipPaths, look_at_tips, rotary_rad};
use crate::geometry::Vec3;
use crate::kinematics::{JointLanes, PoseLanes};
use crate::machine::Machine;
use crate::motion::{AxisWords, ContactWords, Interpolation, Motion, MotionKind};
use crate::process::pipeline::Prepare;
use crate::process::set_up::{ContactSource, SetUps, ToolVectors, Travels};
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
    /// Whether every contact is the tip. Motions are then looked at here, many at a time.
    looks_at_tips: bool,
    rotary_deg: [Vec<f64>; 2],
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
    pub(in crate::process) fn new(
        machine: &'a Machine,
        parameters: &CcParameters,
        contact: ContactSource,
    ) -> Self {
        Self {
            machine,
            set_ups: SetUps::new(machine, &parameters.program),
            interpolation: parameters.program.interpolation,
            vectors: ToolVectors::new(machine, &parameters.program),
            joints: JointLanes::default(),
            poses: PoseLanes::default(),
            looks_at_tips: contact == ContactSource::Tip,
            rotary_deg: Default::default(),
            inventory: Inventory::default(),
        }
    }

    fn work_out(&mut self, Passage { motions, poses, looks, .. }: &mut Passage) {
        poses.clear();
        looks.clear();
        let mut rest = motions.as_slice();
        while let Some(first) = rest.first() {
            self.set_ups.enter(first);
            let alike = rest.iter().take_while(|motion| self.set_ups.is_entered(motion)).count();
            let (now, later) = rest.split_at(alike);
            self.work_out_alike(now, poses);
            if self.looks_at_tips {
                self.look(now, looks);
            }
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

impl Preparation<'_> {
    /// Looks at motions that all have the set-up entered last, and whose poses were computed last. Motions that need
    /// more than a look get none.
    fn look(&mut self, motions: &[Motion], looks: &mut Vec<TipLook>) {
        let before = looks.len();
        if let Some(mode) = self.lookable_mode(motions) {
            let Self { joints, poses, rotary_deg, set_ups, .. } = self;
            let count = motions.len();
            for (k, lane) in rotary_deg.iter_mut().enumerate() {
                lane.clear();
                lane.extend(motions.iter().map(|motion| motion.end.map_or(0.0, |end| end.rotary_deg[k])));
            }
            let linear_mm = [&joints.x_mm, &joints.y_mm, &joints.z_mm];
            // With TCP the linear words are the tip itself.
            let tips_mm = match mode {
                Interpolation::Machine => [&poses.x_mm, &poses.y_mm, &poses.z_mm],
                Interpolation::Tcp => linear_mm,
            };
            let paths = TipPaths {
                linear_mm: linear_mm.map(|lane| &lane[..count]),
                rotary_deg: rotary_deg.each_ref().map(Vec::as_slice),
                tip_mm: tips_mm.map(|lane| &lane[..count]),
                middle_mm: tips_mm.map(|lane| &lane[count..]),
            };
            look_at_tips(&set_ups.now.kinematics, mode, &paths, looks);
            for (look, pair) in looks[before..].iter_mut().skip(1).zip(motions.windows(2)) {
                if !goes_on_plainly(&pair[0], &pair[1]) {
                    *look = TipLook::NONE;
                }
            }
        }
        looks.resize(before + motions.len(), TipLook::NONE);
    }

    /// The interpolation mode of these motions, if all have the same and nothing is missing or outside its travel.
    fn lookable_mode(&self, motions: &[Motion]) -> Option<Interpolation> {
        let now = &self.set_ups.now;
        let mode = motions.first()?.mode(self.interpolation);
        let has_one_mode = motions.iter().all(|motion| motion.mode(self.interpolation) == mode);
        let is_limited = self.machine.linear_travel_mm().iter().any(Option::is_some);
        let is_known = now.is_stated() || mode == Interpolation::Tcp;
        if !has_one_mode || now.is_foreign() || !is_known || mode == Interpolation::Tcp && is_limited {
            return None;
        }
        let (mut least, mut most) = ([f64::INFINITY; 5], [f64::NEG_INFINITY; 5]);
        for end in motions.iter().filter_map(|motion| motion.end.as_ref()) {
            for (k, word) in end.linear_mm.iter().chain(&end.rotary_deg).enumerate() {
                (least[k], most[k]) = (least[k].min(*word), most[k].max(*word));
            }
        }
        let mut is_outside = false;
        for [x, y, z, first, second] in [least, most] {
            let words = AxisWords { linear_mm: [x, y, z], rotary_deg: [first, second] };
            let checked = now.travel_check(self.machine).see(mode, &words, |_| is_outside = true);
            is_outside |= checked == Travels::NotChecked;
        }
        (!is_outside).then_some(mode)
    }
}

/// Whether a motion is a straight one between known ends that begins where the one before it ends, and has no contact
/// of its own.
fn goes_on_plainly(before: &Motion, motion: &Motion) -> bool {
    motion.kind == MotionKind::Linear
        && motion.contact == ContactWords::None
        && motion.unfollowable.is_none()
        && !motion.offset_changed
        && motion.start.is_some()
        && motion.end.is_some()
        && motion.start != motion.end
        && before.end == motion.start
}

/// The words half way along a motion whose ends are known.
fn half_way(motion: &Motion) -> Option<AxisWords> {
    let (a, b) = (motion.start.as_ref()?, motion.end.as_ref()?);
    Some(AxisWords {
        linear_mm: std::array::from_fn(|k| 0.5 * (a.linear_mm[k] + b.linear_mm[k])),
        rotary_deg: std::array::from_fn(|k| 0.5 * (a.rotary_deg[k] + b.rotary_deg[k])),
    })
}
