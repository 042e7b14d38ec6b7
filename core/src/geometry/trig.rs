//! Sine, cosine and arc tangent as polynomials: the same bits on every platform and at every vector width.
//!
//! The platform's library differs between systems, and the compiler cannot vectorise it. These functions have no
//! branch, no table and no fused multiply-add, so that a loop over slices becomes vector code and every
//! instruction set gives the same result. Coefficients: Chebyshev fits on |r| ≤ π/4 and |t| ≤ tan(π/8).

/// Largest magnitude \[rad\] or \[deg\] for which the stated errors hold.
pub const MAX_ANGLE: f64 = 1e7;

/// Adding and subtracting 1.5·2⁵² rounds to the nearest integer. That integer is then in the lowest bits.
const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// π/2 in three parts, the first two of 29 bits: their products with integers below 2²⁴ are exact.
const HALF_PI: [f64; 3] = [1.570_796_325_802_803, 9.920_935_774_287_987e-10, 2.251_741_774_156_217_6e-18];

const SIN: [f64; 6] = [
    -0.166_666_666_666_666_66,
    0.008_333_333_333_330_948,
    -0.000_198_412_698_367_567_74,
    2.755_731_610_161_787_4e-6,
    -2.505_113_165_023_518e-8,
    1.591_811_526_326_597_4e-10,
];
const COS: [f64; 6] = [
    0.041_666_666_666_666_664,
    -0.001_388_888_888_888_739_8,
    2.480_158_729_876_456e-5,
    -2.755_731_727_114_514_4e-7,
    2.087_614_614_655_861e-9,
    -1.138_262_364_747_460_4e-11,
];
pub(super) const ATAN: [f64; 10] = [
    -0.333_333_333_333_332_5,
    0.199_999_999_998_982_38,
    -0.142_857_142_660_679_5,
    0.111_111_096_346_726_53,
    -0.090_908_524_969_848_74,
    0.076_910_540_710_295_89,
    -0.066_496_022_096_694_96,
    0.057_362_617_450_565_89,
    -0.044_831_026_218_406_116,
    0.022_747_352_471_342_214,
];
pub(super) const TAN_PI_8: f64 = 0.414_213_562_373_095_03;
pub(super) const QUARTER_PI: f64 = std::f64::consts::FRAC_PI_4;
/// π/4 − [`QUARTER_PI`].
pub(super) const QUARTER_PI_LOW: f64 = 3.061_616_997_868_383e-17;

/// Sine and cosine of an angle \[rad\], each within 4.5e-16 for |angle| ≤ [`MAX_ANGLE`].
///
/// Reduction by π/2 in three parts (Cody and Waite), then one polynomial each. An input that is not finite gives
/// NaN.
#[inline(always)]
#[must_use]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
pub fn sin_cos(angle_rad: f64) -> (f64, f64) {
    let (r, quarter) = reduced(angle_rad);
    in_quadrant(r, quarter.to_bits())
}

/// The angle \[rad\] less whole quarter turns, and a number with these quarters in its lowest bits.
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
pub(super) fn reduced(angle_rad: f64) -> (f64, f64) {
    let shifted = angle_rad * std::f64::consts::FRAC_2_PI + ROUNDER;
    let n = shifted - ROUNDER;
    (((angle_rad - n * HALF_PI[0]) - n * HALF_PI[1]) - n * HALF_PI[2], shifted)
}

/// Sine and cosine of an angle in degrees, each within 4.5e-16 for |angle| ≤ [`MAX_ANGLE`]; exact at multiples
/// of 90°, because the reduction is done in degrees and has no error.
#[inline(always)]
#[must_use]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
pub fn sin_cos_deg(angle_deg: f64) -> (f64, f64) {
    let shifted = angle_deg * (1.0 / 90.0) + ROUNDER;
    let n = shifted - ROUNDER;
    in_quadrant((angle_deg - n * 90.0) * (std::f64::consts::PI / 180.0), shifted.to_bits())
}

/// Sine and cosine of `r` (|r| ≤ π/4) plus the quarter turns in the lowest two bits of `quarter`.
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
pub(super) fn in_quadrant(r: f64, quarter: u64) -> (f64, f64) {
    let z = r * r;
    let s = r + r * z * polynomial(&SIN, z);
    let half = 0.5 * z;
    let w = 1.0 - half;
    let c = w + (((1.0 - w) - half) + z * z * polynomial(&COS, z));
    // In an odd quarter sine and cosine change places; then the signs, by their bits.
    let odd = (quarter & 1).wrapping_neg();
    let (s, c) = (s.to_bits(), c.to_bits());
    let exchanged = (s ^ c) & odd;
    let sine_sign = (quarter & 2) << 62;
    let cosine_sign = (quarter.wrapping_add(1) & 2) << 62;
    (f64::from_bits((s ^ exchanged) ^ sine_sign), f64::from_bits((c ^ exchanged) ^ cosine_sign))
}

/// The angle of the point (x, y) in [−π, π] \[rad\], within 4.5e-16 if |x|, |y| ≤ 1e300 and the larger one is a
/// normal number. The signs are those of the usual function, except `x = −0` with `y = 0`, which gives ±0.
#[inline(always)]
#[must_use]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
pub fn atan2(y: f64, x: f64) -> f64 {
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ay > ax;
    let large = if steep { ay } else { ax };
    let small = if steep { ax } else { ay };
    // small/large, or its angle measured from π/4
    let diagonal = small > TAN_PI_8 * large;
    let numerator = if diagonal { small - large } else { small };
    let denominator = if diagonal { small + large } else { large };
    let denominator = if denominator > 0.0 { denominator } else { 1.0 };
    let t = numerator / denominator;
    let z = t * t;
    let angle = t + t * z * polynomial(&ATAN, z);
    // unfold: each fold maps a to K − a, so that the constant is a whole number of eighths, added only once
    let eighths = if diagonal { 1.0 } else { 0.0 };
    let angle = if steep { -angle } else { angle };
    let eighths = if steep { 2.0 - eighths } else { eighths };
    let behind = x < 0.0;
    let angle = if behind { -angle } else { angle };
    let eighths = if behind { 4.0 - eighths } else { eighths };
    (eighths * QUARTER_PI + (eighths * QUARTER_PI_LOW + angle)).copysign(y)
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the calling loop")]
fn polynomial<const N: usize>(coefficients: &[f64; N], z: f64) -> f64 {
    let mut sum = coefficients[N - 1];
    let mut k = N - 1;
    while k > 0 {
        k -= 1;
        sum = sum * z + coefficients[k];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The stated bound [rad, or pure number].
    const BOUND: f64 = 4.5e-16;
    /// The platform's library itself is wrong by up to one unit in the last place of numbers up to π.
    const LIBRARY: f64 = 2.3e-16;

    /// A repeatable stream of numbers in [−1, 1).
    fn stream() -> impl FnMut() -> f64 {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64) * 2.0_f64.powi(-52) - 1.0
        }
    }

    #[test]
    fn sine_and_cosine_keep_their_bound() {
        let mut next = stream();
        for scale in [1e-8, 0.8, 4.0, 100.0, 1e5, 1e7] {
            for _ in 0..100_000 {
                let a = next() * scale;
                let (s, c) = sin_cos(a);
                assert!((s - a.sin()).abs() <= BOUND && (c - a.cos()).abs() <= BOUND, "{a}");
            }
        }
    }

    #[test]
    fn degrees_keep_the_bound_and_are_exact_at_quarters() {
        let mut next = stream();
        for _ in 0..200_000 {
            let a = next() * 180.0;
            let (s, c) = sin_cos_deg(a);
            // the conversion of the argument has its own rounding, up to half a unit of π
            let r = a.to_radians();
            assert!((s - r.sin()).abs() <= BOUND + LIBRARY && (c - r.cos()).abs() <= BOUND + LIBRARY, "{a}");
        }
        for n in -400..400_i32 {
            let (s, c) = sin_cos_deg(f64::from(n) * 90.0);
            let expected = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][n.rem_euclid(4) as usize];
            assert_eq!((s, c), expected, "{n}");
            let (s, c) = sin_cos_deg(f64::from(n) * 90.0 + 30.0);
            let (s0, c0) = sin_cos_deg(f64::from(n.rem_euclid(4)) * 90.0 + 30.0);
            assert_eq!((s, c), (s0, c0), "{n}");
        }
    }

    #[test]
    fn arc_tangent_keeps_its_bound() {
        let mut next = stream();
        for scale in [1.0, 1e-3, 1e-9, 1e6, 1e200] {
            for _ in 0..100_000 {
                let (y, x) = (next() * scale, next());
                assert!((atan2(y, x) - y.atan2(x)).abs() <= BOUND, "{y} {x}");
            }
        }
        for k in 0..=100_000 {
            let (y, x) = (1.0, f64::from(k) * 2e-5 - 1.0);
            assert!((atan2(y, x) - y.atan2(x)).abs() <= BOUND, "{x}");
            assert!((atan2(-x, -y) - (-x).atan2(-y)).abs() <= BOUND, "{x}");
        }
    }

    #[test]
    fn arc_tangent_is_defined_on_the_axes() {
        for (y, x) in
            [(0.0, 1.0), (0.0, -1.0), (-0.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (1.0, 1.0), (-1.0, -1.0)]
        {
            assert!((atan2(y, x) - f64::atan2(y, x)).abs() <= BOUND, "{y} {x}");
        }
        assert_eq!(atan2(0.0, 0.0).to_bits(), 0.0_f64.to_bits());
    }
}
