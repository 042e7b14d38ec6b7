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
        let Aimed { b, eta, conditioning } = self.aim(reach);
        let angles_rad = [b, eta, gamma].map(|[y, x]| trig::atan2(y, x));
        Pointed { words_deg: self.words_deg(angles_rad), conditioning, half_tilt, reach }
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

    /// The words of both solutions for the angles B, η and γ \[rad\].
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
    pub(super) fn words_deg(&self, [b, eta, gamma]: [f64; 3]) -> [[f64; 2]; 2] {
        let word = |angle_rad: f64, k: usize| principal_deg(angle_rad * self.word_per_rad[k]);
        [[word(gamma + eta, 0), word(self.b0_rad + b, 1)], [word(gamma - eta, 0), word(self.b0_rad - b, 1)]]
    }

    /// The words of the solution with B positive (`sign` 1) or negative (−1). They equal those of
    /// [`Pointing::words_deg`].
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
    pub(super) fn words_of_sign(&self, sign: f64, [b, eta, gamma]: [f64; 3]) -> [f64; 2] {
        let word = |angle_rad: f64, k: usize| principal_deg(angle_rad * self.word_per_rad[k]);
        [word(gamma + sign * eta, 0), word(self.b0_rad + sign * b, 1)]
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

/// Degrees in a radian, rounded like `f64::to_degrees`.
pub(super) const DEG_PER_RAD: f64 = 180.0 / std::f64::consts::PI;

/// A word this near to −180° \[deg\] is written as 180, so that rounding does not decide a whole turn.
const HALF_TURN_SLACK_DEG: f64 = 1e-11;

/// The same position in (−180, 180] \[deg\], for |word| far below 2⁵¹ turns.
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
#[expect(clippy::needless_bitwise_bool, reason = "no branch inside a lane")]
pub(super) fn principal_deg(word_deg: f64) -> f64 {
    let wrapped = word_deg - 360.0 * nearest_integer(word_deg * (1.0 / 360.0));
    let half_turn = (wrapped <= -180.0 + HALF_TURN_SLACK_DEG) | (wrapped > 180.0);
    if half_turn { 180.0 } else { wrapped }
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
