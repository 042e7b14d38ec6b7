//! Converts chosen words to joints, and collects the warnings of a path.

use std::ops::Range;

use super::aligned::Aligned;
use super::lanes::{BLOCK, Joined, JointBlock, Lane, LinearChain, Targets, join};
use super::pose_source::{PoseBlock, PoseSource};
use super::walk::{HELD, LIMIT, Stop, Walk};
use super::{InstructionSet, InverseError, Kinematics, PathWarning, WarningKind};

/// Chosen words of a block that become joints, and the words before them.
pub(super) struct Joiner {
    /// Chosen words of u, v \[deg\].
    pub(super) words_deg: Box<Aligned<[Lane; 2]>>,
    /// Words of u, v of the latest pose joined \[deg\].
    previous: Option<[f64; 2]>,
    /// `None` if poses are joined one by one.
    lanes: Option<JoinLanes>,
}

/// Memory to join a block in lanes.
pub(super) struct JoinLanes {
    chain: LinearChain,
    swapped: bool,
    block: Box<JointBlock>,
    copy: Box<PoseBlock>,
    /// For a block at the end that is not full.
    spare: Box<Aligned<[Lane; 5]>>,
}

impl JoinLanes {
    pub(super) fn new(kinematics: &Kinematics) -> Self {
        Self {
            chain: kinematics.linear_chain(),
            swapped: kinematics.profile_index[0] == 1,
            block: Box::new(JointBlock::new()),
            copy: Box::new(PoseBlock::new()),
            spare: Box::new(Aligned([[0.0; BLOCK]; 5])),
        }
    }

    /// X Y Z \[mm\] of a block of chosen words.
    pub(super) fn linear_mm(&mut self, set: InstructionSet, targets: Targets<'_>) -> [&Lane; 3] {
        let Self { chain, swapped, block, spare, .. } = self;
        join(set, chain, targets, block, Joined::new(spare.each_mut(), *swapped));
        let [x, y, z, ..] = &***spare;
        [x, y, z]
    }
}

impl<P: PoseSource + ?Sized, S: Stop + ?Sized> Walk<'_, P, S> {
    pub(super) fn joiner(&self) -> Joiner {
        Joiner {
            words_deg: Box::new(Aligned([[0.0; BLOCK]; 2])),
            previous: self.start,
            lanes: (!self.singly).then(|| JoinLanes::new(self.kinematics)),
        }
    }

    /// Converts chosen words to joints, block by block, and collects the warnings. `words_of` writes the words of u, v
    /// \[deg\] of a block; it still finds both branches' words of this block and of all later ones. It returns true if
    /// it knows that no step of the block is a rewind.
    pub(super) fn join_all(
        &mut self,
        mut words_of: impl FnMut(&Self, Range<usize>, &mut [Lane; 2]) -> bool,
    ) -> Result<(), InverseError> {
        let mut joiner = self.joiner();
        let count = self.poses.count();
        for begin in (0..count).step_by(BLOCK) {
            self.go_on()?;
            let block = begin..count.min(begin + BLOCK);
            let small = words_of(self, block.clone(), &mut joiner.words_deg);
            self.join(&mut joiner, block, small);
        }
        Ok(())
    }

    /// Converts the words in the joiner's block to joints, and collects the warnings. `small`: no step is a rewind.
    pub(super) fn join(&mut self, joiner: &mut Joiner, block: Range<usize>, small: bool) {
        let (begin, size) = (block.start, block.len());
        let [u, v] = &**joiner.words_deg;
        let entered = joiner.previous.unwrap_or([u[0], v[0]]);
        let marked =
            self.marks[self.places(&block)].iter().fold(0, |all, mark| all | mark) & (HELD | LIMIT) != 0;
        let threshold_deg = self.options.rewind_deg;
        let wide = !small
            && (has_step_over(threshold_deg, entered[0], &u[..size])
                || has_step_over(threshold_deg, entered[1], &v[..size]));
        self.join_block(joiner, begin, size);
        if !marked && !wide {
            return;
        }
        let mut previous = Some(entered);
        for lane in 0..size {
            let words = joiner.words_deg.each_ref().map(|words| words[lane]);
            self.warn_of_step(begin + lane, previous, words);
            previous = Some(words);
        }
    }

    /// Like [`Walk::join_block`]. False if an axis among X Y Z would leave its travel; then the joints mean nothing, and
    /// the joiner is as before.
    pub(super) fn join_within(&mut self, joiner: &mut Joiner, begin: usize, size: usize) -> bool {
        let previous = joiner.previous;
        self.join_block(joiner, begin, size);
        if !self.kinematics.is_linear_limited() {
            return true;
        }
        let places = self.places(&(begin..begin + size));
        let [x, y, z, ..] = self.out.joints.each_mut().map(|lane| &lane[places.clone()]);
        let within = |lane: usize| u8::from(self.kinematics.is_linear_within([x[lane], y[lane], z[lane]]));
        let are_within = (0..size).fold(1, |all, lane| all & within(lane)) == 1;
        if !are_within {
            joiner.previous = previous;
        }
        are_within
    }

    /// Converts the words in the joiner's block to joints, without a look at warnings.
    pub(super) fn join_block(&mut self, joiner: &mut Joiner, begin: usize, size: usize) {
        let Joiner { words_deg, previous, lanes } = joiner;
        *previous = Some(words_deg.each_ref().map(|words| words[size - 1]));
        let Some(JoinLanes { chain, swapped, block, copy, spare }) = lanes else {
            self.join_singly(words_deg, begin, size);
            return;
        };
        let targets = Targets { words_deg, tip_mm: self.poses.tips(begin, copy) };
        let (set, place) = (self.options.instructions, self.place(begin));
        if let Some(here) = self.out.joints.block_mut(place) {
            join(set, chain, targets, block, Joined::new(here, *swapped));
            return;
        }
        join(set, chain, targets, block, Joined::new(spare.each_mut(), *swapped));
        for (lane, joined) in self.out.joints.each_mut().into_iter().zip(spare.iter()) {
            lane[place..place + size].copy_from_slice(&joined[..size]);
        }
    }

    fn join_singly(&mut self, words_deg: &[Lane; 2], begin: usize, size: usize) {
        for lane in 0..size {
            let words = words_deg.each_ref().map(|words| words[lane]);
            let joined = self.kinematics.joints_at(self.poses.pose(begin + lane).tip_mm, words);
            let place = self.place(begin + lane);
            let [x, y, z, first, second] = self.out.joints.each_mut().map(|joints| &mut joints[place]);
            [*x, *y, *z] = joined.linear_mm.into();
            [*first, *second] = joined.rotary_rad;
        }
    }

    /// Warns of a pose that is reached by a rewind, or that is marked.
    fn warn_of_step(&mut self, index: usize, previous: Option<[f64; 2]>, words: [f64; 2]) {
        let step = previous.map_or(0.0, |p| {
            let (du, dv) = ((words[0] - p[0]).abs(), (words[1] - p[1]).abs());
            if du > dv { du } else { dv }
        });
        if step > self.options.rewind_deg || self.mark(index) & (HELD | LIMIT) != 0 {
            self.warn(index, step, words);
        }
    }

    fn warn(&mut self, index: usize, step_deg: f64, words_deg: [f64; 2]) {
        let mark = self.mark(index);
        let mut residual_rad = 0.0;
        if mark & (HELD | LIMIT) != 0 {
            let pose = self.poses.pose(index);
            let axis = super::inverse::usable_axis(&pose).unwrap_or(pose.axis);
            let (conditioning, residual) = self.kinematics.held_quality(axis, words_deg);
            residual_rad = residual;
            if mark & HELD != 0 {
                let place = self.place(index);
                self.out.conditioning[place] = conditioning;
            }
        }
        let mut warn = |kind, axis_residual_rad| {
            self.out.warnings.push(PathWarning { pose: index, kind, axis_residual_rad });
        };
        if step_deg > self.options.rewind_deg {
            warn(WarningKind::Rewind, residual_rad);
        }
        if mark & HELD != 0 {
            warn(WarningKind::PoleHold, residual_rad);
        }
        if mark & LIMIT != 0 {
            warn(WarningKind::ReachLimit, residual_rad);
        }
    }
}

/// Whether a step between neighbours is above the threshold. The loop has no branch.
pub(super) fn has_step_over(threshold_deg: f64, entered_deg: f64, words_deg: &[f64]) -> bool {
    let over = |from: f64, to: f64| u8::from((to - from).abs() > threshold_deg);
    let first = words_deg.first().map_or(0, |word| over(entered_deg, *word));
    let before = words_deg.iter();
    before.zip(words_deg.get(1..).unwrap_or_default()).fold(first, |any, (from, to)| any | over(*from, *to))
        != 0
}
