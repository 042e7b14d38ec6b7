//! Converts chosen words to joints, and collects the warnings of a path.

use std::ops::Range;

use super::lanes::{BLOCK, Joined, JointBlock, Lane, LinearChain, PoseBlock, PoseSource, join};
use super::walk::{HELD, LIMIT, Walk};
use super::{InverseError, PathWarning, WarningKind};

/// Memory for the joints of a block, and the words before it.
pub(super) struct Joiner {
    chain: LinearChain,
    swapped: bool,
    pub(super) block: Box<JointBlock>,
    /// For a block at the end that is not full.
    spare: Box<[Lane; 5]>,
    /// Words of u, v of the latest pose joined \[deg\].
    previous: Option<[f64; 2]>,
}

impl<P: PoseSource + ?Sized> Walk<'_, P> {
    pub(super) fn joiner(&self) -> Joiner {
        let kinematics = self.kinematics;
        Joiner {
            chain: kinematics.linear_chain(),
            swapped: kinematics.profile_index[0] == 1,
            block: Box::new(JointBlock::new()),
            spare: Box::new([[0.0; BLOCK]; 5]),
            previous: self.start,
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
        let mut copy = Box::new(PoseBlock::new());
        let count = self.poses.count();
        for begin in (0..count).step_by(BLOCK) {
            self.go_on()?;
            let block = begin..count.min(begin + BLOCK);
            let small = words_of(self, block.clone(), &mut joiner.block.words_deg);
            self.join(&mut joiner, &mut copy, block, small);
        }
        Ok(())
    }

    /// Converts the words in the joiner's block to joints, and collects the warnings. `small`: no step is a rewind.
    pub(super) fn join(
        &mut self,
        joiner: &mut Joiner,
        copy: &mut PoseBlock,
        lanes: Range<usize>,
        small: bool,
    ) {
        let (begin, size) = (lanes.start, lanes.len());
        let [u, v] = &joiner.block.words_deg;
        let entered = joiner.previous.unwrap_or([u[0], v[0]]);
        if self.singly {
            self.join_singly(joiner, begin, size);
        } else {
            let marked = self.marks[lanes].iter().fold(0, |all, mark| all | mark) & (HELD | LIMIT) != 0;
            let wide = !small
                && (0..2).any(|k| {
                    let words = &joiner.block.words_deg[k][..size];
                    has_step_over(self.options.rewind_deg, entered[k], words)
                });
            let poses = self.poses.block(begin, copy).1;
            self.join_block(joiner, poses.tip_mm, begin, size);
            if !marked && !wide {
                return;
            }
        }
        let mut previous = Some(entered);
        for lane in 0..size {
            let words = joiner.block.words_deg.each_ref().map(|words| words[lane]);
            self.warn_of_step(begin + lane, previous, words);
            previous = Some(words);
        }
    }

    /// Converts the words in the joiner's block to joints, without a look at warnings.
    pub(super) fn join_block(&mut self, joiner: &mut Joiner, tip_mm: [&Lane; 3], begin: usize, size: usize) {
        let Joiner { chain, swapped, block, spare, previous } = joiner;
        *previous = Some(block.words_deg.each_ref().map(|words| words[size - 1]));
        let set = self.options.instructions;
        if let Some(here) = self.out.joints.block_mut(begin) {
            join(set, chain, tip_mm, block, Joined::new(here, *swapped));
            return;
        }
        join(set, chain, tip_mm, block, Joined::new(spare.each_mut(), *swapped));
        for (lane, joined) in self.out.joints.each_mut().into_iter().zip(spare.iter()) {
            lane[begin..begin + size].copy_from_slice(&joined[..size]);
        }
    }

    fn join_singly(&mut self, joiner: &mut Joiner, begin: usize, size: usize) {
        for lane in 0..size {
            let words = joiner.block.words_deg.each_ref().map(|words| words[lane]);
            let joined = self.kinematics.joints_at(self.poses.pose(begin + lane).tip_mm, words);
            let [x, y, z, first, second] = self.out.joints.each_mut().map(|joints| &mut joints[begin + lane]);
            [*x, *y, *z] = joined.linear_mm.into();
            [*first, *second] = joined.rotary_rad;
            joiner.previous = Some(words);
        }
    }

    /// Warns of a pose that is reached by a rewind, or that is marked.
    fn warn_of_step(&mut self, index: usize, previous: Option<[f64; 2]>, words: [f64; 2]) {
        let step = previous.map_or(0.0, |p| {
            let (du, dv) = ((words[0] - p[0]).abs(), (words[1] - p[1]).abs());
            if du > dv { du } else { dv }
        });
        if step > self.options.rewind_deg || self.marks[index] & (HELD | LIMIT) != 0 {
            self.warn(index, step, words);
        }
    }

    fn warn(&mut self, index: usize, step_deg: f64, words_deg: [f64; 2]) {
        let mark = self.marks[index];
        let mut residual_rad = 0.0;
        if mark & (HELD | LIMIT) != 0 {
            let pose = self.poses.pose(index);
            let axis = super::inverse::usable_axis(&pose).unwrap_or(pose.axis);
            let (conditioning, residual) = self.kinematics.held_quality(axis, words_deg);
            residual_rad = residual;
            if mark & HELD != 0 {
                self.out.conditioning[index] = conditioning;
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
