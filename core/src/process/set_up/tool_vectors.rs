//! Tool axes programmed as vectors (G43.5 I J K, `A3= B3= C3=`, APT i j k) as the rotary words of one machine.
//!
//! The control turns its rotary axes to the vector, on the branch and in the turn next to their present positions.
//! Its motion between two vectors depends on its settings: the rotary axes run linearly, or the tool axis follows
//! the great circle. A motion is followed if the two differ by no more than [`SAME_COURSE_RAD`]. Any other motion
//! is left unchanged.

use super::program_setup::ProgramSetup;
use super::set_ups::SetUps;
use crate::contact::rotary_rad;
use crate::geometry::{Vec3, angle_between};
use crate::kinematics::ToolPose;
use crate::machine::{Machine, Travel};
use crate::motion::{AxisWords, Interpolation, Motion, MotionKind, Unfollowable};

/// Largest angle, half way along a motion, between the tool axes by linear rotary axes and by the great circle, at
/// which both courses are the same \[rad\]. At a radius of 5 mm it is 5 µm; in two parts a quarter of that.
const SAME_COURSE_RAD: f64 = 1e-3;
/// Largest angle between the programmed vector and the one reached, on top of the tilt of the location errors
/// \[rad\].
const SAME_AXIS_RAD: f64 = 1e-7;

/// X Y Z \[mm\] and the tool axis as written.
type VectorPoint = ([f64; 3], [f64; 3]);

/// Follows the rotary axes through the motions of a program.
#[derive(Debug, Clone)]
pub(in crate::process) struct ToolVectors {
    machine: Machine,
    set_ups: SetUps,
    /// Present or last known positions of the rotary axes \[deg\].
    near_deg: Option<[f64; 2]>,
    /// The last point and its vector, with its words.
    last: Option<(VectorPoint, AxisWords)>,
}

impl ToolVectors {
    /// For this machine with the set-up of this program.
    pub(in crate::process) fn new(machine: &Machine, program: &ProgramSetup) -> Self {
        let set_ups = SetUps::new(machine, program);
        Self { machine: machine.clone(), set_ups, near_deg: None, last: None }
    }

    /// Gives motions with vectors their rotary words, in program order. A motion that only its vector made
    /// impossible to follow can then be followed.
    pub(in crate::process) fn resolve(&mut self, motions: &mut [Motion]) {
        for motion in motions {
            match (motion.tool_axis, motion.linear_end_mm, motion.end) {
                (Some(axis), Some(linear_mm), None) if motion.interpolation == Interpolation::Tcp => {
                    if self.set_ups.enter(motion) {
                        self.last = None;
                    }
                    self.resolve_one(motion, (linear_mm, axis));
                }
                (.., Some(end)) => (self.near_deg, self.last) = (Some(end.rotary_deg), None),
                _ => {
                    self.last = None;
                    if motion.unfollowable.is_some_and(turns_unseen) {
                        self.near_deg = None;
                    }
                }
            }
        }
    }

    /// The same for the next motion, which will be passed in again.
    pub(in crate::process) fn resolve_ahead(&mut self, motion: &mut Motion) {
        let kept = (self.near_deg, self.last, self.set_ups.now.clone());
        self.resolve(std::slice::from_mut(motion));
        (self.near_deg, self.last, self.set_ups.now) = kept;
    }

    /// Continues after motions that were resolved elsewhere and that all end at known words.
    pub(in crate::process) fn pass_over(&mut self, motions: &[Motion]) {
        let Some(Motion { end: Some(end), linear_end_mm, tool_axis, .. }) = motions.last() else { return };
        self.near_deg = Some(end.rotary_deg);
        self.last = linear_end_mm.zip(*tool_axis).map(|point| (point, *end));
    }

    fn resolve_one(&mut self, motion: &mut Motion, end: VectorPoint) {
        if motion.start.is_none() {
            motion.start = motion.vector_start.and_then(|start| self.words(start));
        }
        motion.end = self.words(end);
        let Some(words) = motion.end else { return };
        if motion.unfollowable != Some(Unfollowable::ToolVector) {
            return;
        }
        // The course of a rapid cuts nothing.
        let is_same = motion.kind == MotionKind::Rapid
            || motion.start.is_none_or(|start| self.course_rad(&start, &words) <= SAME_COURSE_RAD);
        if is_same {
            motion.unfollowable = None;
        }
    }

    /// The words of a point with its vector.
    fn words(&mut self, point: VectorPoint) -> Option<AxisWords> {
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
        // The first point, or a point that the nearest turn does not reach: take the solution within travel that is
        // nearest.
        let pose = ToolPose { tip_mm: Vec3::from(tip_mm), axis };
        let tilt_rad = self.set_ups.now.kinematics.tilt_rad();
        let candidates = self.set_ups.now.kinematics.candidates(0, &pose, near_deg[0]).unwrap_or_default();
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
        let near = self.set_ups.now.kinematics.words_near(axis, near_deg, 0.0).ok()?;
        let most_rad = SAME_AXIS_RAD + self.set_ups.now.kinematics.tilt_rad();
        (near.axis_residual_rad <= most_rad).then_some(near.words_deg)
    }

    fn is_within_travel(&self, words_deg: [f64; 2]) -> bool {
        self.machine.rotary_axes().iter().zip(words_deg).all(|(axis, word)| {
            axis.travel_deg.is_none_or(|Travel { min, max }| {
                (min - Travel::WORD_SLACK..=max + Travel::WORD_SLACK).contains(&word)
            })
        })
    }

    /// Angle between the tool axis with linear rotary axes and the great circle, half way \[rad\].
    fn course_rad(&self, start: &AxisWords, end: &AxisWords) -> f64 {
        let axis = |words_deg| self.set_ups.now.kinematics.axis(rotary_rad(&self.machine, words_deg));
        let (a, b) = (start.rotary_deg, end.rotary_deg);
        let middle = axis([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])]);
        let chord = axis(a) + axis(b);
        chord.try_normalize(f64::EPSILON).map_or(f64::INFINITY, |on_circle| angle_between(middle, on_circle))
    }
}

/// Whether the positions of the rotary axes are unknown after such a motion.
fn turns_unseen(reason: Unfollowable) -> bool {
    use Unfollowable as U;
    matches!(reason, U::Reference | U::MachineCoordinates | U::Call | U::Return | U::UnknownCode | U::Probing)
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use super::*;
    use crate::machine::Preset;
    use crate::motion::Interpreter;
    use crate::program::{Batch, Diagnostics, Dialect, ReadLimits, Reader};

    /// Precision of angles through vectors with seven decimals \[deg\].
    const NEAR_DEG: f64 = 2e-5;

    fn tables(travel_deg: Option<Travel>) -> Machine {
        let mut parts = Preset::by_id("ac-table").unwrap().parts();
        parts.rotary_axes[0].travel_deg = travel_deg;
        Machine::new(parts).unwrap()
    }

    fn resolved(machine: &Machine, text: &str) -> Vec<Motion> {
        let mut reader = Reader::new(Some(Dialect::Iso), ReadLimits::default());
        let mut interpreter =
            Interpreter::new(machine, ProgramSetup::in_mm(&crate::kinematics::Setup::default()).options());
        let mut vectors =
            ToolVectors::new(machine, &ProgramSetup::in_mm(&crate::kinematics::Setup::default()));
        let (mut batch, mut motions, mut diagnostics) = (Batch::new(), Vec::new(), Diagnostics::new());
        reader.feed(text.as_bytes());
        reader.finish();
        while reader.next_batch(&mut batch).unwrap() {
            interpreter.interpret(&mut batch, &mut motions, &mut diagnostics);
        }
        vectors.resolve(&mut motions);
        motions
    }

    /// `I J K` of an AC table.
    fn vector(a_deg: f64, c_deg: f64) -> String {
        let ((sa, ca), (sc, cc)) = (a_deg.to_radians().sin_cos(), c_deg.to_radians().sin_cos());
        format!("I{:.7} J{:.7} K{:.7}", sa * sc, -sa * cc, ca)
    }

    fn assert_words(motion: &Motion, expected: [f64; 2]) {
        let found = motion.end.unwrap().rotary_deg;
        let near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < NEAR_DEG);
        assert!(near, "line {}: {found:?}, {expected:?}", motion.line);
    }

    #[test]
    fn vectors_become_the_words_next_to_those_before() {
        let machine = tables(None);
        let angles = [
            [30.0, 10.0],
            [31.0, 11.0],
            [20.0, 40.0],
            [20.5, 100.0],
            [21.0, 175.0],
            [21.5, 185.0],
            [22.0, 186.0],
        ];
        let mut text = "G43.5 H1\nG1 F500\n".to_owned();
        for (index, [a, c]) in angles.into_iter().enumerate() {
            writeln!(text, "X{index} Y1. Z2. {}", vector(a, c)).unwrap();
        }
        text.push_str("X9.\nG49\nX10. I1.\n");
        let motions = resolved(&machine, &text);
        for (motion, expected) in motions.iter().zip(angles) {
            assert_words(motion, expected);
        }
        assert_eq!((motions[0].start, motions[0].unfollowable), (None, None));
        assert_eq!((motions[1].start, motions[1].unfollowable), (motions[0].end, None));
        // 60° about C at 20°: the control decides how the axis turns on the way.
        assert_eq!(motions[3].unfollowable, Some(Unfollowable::ToolVector));
        assert_eq!(motions[6].unfollowable, None);
        // The vector still applies.
        assert_words(&motions[7], [22.0, 186.0]);
        assert_eq!((motions[7].start, motions[7].unfollowable), (motions[6].end, None));
        // The vector no longer applies.
        assert_eq!(motions[8].end, None);
        assert!(motions[8].unfollowable.is_some());
    }

    #[test]
    fn behind_a_reference_return_the_axes_turn_from_there() {
        let mut text = "G43.5 H1\nG1 F500\n".to_owned();
        for turn in 0..5 {
            writeln!(text, "X{turn}. Y0. Z0. {}", vector(30.0, 10.0 + 90.0 * f64::from(turn))).unwrap();
        }
        writeln!(text, "G28 Z0 A0 C0\nG1 X0. Y0. Z0. {}", vector(30.0, 20.0)).unwrap();
        let motions = resolved(&tables(None), &text);
        assert_words(&motions[4], [30.0, 370.0]);
        assert_words(&motions[6], [30.0, 20.0]);
    }

    #[test]
    fn travels_decide_where_the_nearest_words_are_out_of_reach() {
        let machine = tables(Some(Travel { min: -100.0, max: 20.0 }));
        let text =
            format!("G43.5 H1\nG1 F500 X0. Y0. Z0. {}\nX1. {}\n", vector(30.0, 10.0), vector(31.0, 10.5));
        let motions = resolved(&machine, &text);
        assert_words(&motions[0], [-30.0, -170.0]);
        assert_words(&motions[1], [-31.0, -169.5]);
        assert_eq!(motions[1].unfollowable, None);
    }

    #[test]
    fn what_is_no_whole_vector_is_left_alone() {
        let machine = tables(None);
        let head = format!("G43.5 H1\nG1 F500 X0. Y0. Z0. {}\n", vector(30.0, 10.0));
        for block in ["X1. I0.1", "X1. I0.1 J0.2", "X1. I#1 J0. K1.", "X1. I0. J0. K0.", "X#1 I0.1 J0.2 K0.9"]
        {
            let motions = resolved(&machine, &format!("{head}{block}\nX2. I0.1 J0.2 K0.9\n"));
            assert!(motions[1].unfollowable.is_some(), "{block}");
            assert_eq!(motions[1].end, None, "{block}");
            assert_eq!(motions[2].start, None, "{block}");
        }
        // I J K are arc centres here, not vectors.
        let motions = resolved(&machine, &format!("{head}G2 X1. Y1. I1. J0.\n"));
        assert_eq!(motions[1].tool_axis, motions[0].tool_axis);
    }
}
