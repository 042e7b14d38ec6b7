//! Rotary words next to given ones, for posting a program again for a machine that is nearly the same.

use super::inverse::{REACH_SLACK_RAD, usable_axis};
use super::pointing::nearest_integer;
use super::{InverseError, Kinematics, ToolPose};
use crate::geometry::{Vec3, angle_between};

/// Rotary words that point the tool, and their error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearWords {
    /// NC words in the profile's order \[deg\].
    pub words_deg: [f64; 2],
    /// Angle between the tool axis and the one asked for \[rad\]; 0 except inside the pole cone and beyond reach.
    pub axis_residual_rad: f64,
    /// Inside the pole cone: the word of the axis next to the workpiece was held, not solved for.
    pub held: bool,
}

impl Kinematics {
    /// The rotary words that point the tool along `axis`, on the branch and in the turn of `near_deg` (profile
    /// order). Travels are not checked. Inside the pole cone ([`Kinematics::pole_cone_rad`]) the word of the axis
    /// next to the workpiece is that of `near_deg` plus `held_deg`, and the other axis gets its best fit.
    ///
    /// # Errors
    /// No direction, or direction out of reach; `pose` is 0.
    pub fn words_near(
        &self,
        axis: Vec3,
        near_deg: [f64; 2],
        held_deg: f64,
    ) -> Result<NearWords, InverseError> {
        let pose = ToolPose { tip_mm: Vec3::zeros(), axis };
        let Some(axis) = usable_axis(&pose) else { return Err(InverseError::NoDirection { pose: 0 }) };
        let solution = self.solution(0, &pose)?;
        let near = self.profile_index.map(|index| near_deg[index]);
        let turned = |k: usize, word: f64| word + 360.0 * nearest_integer((near[k] - word) * (1.0 / 360.0));
        let held = solution.polar_distance_rad <= self.pole_cone_rad();
        let (words, axis_residual_rad) = if held {
            let u_deg = near[0] + held_deg;
            let words = [u_deg, turned(1, self.held_word_deg(axis, u_deg))];
            (words, self.held_quality(axis, words).1)
        } else {
            let candidates = solution.words_deg.map(|words| [turned(0, words[0]), turned(1, words[1])]);
            let travel = |words: &[f64; 2]| (words[0] - near[0]).abs() + (words[1] - near[1]).abs();
            let second = solution.branches > 1 && travel(&candidates[1]) < travel(&candidates[0]);
            let residual_rad = solution.axis_residual_rad;
            (candidates[usize::from(second)], if residual_rad > REACH_SLACK_RAD { residual_rad } else { 0.0 })
        };
        let mut words_deg = [0.0; 2];
        for k in 0..2 {
            words_deg[self.profile_index[k]] = words[k];
        }
        Ok(NearWords { words_deg, axis_residual_rad, held })
    }

    /// Whether the axis next to the workpiece does not change the direction of a tool that points along `axis` in W.
    #[must_use]
    pub fn leaves_first_free(&self, axis: Vec3) -> bool {
        let pose = ToolPose { tip_mm: Vec3::zeros(), axis };
        self.solution(0, &pose).is_ok_and(|solution| solution.at_pole)
    }

    /// The difference of the word of the axis next to the workpiece between two sets of words in the profile's
    /// order \[deg\]. [`Kinematics::words_near`] holds it inside the pole cone.
    #[must_use]
    pub fn turn_next_to_workpiece(&self, from_deg: [f64; 2], to_deg: [f64; 2]) -> f64 {
        let u = self.profile_index[0];
        to_deg[u] - from_deg[u]
    }

    /// Angle between the tool axis at these rotary angles and `axis` \[rad\].
    #[must_use]
    pub fn axis_miss_rad(&self, axis: Vec3, rotary_rad: [f64; 2]) -> f64 {
        angle_between(self.axis(rotary_rad), axis)
    }
}
