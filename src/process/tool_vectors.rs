//! Tool axes programmed as vectors (G43.5 I J K, `A3= B3= C3=`, APT i j k) as the rotary words of one machine.
//!
//! The control turns its rotary axes to the vector, on the branch and in the turn next to where they stand. What it
//! does between two vectors is a matter of its settings: the rotary axes run linearly, or the tool axis on the great
//! circle. A motion where the two differ by no more than [`SAME_COURSE_RAD`] is followed; another is left alone.

use crate::contact::rotary_rad;
use crate::geometry::{Vec3, angle_between};
use crate::kinematics::{Kinematics, Setup, ToolPose};
use crate::machine::{Machine, Travel};
use crate::motion::{AxisWords, Interpolation, Motion, Unfollowable};

/// Tool axes half way along a motion by linear rotary axes and by the great circle that count as one \[rad\]: at the
/// end of a radius of 5 mm they are 5 µm apart, a quarter of that in two parts.
const SAME_COURSE_RAD: f64 = 1e-3;
/// A vector that the axes miss by more than this and the tilt of the location errors is not the one programmed \[rad\].
const SAME_AXIS_RAD: f64 = 1e-7;
/// Words this far outside the travel are still rounding \[deg\].
const TRAVEL_SLACK_DEG: f64 = 1e-6;

/// Follows the rotary axes through the motions of a program.
#[derive(Debug, Clone)]
pub(super) struct ToolVectors {
    machine: Machine,
    kinematics: Kinematics,
    /// Where the rotary axes stand, or stood last \[deg\].
    near_deg: Option<[f64; 2]>,
    /// The last point and its vector, with its words.
    last: Option<(([f64; 3], [f64; 3]), AxisWords)>,
}

impl ToolVectors {
    /// On this machine with this set-up.
    pub(super) fn new(machine: &Machine, setup: &Setup) -> Self {
        let kinematics = Kinematics::new(machine, setup);
        Self { machine: machine.clone(), kinematics, near_deg: None, last: None }
    }

    /// Gives the motions with vectors, in the program's order, their rotary words, and takes them to be followable
    /// where the vector was all that was in the way.
    pub(super) fn resolve(&mut self, motions: &mut [Motion]) {
        for motion in motions {
            match (motion.tool_axis, motion.linear_end_mm, motion.end) {
                (Some(axis), Some(linear_mm), None) if motion.interpolation == Interpolation::Tcp => {
                    self.resolve_one(motion, (linear_mm, axis));
                }
                (.., Some(end)) => (self.near_deg, self.last) = (Some(end.rotary_deg), None),
                _ => self.last = None,
            }
        }
    }

    fn resolve_one(&mut self, motion: &mut Motion, end: ([f64; 3], [f64; 3])) {
        if motion.start.is_none() {
            motion.start = motion.vector_start.and_then(|start| self.words(start));
        }
        motion.end = self.words(end);
        let Some(words) = motion.end else { return };
        if motion.unfollowable != Some(Unfollowable::ToolVector) {
            return;
        }
        let is_same = motion.start.is_none_or(|start| self.course_rad(&start, &words) <= SAME_COURSE_RAD);
        if is_same {
            motion.unfollowable = None;
        }
    }

    /// The words of a point and its vector.
    fn words(&mut self, point: ([f64; 3], [f64; 3])) -> Option<AxisWords> {
        if let Some((_, words)) = self.last.filter(|(last, _)| *last == point) {
            return Some(words);
        }
        let (linear_mm, axis) = (point.0, Vec3::from(point.1));
        let rotary_deg = self.rotary_deg(linear_mm, axis);
        self.last = None;
        let words = AxisWords { linear_mm, rotary_deg: rotary_deg? };
        self.near_deg = rotary_deg;
        self.last = Some((point, words));
        Some(words)
    }

    fn rotary_deg(&self, tip_mm: [f64; 3], axis: Vec3) -> Option<[f64; 2]> {
        let near_deg = self.near_deg.unwrap_or_default();
        if self.near_deg.is_some()
            && let Some(words) = self.near_words(axis, near_deg)
            && self.is_within_travel(words)
        {
            return Some(words);
        }
        // The first point, or one that the nearest turn does not reach: what the travels allow next to there.
        let pose = ToolPose { tip_mm: Vec3::from(tip_mm), axis };
        let tilt_rad = self.kinematics.tilt_rad();
        let candidates = self.kinematics.candidates(0, &pose, near_deg[0]).unwrap_or_default();
        let words = candidates
            .iter()
            .filter(|candidate| candidate.axis_residual_rad <= SAME_AXIS_RAD + tilt_rad)
            .map(|candidate| -> [f64; 2] {
                let axes = self.machine.rotary_axes();
                std::array::from_fn(|k| {
                    let word = axes[k].word_deg(candidate.joints.rotary_rad[k]);
                    let turns = ((near_deg[k] - word) / 360.0).round();
                    if axes[k].travel_deg.is_none() { word + 360.0 * turns } else { word }
                })
            });
        let way = |words: &[f64; 2]| (words[0] - near_deg[0]).abs() + (words[1] - near_deg[1]).abs();
        words.min_by(|a, b| way(a).total_cmp(&way(b)))
    }

    /// On the branch and in the turn of `near_deg`.
    fn near_words(&self, axis: Vec3, near_deg: [f64; 2]) -> Option<[f64; 2]> {
        let near = self.kinematics.words_near(axis, near_deg, 0.0).ok()?;
        let most_rad = SAME_AXIS_RAD + self.kinematics.tilt_rad();
        (near.axis_residual_rad <= most_rad).then_some(near.words_deg)
    }

    fn is_within_travel(&self, words_deg: [f64; 2]) -> bool {
        self.machine.rotary_axes().iter().zip(words_deg).all(|(axis, word)| {
            axis.travel_deg.is_none_or(|Travel { min, max }| {
                (min - TRAVEL_SLACK_DEG..=max + TRAVEL_SLACK_DEG).contains(&word)
            })
        })
    }

    /// How far the tool axis half way with linear rotary axes is from the great circle \[rad\].
    fn course_rad(&self, start: &AxisWords, end: &AxisWords) -> f64 {
        let axis = |words_deg| self.kinematics.axis(rotary_rad(&self.machine, words_deg));
        let (a, b) = (start.rotary_deg, end.rotary_deg);
        let middle = axis([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]);
        let chord = axis(a) + axis(b);
        chord.try_normalize(f64::EPSILON).map_or(f64::INFINITY, |on_circle| angle_between(middle, on_circle))
    }
}
