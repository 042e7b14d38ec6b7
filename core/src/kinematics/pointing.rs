//! The direction part of the inverse: two angles that turn the zero-pose tool axis into a given direction.
//!
//! Paden–Kahan subproblem 2 in half-angle form (§1 "Inverse"), made algebraic: with N and D the numerator and
//! denominator of tan²(B/2), N + D = sin σ·sin τ is constant, so that sine and cosine of B need no trigonometry.
//! One kernel serves single poses and lanes: the same bits.

use crate::geometry::{Vec3, trig};

/// The rotary directions u, v against the zero-pose tool axis t0, prepared for [`Pointing::solve`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pointing {
    /// Right-handed frame: u, then v's part across u, then u × v, each unit.
    frame: [[f64; 3]; 3],
    pub(super) sigma_rad: f64,
    pub(super) tau_rad: f64,
    sin_sigma_cos_tau: f64,
    cos_sigma_sin_tau: f64,
    pub(super) sin_tau: f64,
    /// cos², sin² of (σ − τ)/2, sin², cos² of (σ + τ)/2.
    pub(super) half: [f64; 4],
    /// sin σ · sin τ.
    pub(super) product: f64,
    inverse_product: f64,
    /// The angle about v from t0 to u \[rad\].
    pub(super) b0_rad: f64,
    /// Factors from kinematic radians to NC degrees: ±180/π for u, v.
    word_per_rad: [f64; 2],
}

/// Both solutions of one direction, and its distance from the place where they meet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pointed {
    /// NC words of u, v \[deg\] in (−180, 180], for B positive and negative.
    pub(super) words_deg: [[f64; 2]; 2],
    /// |t·(u × v′)|.
    pub(super) conditioning: f64,
    /// sin²(φ/2) and cos²(φ/2), φ the angle between u and t.
    pub(super) half_tilt: [f64; 2],
    /// N and D.
    pub(super) reach: [f64; 2],
}

/// A direction before the square root.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sighted {
    /// As in [`Pointed`].
    pub(super) half_tilt: [f64; 2],
    /// As in [`Pointed`].
    pub(super) reach: [f64; 2],
    /// y and x of the angle γ (of t across u).
    pub(super) gamma: [f64; 2],
}

/// A direction before the arc tangents.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aimed {
    /// y and x of the angle B.
    pub(super) b: [f64; 2],
    /// y and x of the angle η (of t′ across u).
    pub(super) eta: [f64; 2],
    /// As in [`Pointed`].
    pub(super) conditioning: f64,
}

impl Pointing {
    /// For the unit directions `u`, `v`, the tool axis `t0` and the directions in which the control counts (±1).
    pub(super) fn new(u: Vec3, v: Vec3, t0: Vec3, senses: [f64; 2]) -> Self {
        let normal = u.cross(&v);
        let (sin_sigma, cos_sigma) = (normal.norm(), u.dot(&v));
        let (sin_tau, cos_tau) = (v.cross(&t0).norm(), v.dot(&t0));
        let (sigma_rad, tau_rad) = (trig::atan2(sin_sigma, cos_sigma), trig::atan2(sin_tau, cos_tau));
        let (sd, cd) = trig::sin_cos(0.5 * (sigma_rad - tau_rad));
        let (ss, cs) = trig::sin_cos(0.5 * (sigma_rad + tau_rad));
        let n = normal / sin_sigma;
        let product = sin_sigma * sin_tau;
        // t0 and u projected across v before the products
        let (from, to) = (t0 - v * cos_tau, u - v * cos_sigma);
        Self {
            frame: [u.into(), n.cross(&u).into(), n.into()],
            sigma_rad,
            tau_rad,
            sin_sigma_cos_tau: sin_sigma * cos_tau,
            cos_sigma_sin_tau: cos_sigma * sin_tau,
            sin_tau,
            half: [cd * cd, sd * sd, ss * ss, cs * cs],
            product,
            inverse_product: 1.0 / product,
            b0_rad: trig::atan2(v.dot(&from.cross(&to)), from.dot(&to)),
            word_per_rad: senses.map(|sense| sense * DEG_PER_RAD),
        }
    }

    /// Both solutions for the unit direction `t`. Beyond reach the nearest ones: N or D is then negative. At the
    /// pole the words of u mean nothing.
    pub(super) fn solve(&self, t: [f64; 3]) -> Pointed {
        let Sighted { half_tilt, reach, gamma } = self.sight(t);
        let Aimed { b: [b_y, b_x], eta, conditioning } = self.aim(reach);
        let words_deg = self.both_words_deg(trig::atan2(b_y, b_x), eta, gamma);
        Pointed { words_deg, conditioning, half_tilt, reach }
    }

    /// The words of both solutions for the angle B \[rad\] and the vectors of η and γ.
    pub(super) fn both_words_deg(&self, b_rad: f64, eta: [f64; 2], gamma: [f64; 2]) -> [[f64; 2]; 2] {
        SIGNS.map(|sign| {
            let [y, x] = turn_of_u(sign, eta, gamma);
            self.words_deg(sign, [trig::atan2(y, x), b_rad])
        })
    }

    /// The part of [`Pointing::solve`] before the square root.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
    pub(super) fn sight(&self, t: [f64; 3]) -> Sighted {
        let [u, w, n] = &self.frame;
        let below = [t[0] - u[0], t[1] - u[1], t[2] - u[2]];
        let above = [t[0] + u[0], t[1] + u[1], t[2] + u[2]];
        let sin2 = 0.25 * dot(&below, &below);
        let cos2 = 0.25 * dot(&above, &above);
        let numerator = sin2 * self.half[0] - cos2 * self.half[1];
        let denominator = cos2 * self.half[2] - sin2 * self.half[3];
        Sighted { half_tilt: [sin2, cos2], reach: [numerator, denominator], gamma: [dot(&t, n), dot(&t, w)] }
    }

    /// The part of [`Pointing::solve`] from [`Sighted::reach`] to the arc tangents.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
    pub(super) fn aim(&self, [numerator, denominator]: [f64; 2]) -> Aimed {
        let num = if numerator > 0.0 { numerator } else { 0.0 };
        let den = if denominator > 0.0 { denominator } else { 0.0 };
        let double_root = 2.0 * (num * den).sqrt();
        let sin_b = double_root * self.inverse_product;
        let cos_b = (den - num) * self.inverse_product;
        Aimed {
            b: [double_root, den - num],
            // t′ = exp(β v) t0 across u: the same for both solutions except the sign along u × v.
            eta: [self.sin_tau * sin_b, self.sin_sigma_cos_tau - self.cos_sigma_sin_tau * cos_b],
            conditioning: self.product * sin_b,
        }
    }

    /// The words of the solution with B positive (`sign` 1) or negative (−1), for its u-angle and for B \[rad\].
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
    pub(super) fn words_deg(&self, sign: f64, [u_rad, b_rad]: [f64; 2]) -> [f64; 2] {
        let [u_deg, v_deg] =
            [u_rad * self.word_per_rad[0], (self.b0_rad + sign * b_rad) * self.word_per_rad[1]];
        // An arc tangent is not beyond a half turn.
        [half_turn_above(u_deg), principal_deg(v_deg)]
    }

    /// The only solution where both meet, at the nearer (`far` false: B = 0) or farther (B = π) reach limit.
    pub(super) fn solve_at_limit(&self, t: [f64; 3], far: bool) -> [f64; 2] {
        let [_, w, n] = &self.frame;
        let (b, cos_b) = if far { (std::f64::consts::PI, -1.0) } else { (0.0, 1.0) };
        let eta = trig::atan2(0.0, self.sin_sigma_cos_tau - self.cos_sigma_sin_tau * cos_b);
        let gamma = trig::atan2(dot(&t, n), dot(&t, w));
        [
            principal_deg((gamma + eta) * self.word_per_rad[0]),
            principal_deg((self.b0_rad + b) * self.word_per_rad[1]),
        ]
    }
}

/// The signs of B of both solutions, in the order of [`super::Branch`].
pub(super) const SIGNS: [f64; 2] = [1.0, -1.0];

/// y and x of the u-angle γ ± η. The vectors of γ and η are multiplied as complex numbers, which adds their angles:
/// one arc tangent instead of two, and an error of 2.5e-16 rad instead of a second arc tangent's and a sum's.
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
pub(super) fn turn_of_u(sign: f64, [eta_y, eta_x]: [f64; 2], [gamma_y, gamma_x]: [f64; 2]) -> [f64; 2] {
    let eta_y = sign * eta_y;
    [gamma_y * eta_x + gamma_x * eta_y, gamma_x * eta_x - gamma_y * eta_y]
}

/// Degrees in a radian, rounded like `f64::to_degrees`.
pub(super) const DEG_PER_RAD: f64 = 180.0 / std::f64::consts::PI;

/// A word this near to −180° \[deg\] is written as 180, so that rounding does not decide a whole turn.
const HALF_TURN_SLACK_DEG: f64 = 1e-11;

/// The same position in (−180, 180] \[deg\], for |word| far below 2⁵¹ turns.
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
pub(super) fn principal_deg(word_deg: f64) -> f64 {
    half_turn_above(word_deg - 360.0 * nearest_integer(word_deg * (1.0 / 360.0)))
}

/// A word of half a turn, up to rounding, on the side of 180 \[deg\].
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
#[expect(clippy::needless_bitwise_bool, reason = "no branch inside a lane")]
fn half_turn_above(word_deg: f64) -> f64 {
    let half_turn = (word_deg <= -180.0 + HALF_TURN_SLACK_DEG) | (word_deg > 180.0);
    if half_turn { 180.0 } else { word_deg }
}

/// Adding and subtracting 1.5·2⁵² rounds to the nearest integer.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// The nearest whole number, ties to even, for |x| < 2⁵¹: one addition and one subtraction.
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
pub(super) fn nearest_integer(x: f64) -> f64 {
    (x + ROUNDER) - ROUNDER
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::geometry::{Screw, angle_between};
    use crate::kinematics::{Kinematics, Setup};
    use crate::machine::{Machine, PRESETS};

    /// Largest difference of the u-angle from the sum of two angles \[rad\]: three arc tangents of 4.5e-16, the product
    /// with 2.5e-16, and the rounding of the sum, up to 4.5e-16.
    const SUM: f64 = 2.1e-15;
    /// Largest angle between the direction and where the words point \[rad\]: 7e-16 for the u-angle, 7e-16 for the
    /// v-angle with its sum, and 5e-16 for the words in degrees and the turns that the test itself makes.
    const MISS: f64 = 1.9e-15;

    #[test]
    fn a_product_turns_u_as_the_sum_of_both_angles_does() {
        for n in 0..400 {
            let (gamma, eta) = (f64::from(n) * 0.37 - 74.0, f64::from(n % 37) * 0.09);
            for scale in [1.0, 0.03, 1e-6, 1e-13] {
                let vector = |angle: f64| [scale * angle.sin(), scale * angle.cos()];
                let (gamma, eta) = (vector(gamma), vector(eta));
                for sign in SIGNS {
                    let [y, x] = turn_of_u(sign, eta, gamma);
                    let sum = trig::atan2(gamma[0], gamma[1]) + sign * trig::atan2(eta[0], eta[1]);
                    let apart = (trig::atan2(y, x) - sum + 3.0 * PI).rem_euclid(TAU) - PI;
                    // The remainder has a rounding of its own.
                    assert!(apart.abs() <= SUM + 1e-15, "{gamma:?} {eta:?}: {apart}");
                }
            }
        }
    }

    #[test]
    fn both_solutions_point_the_tool_from_the_pole_to_the_reach_limit() {
        for preset in &PRESETS {
            let kinematics = Kinematics::new(&Machine::new(preset.parts()).unwrap(), &Setup::default());
            let [u, v] = kinematics.screws.map(|screw| Screw { point_mm: Vec3::zeros(), ..screw });
            let pointing = &kinematics.pointing;
            let at = |words: [f64; 2]| {
                let angles: [f64; 2] = std::array::from_fn(|k| kinematics.sense[k] * words[k].to_radians());
                u.turn(angles[0], v.turn(angles[1], Machine::TOOL_AXIS))
            };
            for step in 0..2000 {
                // B from the one reach limit to the other, near to both of them and to the pole too.
                let b_rad = if step < 1000 {
                    1e-4 * 1.0103_f64.powi(step)
                } else {
                    PI * f64::from(step - 999) / 1001.0
                };
                let v_deg = kinematics.sense[1] * (pointing.b0_rad + b_rad).to_degrees();
                let direction = at([f64::from(step) * 7.123, v_deg]);
                let pointed = pointing.solve(direction.normalize().into());
                if pointed.reach[0].min(pointed.reach[1]) <= 0.0 || b_rad > PI {
                    continue;
                }
                for words in pointed.words_deg {
                    let miss = angle_between(at(words), direction);
                    assert!(miss <= MISS, "{} {b_rad}: {miss}", preset.id);
                    assert!(words.iter().all(|word| (-180.0..=180.0).contains(word)), "{words:?}");
                }
            }
        }
    }
}
