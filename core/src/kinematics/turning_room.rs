//! How far the axis next to the workpiece may turn while the other one keeps the tool within a tolerance.
//!
//! With u at `θ_u`, the best v leaves the tool axis `|∠(v, exp(−θ_u û) t) − τ|` away from t, and
//! `cos ∠ = cos σ cos φ + sin σ sin φ cos x`, where x is the rest of t's azimuth. The words within a tolerance are
//! therefore an interval about each of the two solutions, in closed form. Near a singularity the two intervals grow
//! together, and at the pole every word is within tolerance.

use std::f64::consts::{PI, TAU};

use super::pointing::DEG_PER_RAD;
use super::{Branch, Kinematics};
use crate::geometry::{Vec3, angle_about, trig};
use crate::machine::Machine;

/// A direction whose part across the axis is shorter than this has no azimuth.
const NO_AZIMUTH: f64 = 1e-14;

/// Words of the axis next to the workpiece \[deg\]: an interval, without ends if every word is within tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurningRoom {
    /// Smallest and largest word.
    pub range_deg: [f64; 2],
}

impl TurningRoom {
    /// No room: only this word.
    #[must_use]
    pub fn only(word_deg: f64) -> Self {
        Self { range_deg: [word_deg; 2] }
    }

    /// Whether every word is within tolerance, regardless of travel.
    #[must_use]
    pub fn is_free(&self) -> bool {
        self.range_deg == [f64::NEG_INFINITY, f64::INFINITY]
    }

    /// The word of the interval that is nearest to this one \[deg\].
    #[must_use]
    pub fn nearest_deg(&self, word_deg: f64) -> f64 {
        word_deg.max(self.range_deg[0]).min(self.range_deg[1])
    }
}

impl Kinematics {
    /// The solution of the direction to which these rotary angles (profile order) \[rad\] belong.
    #[must_use]
    pub fn branch(&self, rotary_rad: [f64; 2]) -> Branch {
        let b_rad = rotary_rad[self.profile_index[1]] - self.pointing.b0_rad;
        if trig::sin_cos(b_rad).0 >= 0.0 { Branch::Plus } else { Branch::Minus }
    }

    /// The words of the axis next to the workpiece with which the other axis can point the tool to the unit `axis`
    /// within `tolerance_rad`. They are about the solution of this branch, in the turn nearest to `near_deg`. The
    /// travel is not checked. `None` if there is no such word.
    #[must_use]
    pub fn turning_room(
        &self,
        axis: Vec3,
        branch: Branch,
        near_deg: f64,
        tolerance_rad: f64,
    ) -> Option<TurningRoom> {
        let [u, v] = self.screws.map(|screw| screw.direction);
        let (sigma, tau) = (self.pointing.sigma_rad, self.pointing.tau_rad);
        let (sin_sigma, cos_sigma) = trig::sin_cos(sigma);
        let (across, along) = (u.cross(&axis).norm(), u.dot(&axis));
        let cosine = |angle_rad: f64| trig::sin_cos(angle_rad.clamp(0.0, PI)).1 - cos_sigma * along;
        let (low, high) = (cosine(tau + tolerance_rad), cosine(tau - tolerance_rad));
        let reach = sin_sigma * across;
        if across < NO_AZIMUTH {
            let range_deg = [f64::NEG_INFINITY, f64::INFINITY];
            return (low <= 0.0 && high >= 0.0).then_some(TurningRoom { range_deg });
        }
        let (low, high) = (low / reach, high / reach);
        if low > 1.0 || high < -1.0 {
            return None;
        }
        let arc_cosine = |c: f64| trig::atan2(((1.0 - c) * (1.0 + c)).max(0.0).sqrt(), c);
        let azimuth = angle_about(u, v, axis);
        let sign = if branch == Branch::Plus { 1.0 } else { -1.0 };
        // x between these, on the side of the branch.
        let (from, to) = match (high >= 1.0, low <= -1.0) {
            (true, true) => return Some(TurningRoom { range_deg: [f64::NEG_INFINITY, f64::INFINITY] }),
            (true, false) => (-arc_cosine(low), arc_cosine(low)),
            (false, true) => (arc_cosine(high), TAU - arc_cosine(high)),
            (false, false) => (arc_cosine(high), arc_cosine(low)),
        };
        let ends = [from, to].map(|x| self.sense[0] * DEG_PER_RAD * (azimuth + sign * x));
        let (a, b) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
        let turn = 360.0 * ((near_deg - 0.5 * (a + b)) / 360.0).round();
        Some(TurningRoom { range_deg: [a + turn, b + turn] })
    }

    /// The tool axis with these words of the axis next to the workpiece and the one next to the tool \[deg\].
    #[must_use]
    pub fn axis_of_words(&self, words_deg: [f64; 2]) -> Vec3 {
        let [first, second] = [0, 1].map(|k| self.sense[k] * words_deg[k].to_radians());
        self.screws[0].turn(first, self.screws[1].turn(second, Machine::TOOL_AXIS))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::angle_between;
    use crate::kinematics::Setup;
    use crate::machine::PRESETS;

    /// Sums of a few cosines, with twice the digits lost near the pole \[rad\].
    const ARITHMETIC_RAD: f64 = 1e-9;

    #[test]
    fn a_word_is_in_the_room_if_and_only_if_the_tool_can_be_kept() {
        for preset in &PRESETS {
            let mut parts = preset.parts();
            parts.rotary_axes.iter_mut().for_each(|axis| axis.travel_deg = None);
            let kinematics = Kinematics::new(&Machine::new(parts).unwrap(), &Setup::default());
            let [u, v] = kinematics.screws.map(|screw| screw.direction);
            let [s, b0] = [kinematics.sense[1], kinematics.pointing.b0_rad];
            for b_deg in [0.0, 0.02, 0.3, -0.3, 5.0, -40.0, 90.0, 179.0, 179.99, 180.0] {
                let words = [33.0, s * (f64::to_degrees(b0) + b_deg)];
                let axis = kinematics.axis_of_words(words);
                let mut rotary_rad = [0.0; 2];
                for k in 0..2 {
                    rotary_rad[kinematics.profile_index[k]] = kinematics.sense[k] * words[k].to_radians();
                }
                let branch = kinematics.branch(rotary_rad);
                for tolerance_rad in [1e-4, 5e-3] {
                    let room = kinematics.turning_room(axis, branch, words[0], tolerance_rad).unwrap();
                    let [low, high] = room.range_deg;
                    let whole = format!("{} B {b_deg} within {tolerance_rad}: {room:?}", preset.id);
                    assert!(low <= words[0] + 1e-6 && words[0] - 1e-6 <= high, "{whole}");
                    let miss = |word_deg: f64| {
                        let turned = crate::geometry::Screw { direction: u, point_mm: u * 0.0 }
                            .turn(-kinematics.sense[0] * word_deg.to_radians(), axis);
                        (angle_between(v, turned) - kinematics.pointing.tau_rad).abs()
                    };
                    if room.is_free() {
                        assert!((0..36).all(|k| miss(f64::from(k) * 10.0) <= tolerance_rad + ARITHMETIC_RAD));
                        continue;
                    }
                    for k in 0..=20 {
                        let word = low + (high - low) * f64::from(k) / 20.0;
                        assert!(miss(word) <= tolerance_rad + ARITHMETIC_RAD, "{whole} {word}");
                        let second = kinematics.best_second_deg(axis, word, words[1]);
                        let left = angle_between(axis, kinematics.axis_of_words([word, second]));
                        assert!((left - miss(word)).abs() < ARITHMETIC_RAD, "{whole}");
                    }
                    for end in [low, high] {
                        assert!((miss(end) - tolerance_rad).abs() < ARITHMETIC_RAD, "{whole}");
                    }
                }
            }
        }
    }
}
