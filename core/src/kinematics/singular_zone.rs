//! The directions in which the rotary axes have to turn far for a small turn of the tool.
//!
//! The tool axis moves by `dt = (u × t) dθ_u + (v′ × t) dθ_v`. The smaller singular value of that map, the *gain*,
//! is the smallest turn of the tool axis for a turn of the rotary axes by 1. Its inverse is how much faster than
//! the tool axis they have to turn at worst. The product of both singular values is the conditioning |t·(u × v′)|
//! of §1. All of it depends on φ alone, the angle between u and t. It vanishes at both ends of the reach, |σ − τ|
//! and min(σ + τ, 2π − σ − τ). If such an end is 0 or π, the tool is along u: the pole.

use std::f64::consts::{PI, TAU};

use super::Kinematics;
use crate::geometry::{GreatCircle, Vec3, angle_between, trig};

/// Number of halvings of an interval of φ, which reaches the last digit.
const HALVINGS: usize = 60;
/// A great circle shorter than this has no inner extreme \[rad\].
const SHORT_RAD: f64 = 1e-12;

/// The kind of singularity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SingularityKind {
    /// The tool is along the axis next to the workpiece, whose word is then free.
    Pole,
    /// The tool tilts as far as the two rotary axes allow: both solutions meet.
    ReachLimit,
}

/// The distance of a tool direction from the nearest singularity, where the rotary axes cannot follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Singularity {
    /// The kind of the nearer singularity.
    pub kind: SingularityKind,
    /// Angle to it \[rad\]; 0 beyond it.
    pub angle_rad: f64,
    /// The smallest turn of the tool axis for a turn of the rotary axes by 1.
    pub gain: f64,
}

/// The directions near a singularity on one machine, as ranges of φ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SingularZone {
    /// Outside these two angles the gain is too small \[rad\].
    inner_rad: [f64; 2],
    /// The cosines of both angles.
    inner_cos: [f64; 2],
}

/// Distance from the zone that counts as certainly outside, in cos φ. It is far above the rounding of both cosines,
/// and far below the width of any zone.
const CERTAIN: f64 = 1e-9;

impl SingularZone {
    fn outside(inner_rad: [f64; 2]) -> Self {
        Self { inner_rad, inner_cos: inner_rad.map(|angle| trig::sin_cos(angle).1) }
    }

    /// The zone of every direction.
    const EVERYWHERE: Self =
        Self { inner_rad: [f64::INFINITY, f64::NEG_INFINITY], inner_cos: [f64::NEG_INFINITY, f64::INFINITY] };

    /// Whether a stretch with this smallest and largest φ \[rad\] enters the zone.
    #[must_use]
    pub fn is_entered(&self, polar_range_rad: [f64; 2]) -> bool {
        polar_range_rad[0] < self.inner_rad[0] || polar_range_rad[1] > self.inner_rad[1]
    }
}

impl Kinematics {
    /// The angle φ between the axis next to the workpiece and the tool axis t \[rad\].
    #[must_use]
    pub fn polar_angle_rad(&self, axis: Vec3) -> f64 {
        angle_between(self.screws[0].direction, axis)
    }

    /// The nearest and the farthest φ that the two rotary axes reach \[rad\].
    #[must_use]
    pub fn polar_reach_rad(&self) -> [f64; 2] {
        let (sigma, tau) = (self.pointing.sigma_rad, self.pointing.tau_rad);
        [(sigma - tau).abs(), (sigma + tau).min(TAU - (sigma + tau))]
    }

    /// The nearest singularity of a tool at φ \[rad\] to the axis next to the workpiece.
    #[must_use]
    pub fn singularity_at(&self, polar_rad: f64) -> Singularity {
        let [nearest, farthest] = self.polar_reach_rad();
        let (to_nearest, to_farthest) = (polar_rad - nearest, farthest - polar_rad);
        let is_near = to_nearest <= to_farthest;
        let is_pole =
            if is_near { nearest <= self.pole_cone_rad() } else { PI - farthest <= self.pole_cone_rad() };
        Singularity {
            kind: if is_pole { SingularityKind::Pole } else { SingularityKind::ReachLimit },
            angle_rad: to_nearest.min(to_farthest).max(0.0),
            gain: self.gain(polar_rad),
        }
    }

    /// The zone with a gain below `least_gain`.
    #[must_use]
    pub fn singular_zone(&self, least_gain: f64) -> SingularZone {
        let [nearest, farthest] = self.polar_reach_rad();
        // B = 90°: cos φ = cos σ cos τ.
        let middle = self.polar_at(0.5 * PI);
        if self.gain(middle) < least_gain {
            return SingularZone::EVERYWHERE;
        }
        let edge = |mut outside: f64| {
            let mut inside = middle;
            for _ in 0..HALVINGS {
                let half = 0.5 * (outside + inside);
                if self.gain(half) < least_gain { outside = half } else { inside = half }
            }
            inside
        };
        SingularZone::outside([edge(nearest), edge(farthest)])
    }

    /// Whether the tool certainly stays outside the zone between two pairs of rotary words (profile order) \[rad\], on
    /// both paths of [`Self::polar_range_rad`]. A quick look: false means that this has to be asked.
    ///
    /// Every direction on either path is less than half of the axes' turns away from the direction at one end. cos φ
    /// changes no faster than the direction does.
    #[must_use]
    pub fn stays_outside(&self, zone: &SingularZone, rotary_rad: [[f64; 2]; 2]) -> bool {
        let v = self.profile_index[1];
        let [from, to] = rotary_rad.map(|angles| self.polar_cos(angles[v] - self.pointing.b0_rad));
        let turns_rad = [0, 1].map(|k| (rotary_rad[1][k] - rotary_rad[0][k]).abs());
        let away = 0.5 * (turns_rad[0] + turns_rad[1]) + CERTAIN;
        from.max(to) + away < zone.inner_cos[0] && from.min(to) - away > zone.inner_cos[1]
    }

    /// [`Self::stays_outside`] for many motions at once: all their ends have the rotary words of these ranges, and
    /// neither axis turns by more than `turns_rad` within one of them.
    #[must_use]
    pub fn all_stay_outside(
        &self,
        zone: &SingularZone,
        [least_rad, most_rad]: [[f64; 2]; 2],
        turns_rad: [f64; 2],
    ) -> bool {
        let v = self.profile_index[1];
        let [from, to] = [least_rad[v], most_rad[v]].map(|angle| angle - self.pointing.b0_rad);
        // cos φ has its extremes at the ends of the range, and where B is a whole number of half turns.
        let [first, last] = [(from - CERTAIN) / PI, (to + CERTAIN) / PI].map(f64::floor);
        let has_inner_extremes = last > first;
        let cosines = if has_inner_extremes { [0.0, PI] } else { [from, to] }.map(|b| self.polar_cos(b));
        let away = 0.5 * (turns_rad[0] + turns_rad[1]) + CERTAIN;
        cosines[0].max(cosines[1]) + away < zone.inner_cos[0]
            && cosines[0].min(cosines[1]) - away > zone.inner_cos[1]
    }

    /// cos φ at the angle B of v from the position of v at which the tool is nearest to u.
    fn polar_cos(&self, b_rad: f64) -> f64 {
        let [sin2, cos2] = self.half_polar(b_rad);
        cos2 - sin2
    }

    /// sin²(φ/2) and cos²(φ/2) at this angle B.
    fn half_polar(&self, b_rad: f64) -> [f64; 2] {
        let (sin, cos) = trig::sin_cos(0.5 * b_rad);
        let product = self.pointing.product;
        [self.pointing.half[1] + product * sin * sin, self.pointing.half[3] + product * cos * cos]
    }

    /// The smallest and the largest φ \[rad\] between two pairs of rotary words (profile order) \[deg\]: while the
    /// words run linearly, and on the great circle between the directions at both ends.
    #[must_use]
    pub fn polar_range_rad(&self, rotary_rad: [[f64; 2]; 2], axes: [Vec3; 2]) -> [f64; 2] {
        let v = self.profile_index[1];
        let [b0, b1] = rotary_rad.map(|angles| angles[v] - self.pointing.b0_rad);
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        let mut take = |polar: f64| range = [range[0].min(polar), range[1].max(polar)];
        axes.map(|axis| self.polar_angle_rad(axis)).into_iter().for_each(&mut take);
        let (low, high) = (b0.min(b1), b0.max(b1));
        let [nearest, farthest] = self.polar_reach_rad();
        if (low / TAU).ceil() * TAU <= high {
            take(nearest);
        }
        if ((low - PI) / TAU).ceil() * TAU + PI <= high {
            take(farthest);
        }
        let arc = GreatCircle::between(axes[0], axes[1], self.screws[0].direction);
        let whole = arc.angle_rad();
        if whole > SHORT_RAD && whole < PI - SHORT_RAD {
            // u·t runs as p cos s + q sin s.
            let u = self.screws[0].direction;
            let p = u.dot(&axes[0]);
            let (sin, cos) = trig::sin_cos(whole);
            let q = (u.dot(&axes[1]) - p * cos) / sin;
            let peak = trig::atan2(q, p);
            for s in [peak, peak + PI, peak - PI] {
                if s > 0.0 && s < whole {
                    take(self.polar_angle_rad(arc.at(s / whole)));
                }
            }
        }
        range
    }

    /// φ at the angle B of v from the position of v at which the tool is nearest to u \[rad\].
    fn polar_at(&self, b_rad: f64) -> f64 {
        let [sin2, cos2] = self.half_polar(b_rad);
        2.0 * trig::atan2(sin2.sqrt(), cos2.sqrt())
    }

    /// The smaller singular value of the map from turns of u and v to the turn of the tool axis.
    fn gain(&self, polar_rad: f64) -> f64 {
        let (sin, cos) = trig::sin_cos(0.5 * polar_rad);
        let (sin2, cos2) = (sin * sin, cos * cos);
        let [cd, sd, ss, cs] = self.pointing.half;
        let product = ((sin2 * cd - cos2 * sd).max(0.0) * (cos2 * ss - sin2 * cs).max(0.0)).sqrt() * 2.0;
        let squares = 4.0 * sin2 * cos2 + self.pointing.sin_tau * self.pointing.sin_tau;
        let root = (squares * squares - 4.0 * product * product).max(0.0).sqrt();
        (2.0 / (squares + root)).sqrt() * product
    }

    /// The word \[deg\] of the axis next to the tool that points it best to the unit `axis` while the axis next to
    /// the workpiece is at `first_deg`. Of the words that differ by whole turns, the one nearest to `near_deg`.
    #[must_use]
    pub fn best_second_deg(&self, axis: Vec3, first_deg: f64, near_deg: f64) -> f64 {
        let word = self.held_word_deg(axis, first_deg);
        let turned = word + 360.0 * ((near_deg - word) / 360.0).round();
        let within = |word: f64| self.travel_deg[1].is_none_or(|travel| travel.contains(word, 0.0));
        if within(turned) || !within(word) { turned } else { word }
    }

    /// Index in the profile of the axis next to the workpiece, and of the axis next to the tool.
    #[must_use]
    pub fn workpiece_to_tool(&self) -> [usize; 2] {
        self.profile_index
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kinematics::Setup;
    use crate::machine::{Machine, PRESETS, Preset};

    fn kinematics(preset: &Preset) -> Kinematics {
        Kinematics::new(&Machine::new(preset.parts()).unwrap(), &Setup::default())
    }

    /// A difference quotient over 1e-6 of numbers up to 1 keeps nine digits.
    const QUOTIENT: f64 = 1e-8;

    #[test]
    fn the_gain_is_the_smaller_singular_value_of_the_turns() {
        for preset in &PRESETS {
            let kinematics = kinematics(preset);
            for step in 1..40 {
                let rotary_rad = [0.3 + 0.1 * f64::from(step), 0.17 * f64::from(step) - 3.0];
                let at = kinematics.axis(rotary_rad);
                let columns = [0, 1].map(|k| {
                    let shifted = |by: f64| {
                        let mut angles = rotary_rad;
                        angles[k] += by;
                        kinematics.axis(angles)
                    };
                    (shifted(1e-6) - shifted(-1e-6)) / 2e-6
                });
                let jacobian = nalgebra::Matrix3x2::from_columns(&columns);
                let values = jacobian.svd(false, false).singular_values;
                let found = kinematics.singularity_at(kinematics.polar_angle_rad(at));
                let least = values.min();
                assert!((found.gain - least).abs() < QUOTIENT, "{}: {} {least}", preset.id, found.gain);
            }
        }
    }

    #[test]
    fn a_zone_holds_what_has_less_than_its_gain() {
        for preset in &PRESETS {
            let kinematics = kinematics(preset);
            let [nearest, farthest] = kinematics.polar_reach_rad();
            let zone = kinematics.singular_zone(0.05);
            for step in 0..=1000 {
                let polar = nearest + (farthest - nearest) * f64::from(step) / 1000.0;
                let gain = kinematics.singularity_at(polar).gain;
                assert_eq!(zone.is_entered([polar; 2]), gain < 0.05, "{} {polar} {gain}", preset.id);
            }
        }
    }

    #[test]
    fn what_certainly_stays_outside_a_zone_enters_it_on_no_path() {
        let mut outside = [0, 0];
        for preset in &PRESETS {
            let kinematics = kinematics(preset);
            for (step, least_gain) in (0..4000).zip([0.02, 0.05, 0.3].into_iter().cycle()) {
                let a = f64::from(step);
                let zone = kinematics.singular_zone(least_gain);
                let from = [0.13 * a, (0.29 * a).rem_euclid(TAU) - PI];
                let turn = 10_f64.powf(-3.0 * (0.37 * a).fract());
                let to = [from[0] + turn * (1.7 * a).sin(), from[1] + turn * (2.3 * a).cos()];
                let axes = [from, to].map(|angles| kinematics.axis(angles));
                let is_entered = zone.is_entered(kinematics.polar_range_rad([from, to], axes));
                let stays = kinematics.stays_outside(&zone, [from, to]);
                assert!(!(stays && is_entered), "{} {from:?} {to:?}", preset.id);
                outside[0] += u32::from(!is_entered);
                outside[1] += u32::from(stays);
            }
        }
        // A look that never answers would be of no use.
        assert!(10 * outside[1] > 7 * outside[0] && outside[0] > 1000, "{outside:?}");
    }

    #[test]
    fn the_range_of_the_polar_angle_is_that_of_many_samples() {
        for preset in &PRESETS {
            let kinematics = kinematics(preset);
            for step in 0..50 {
                let a = f64::from(step);
                let rotary_rad = [[0.13 * a, 0.29 * a - 4.0], [0.31 * a - 1.0, 0.11 * a]];
                let axes = rotary_rad.map(|angles| kinematics.axis(angles));
                let range = kinematics.polar_range_rad(rotary_rad, axes);
                let arc = GreatCircle::between(axes[0], axes[1], Vec3::z());
                let mut seen = [f64::INFINITY, f64::NEG_INFINITY];
                for k in 0..=2000 {
                    let s = f64::from(k) / 2000.0;
                    let angles = [0, 1].map(|k| rotary_rad[0][k] + (rotary_rad[1][k] - rotary_rad[0][k]) * s);
                    for axis in [kinematics.axis(angles), arc.at(s)] {
                        let polar = kinematics.polar_angle_rad(axis);
                        seen = [seen[0].min(polar), seen[1].max(polar)];
                    }
                }
                // A sample misses an extreme by up to 2e-3 rad of turn.
                assert!(range[0] <= seen[0] + 1e-12 && seen[0] < range[0] + 3e-3, "{}", preset.id);
                assert!(range[1] >= seen[1] - 1e-12 && seen[1] > range[1] - 3e-3, "{}", preset.id);
            }
        }
    }
}
