//! Converts chosen words to joints, and collects the warnings of a path.

use super::lanes::{BLOCK, JointBlock, PoseBlock, PoseSource, join};
use super::walk::{HELD, LIMIT, Walk, branch_words};
use super::{InverseError, PathWarning, WarningKind};

impl<P: PoseSource + ?Sized> Walk<'_, P> {
    /// Converts the chosen words to joints, block by block, and collects the warnings.
    pub(super) fn join(&mut self) -> Result<(), InverseError> {
        if self.singly {
            return self.join_singly();
        }
        let kinematics = self.kinematics;
        let chain = kinematics.linear_chain();
        let (mut block, mut joined) = (Box::new(PoseBlock::new()), Box::new(JointBlock::new()));
        let swapped = kinematics.profile_index[0] == 1;
        let mut previous = self.start;
        for begin in (0..self.poses.count()).step_by(BLOCK) {
            self.go_on()?;
            let (size, poses) = self.poses.block(begin, &mut block);
            let end = begin + size;
            for (words, chosen) in joined.words_deg.iter_mut().zip(branch_words(&self.out.joints)) {
                words[..size].copy_from_slice(&chosen[begin..end]);
            }
            join(self.options.instructions, &chain, poses.tip_mm, &mut joined);
            let (first, second) = if swapped { (1, 0) } else { (0, 1) };
            let joints = &mut self.out.joints;
            joints.x_mm[begin..end].copy_from_slice(&joined.linear_mm[0][..size]);
            joints.y_mm[begin..end].copy_from_slice(&joined.linear_mm[1][..size]);
            joints.z_mm[begin..end].copy_from_slice(&joined.linear_mm[2][..size]);
            joints.first_rad[begin..end].copy_from_slice(&joined.rotary_rad[first][..size]);
            joints.second_rad[begin..end].copy_from_slice(&joined.rotary_rad[second][..size]);
            let entered = previous.unwrap_or([joined.words_deg[0][0], joined.words_deg[1][0]]);
            previous = Some([joined.words_deg[0][size - 1], joined.words_deg[1][size - 1]]);
            let marked = self.marks[begin..end].iter().fold(0, |all, mark| all | mark) & (HELD | LIMIT) != 0;
            let wide = (0..2)
                .any(|k| has_step_over(self.options.rewind_deg, entered[k], &joined.words_deg[k][..size]));
            if !marked && !wide {
                continue;
            }
            let mut previous = Some(entered);
            for lane in 0..size {
                let words = [joined.words_deg[0][lane], joined.words_deg[1][lane]];
                self.warn_of_step(begin + lane, previous, words);
                previous = Some(words);
            }
        }
        Ok(())
    }

    fn join_singly(&mut self) -> Result<(), InverseError> {
        let mut previous = self.start;
        for index in 0..self.poses.count() {
            if index % BLOCK == 0 {
                self.go_on()?;
            }
            let [u_deg, v_deg, ..] = branch_words(&self.out.joints);
            let words = [u_deg[index], v_deg[index]];
            let joined = self.kinematics.joints_at(self.poses.pose(index).tip_mm, words);
            let joints = &mut self.out.joints;
            joints.x_mm[index] = joined.linear_mm.x;
            joints.y_mm[index] = joined.linear_mm.y;
            joints.z_mm[index] = joined.linear_mm.z;
            joints.first_rad[index] = joined.rotary_rad[0];
            joints.second_rad[index] = joined.rotary_rad[1];
            self.warn_of_step(index, previous, words);
            previous = Some(words);
        }
        Ok(())
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
fn has_step_over(threshold_deg: f64, entered_deg: f64, words_deg: &[f64]) -> bool {
    let over = |from: f64, to: f64| u8::from((to - from).abs() > threshold_deg);
    let first = words_deg.first().map_or(0, |word| over(entered_deg, *word));
    let before = words_deg.iter();
    before.zip(words_deg.get(1..).unwrap_or_default()).fold(first, |any, (from, to)| any | over(*from, *to))
        != 0
}
