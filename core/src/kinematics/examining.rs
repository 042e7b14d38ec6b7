//! The directions of all poses of a path: in lanes, and one by one near the pole or the reach limit.
//!
//! Inside the pole cone u keeps the word with which the cone was entered. A path that begins there waits for the words
//! of the first pose outside.

use super::aligned::Aligned;
use super::joining::JoinLanes;
use super::lanes::{BLOCK, Lane, PointedBlock, Targets, both_words, point};
use super::pointing::principal_deg;
use super::pose_source::{PoseBlock, PoseSource};
use super::walk::{ALIVE, HELD, LIMIT, PLAIN, Stop, Walk, branch_words, branch_words_mut};
use super::{InverseError, Kinematics, REACH_SLACK_RAD, ToolPose};
use crate::geometry::trig;

/// From this many numbers on, the system gives memory of zeros, page by page as it is used. For fewer numbers, the memory
/// that the allocator has at hand is faster.
const ZEROED_BY_THE_SYSTEM: usize = 512;

/// The directions found so far.
pub(super) struct Examination {
    pub(super) cone_rad: f64,
    cone_sin2: f64,
    /// Memory for a block. `None` if poses are solved one by one.
    pub(super) lanes: Option<ExaminedLanes>,
    /// Principal words of u of the latest pose, per branch, for held poses. Before there are any, held poses wait.
    pub(super) held_u: Option<[f64; 2]>,
    /// The first pose that is known not to wait, or the next to look at.
    waiting: usize,
    /// Both branches' words of the pose before the next block.
    pub(super) before: [f64; 4],
}

impl Examination {
    /// Whether poses wait for the words of a later one.
    pub(super) fn is_waiting(&self) -> bool {
        self.held_u.is_none()
    }

    /// The state before the first pose, once it is known with which words of u \[deg\] the path begins.
    pub(super) fn begin_again(&mut self, begins_with: Option<[f64; 2]>) {
        self.held_u = begins_with;
        self.before = [0.0; 4];
    }
}

/// Memory for the directions of a block.
pub(super) struct ExaminedLanes {
    pub(super) copy: Box<PoseBlock>,
    pub(super) pointed: Box<PointedBlock>,
    /// For a block at the end that is not full.
    words_deg: Box<Aligned<[Lane; 4]>>,
    /// To compare X Y Z of both solutions with their travels, if they have any.
    tried: Option<Tried>,
    /// Whether a pose of the block has no margin.
    pub(super) care: bool,
}

/// Words of one solution in a block, and the joints to which they lead.
struct Tried {
    /// Words of u, v \[deg\].
    words_deg: Box<Aligned<[Lane; 2]>>,
    lanes: JoinLanes,
}

impl ExaminedLanes {
    fn new(kinematics: &Kinematics) -> Self {
        let tried =
            || Tried { words_deg: Box::new(Aligned([[0.0; BLOCK]; 2])), lanes: JoinLanes::new(kinematics) };
        Self {
            copy: Box::new(PoseBlock::new()),
            pointed: Box::new(PointedBlock::new()),
            words_deg: Box::new(Aligned([[0.0; BLOCK]; 4])),
            tried: kinematics.is_linear_limited().then(tried),
            care: true,
        }
    }
}

impl<P: PoseSource + ?Sized, S: Stop + ?Sized> Walk<'_, P, S> {
    /// Memory for `count` poses, and the state before the first.
    pub(super) fn begin(&mut self, count: usize) -> Examination {
        for lane in self.out.joints.each_mut().into_iter().chain([&mut self.out.conditioning]) {
            if lane.capacity() < count && count >= ZEROED_BY_THE_SYSTEM {
                *lane = vec![0.0; count];
            }
            lane.resize(count, 0.0);
        }
        self.out.warnings.clear();
        self.marks.clear();
        self.marks.resize(count, PLAIN);
        let cone_rad = self.kinematics.pole_cone_rad();
        Examination {
            cone_rad,
            cone_sin2: trig::sin_cos(1.001 * cone_rad).0.powi(2),
            lanes: (!self.singly).then(|| ExaminedLanes::new(self.kinematics)),
            held_u: self.start.map(|words| [principal_deg(words[0]); 2]),
            waiting: 0,
            before: [0.0; 4],
        }
    }

    /// Solves all directions.
    pub(super) fn examine_all(&mut self) -> Result<(), InverseError> {
        let mut examination = self.begin(self.poses.count());
        self.examine_from(0, &mut examination)
    }

    /// Solves the directions from this block on.
    pub(super) fn examine_from(
        &mut self,
        begin: usize,
        examination: &mut Examination,
    ) -> Result<(), InverseError> {
        for begin in (begin..self.poses.count()).step_by(BLOCK) {
            self.go_on()?;
            self.point(begin, examination);
            self.examine(begin, examination)?;
        }
        Ok(())
    }

    /// Solves the directions of a block that was pointed. Poses near the pole or the reach limit are solved one by one.
    pub(super) fn examine(
        &mut self,
        begin: usize,
        examination: &mut Examination,
    ) -> Result<(), InverseError> {
        let count = self.poses.count();
        let end = count.min(begin + BLOCK);
        let entered_u = [examination.before[0], examination.before[2]];
        let cone_rad = examination.cone_rad;
        let lanes = &mut examination.lanes;
        let care = lanes.as_mut().is_none_or(|lanes| {
            self.keep_words(begin, lanes);
            self.try_both(begin, lanes);
            lanes.care
        });
        for pose in begin..if care { end } else { begin } {
            if lanes.as_ref().is_some_and(|lanes| lanes.pointed.margin[pose - begin] > 0.0) {
                continue;
            }
            if self.examine_one(pose, cone_rad)? {
                // Inside the cone.
                let entry = if pose == begin { entered_u } else { self.u_words(pose - 1) };
                if let Some(begins_with) = examination.held_u {
                    let u_deg = if pose == 0 { begins_with } else { entry };
                    examination.held_u = Some(u_deg);
                    self.hold(pose, u_deg)?;
                }
            }
        }
        self.hold_waiting(end, examination)?;
        examination.before = self.both(end - 1);
        Ok(())
    }

    /// Poses before the first one outside the cone take its words.
    fn hold_waiting(&mut self, end: usize, examination: &mut Examination) -> Result<(), InverseError> {
        if examination.held_u.is_some() {
            return Ok(());
        }
        let count = self.poses.count();
        let mut waiting = examination.waiting;
        while waiting < end && self.mark(waiting) & HELD != 0 {
            waiting += 1;
        }
        examination.waiting = waiting;
        if waiting == end && end < count {
            return Ok(());
        }
        let words = if waiting < count { self.u_words(waiting) } else { [0.0; 2] };
        examination.held_u = Some(words);
        for pose in 0..waiting {
            self.hold(pose, words)?;
        }
        for pose in waiting..end {
            if self.mark(pose) & HELD != 0 {
                self.hold(pose, if pose == 0 { words } else { self.u_words(pose - 1) })?;
            }
        }
        Ok(())
    }

    /// Points the block in lanes, if there are lanes.
    pub(super) fn point(&self, begin: usize, examination: &mut Examination) {
        let cone_sin2 = examination.cone_sin2;
        let Some(lanes) = &mut examination.lanes else { return };
        let poses = self.poses.block(begin, &mut lanes.copy);
        let size = poses.count;
        point(self.options.instructions, &self.kinematics.pointing, cone_sin2, poses, &mut lanes.pointed);
        // Without a branch in the loop.
        let sound = lanes.pointed.margin[..size].iter().fold(1, |all, margin| all & u8::from(*margin > 0.0));
        lanes.care = sound == 0;
    }

    /// Keeps the words of both branches of a block.
    fn keep_words(&mut self, begin: usize, lanes: &mut ExaminedLanes) {
        let end = self.poses.count().min(begin + BLOCK);
        let ExaminedLanes { pointed, words_deg, .. } = lanes;
        let places = self.places(&(begin..end));
        self.out.conditioning[places.clone()].copy_from_slice(&pointed.conditioning[..end - begin]);
        let (set, pointing) = (self.options.instructions, &self.kinematics.pointing);
        if let Some([first_u, first_v, second_u, second_v, _]) = self.out.joints.block_mut(places.start) {
            both_words(set, pointing, pointed, [first_u, first_v, second_u, second_v]);
            return;
        }
        both_words(set, pointing, pointed, words_deg.each_mut());
        for (kept, found) in branch_words_mut(&mut self.out.joints).into_iter().zip(words_deg.iter()) {
            kept[places.clone()].copy_from_slice(&found[..end - begin]);
        }
    }

    /// Marks which solutions of a block keep X Y Z within travel, if there is a travel.
    fn try_both(&mut self, begin: usize, lanes: &mut ExaminedLanes) {
        let ExaminedLanes { copy, tried: Some(Tried { words_deg, lanes }), .. } = lanes else { return };
        let end = self.poses.count().min(begin + BLOCK);
        let tip_mm = self.poses.tips(begin, copy);
        let places = self.places(&(begin..end));
        let marks = &mut self.marks[places.clone()];
        marks.fill(0);
        for (branch, words) in branch_words(&self.out.joints).chunks_exact(2).enumerate() {
            for (lane, kept) in words_deg.iter_mut().zip(words) {
                lane[..end - begin].copy_from_slice(&kept[places.clone()]);
            }
            let targets = Targets { words_deg, tip_mm };
            let linear_mm = lanes.linear_mm(self.options.instructions, targets);
            for (lane, mark) in marks.iter_mut().enumerate() {
                let is_within = self.kinematics.is_linear_within(linear_mm.map(|axis| axis[lane]));
                *mark |= ALIVE[branch] * u8::from(is_within);
            }
        }
    }

    fn u_words(&self, pose: usize) -> [f64; 2] {
        let [first_u_deg, _, second_u_deg, _] = branch_words(&self.out.joints);
        let place = self.place(pose);
        [first_u_deg[place], second_u_deg[place]]
    }

    /// Examines one pose; true if it is inside the pole cone.
    fn examine_one(&mut self, index: usize, cone_rad: f64) -> Result<bool, InverseError> {
        let kinematics = self.kinematics;
        let pose = self.poses.pose(index);
        let solution = kinematics.solution(index, &pose)?;
        let held = solution.polar_distance_rad <= cone_rad;
        let place = self.place(index);
        if held {
            self.marks[place] = HELD;
            return Ok(true);
        }
        let words = solution.words_deg;
        self.set_words(index, words);
        self.out.conditioning[place] = solution.conditioning;
        let mut mark = if solution.axis_residual_rad > REACH_SLACK_RAD { LIMIT } else { 0 };
        for branch in 0..solution.branches {
            if self.linear_fits(index, &pose, words[branch]) {
                mark |= ALIVE[branch];
            }
        }
        self.marks[place] = mark;
        Ok(false)
    }

    fn set_words(&mut self, index: usize, words: [[f64; 2]; 2]) {
        let place = self.place(index);
        for (kept, word) in branch_words_mut(&mut self.out.joints).into_iter().zip(words.as_flattened()) {
            kept[place] = *word;
        }
    }

    fn linear_fits(&self, index: usize, pose: &ToolPose, words_deg: [f64; 2]) -> bool {
        let linear_mm = self.kinematics.joints_at(pose.tip_mm, words_deg).linear_mm;
        self.kinematics.linear_miss(index, linear_mm).is_none()
    }

    /// Holds u at these words, one for each branch by which the cone was entered. v gets its best fit.
    fn hold(&mut self, index: usize, u_deg: [f64; 2]) -> Result<(), InverseError> {
        let pose = self.poses.pose(index);
        let axis = super::inverse::usable_axis(&pose).ok_or(InverseError::NoDirection { pose: index })?;
        let words = u_deg.map(|u| [u, self.kinematics.held_word_deg(axis, u)]);
        self.set_words(index, words);
        let mut mark = HELD;
        for branch in 0..2 {
            if self.linear_fits(index, &pose, words[branch]) {
                mark |= ALIVE[branch];
            }
        }
        let place = self.place(index);
        self.marks[place] = mark;
        Ok(())
    }
}
