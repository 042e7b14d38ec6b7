//! Arc tangent, sine and cosine of whole arrays, with the bits of [`trig`].
//!
//! Horner's rule is one long chain: each step waits for the one before. A loop over [`trig::atan2`] is therefore bound
//! by latency, because the processor looks ahead only a few lanes. Short loops help: each does a part of the chain for
//! all lanes, and many lanes are under way at a time. Measured: an arc tangent takes 0.66 of the time with AVX2, 0.9
//! with AVX-512 and 0.64 with SSE2. The price is scratch memory, and the formulas a second time. The tests compare
//! every bit with [`trig`].

use super::trig::{self, ATAN, QUARTER_PI, QUARTER_PI_LOW, TAN_PI_8};

const SIGN: u64 = 1 << 63;

/// `y[lane]` becomes [`trig::atan2`] of `y[lane]` and `x[lane]`.
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
pub(crate) fn atan2<const N: usize>(y: &mut [f64; N], x: &[f64; N], scratch: &mut [[f64; N]; 3]) {
    let [ratio, eighths, sum] = scratch;
    for lane in 0..N {
        (ratio[lane], eighths[lane]) = fold(y[lane], x[lane]);
    }
    let [a0, a1, a2, a3, a4, a5, a6, a7, a8, a9] = ATAN;
    for lane in 0..N {
        let z = ratio[lane] * ratio[lane];
        sum[lane] = ((((a9 * z + a8) * z + a7) * z + a6) * z + a5) * z + a4;
    }
    for lane in 0..N {
        let (t, k) = (ratio[lane], eighths[lane]);
        let z = t * t;
        let polynomial = (((sum[lane] * z + a3) * z + a2) * z + a1) * z + a0;
        let angle = t + t * z * polynomial;
        y[lane] = (k * QUARTER_PI + (k * QUARTER_PI_LOW + angle)).copysign(y[lane]);
    }
}

/// The ratio of which the arc tangent is taken, and the eighths of a turn to add. Signs are bits here: the polynomial
/// is odd, so the sign of its angle may go in first.
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
fn fold(y: f64, x: f64) -> (f64, f64) {
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ay > ax;
    let large = if steep { ay } else { ax };
    let small = if steep { ax } else { ay };
    let diagonal = small > TAN_PI_8 * large;
    let numerator = if diagonal { small - large } else { small };
    let denominator = if diagonal { small + large } else { large };
    let denominator = if denominator > 0.0 { denominator } else { 1.0 };
    // Steep and behind turn the sign once each. Adding 0 makes −0 positive.
    let flip = ((ax - ay).to_bits() ^ (x + 0.0).to_bits()) & SIGN;
    let eighth = if diagonal { 1.0_f64 } else { 0.0 };
    let behind = if x < 0.0 { 4.0 } else { 0.0 };
    let base = if steep { 2.0 } else { behind };
    let ratio = numerator / denominator;
    (f64::from_bits(ratio.to_bits() ^ flip), base + f64::from_bits(eighth.to_bits() ^ flip))
}

/// [`trig::sin_cos`] of every lane.
#[inline(always)]
#[expect(clippy::inline_always, reason = "must take on the instruction set of the caller")]
pub(crate) fn sin_cos<const N: usize>(angle_rad: &[f64; N], sin: &mut [f64; N], cos: &mut [f64; N]) {
    for lane in 0..N {
        (sin[lane], cos[lane]) = trig::reduced(angle_rad[lane]);
    }
    for lane in 0..N {
        (sin[lane], cos[lane]) = trig::in_quadrant(sin[lane], cos[lane].to_bits());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 64;

    /// A repeatable stream of numbers in [−1, 1).
    fn stream() -> impl FnMut() -> f64 {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 11) as f64) * 2.0_f64.powi(-52) - 1.0
        }
    }

    fn compare(y: &[f64; N], x: &[f64; N]) {
        let mut angle = *y;
        atan2(&mut angle, x, &mut [[0.0; N]; 3]);
        let (mut sin, mut cos) = ([0.0; N], [0.0; N]);
        sin_cos(y, &mut sin, &mut cos);
        for lane in 0..N {
            let (y, x) = (y[lane], x[lane]);
            assert_eq!(angle[lane].to_bits(), trig::atan2(y, x).to_bits(), "{y} {x}");
            let (s, c) = trig::sin_cos(y);
            assert_eq!([sin[lane].to_bits(), cos[lane].to_bits()], [s.to_bits(), c.to_bits()], "{y}");
        }
    }

    #[test]
    fn arrays_get_the_bits_of_single_numbers() {
        let mut next = stream();
        for scale in [1.0, 1e-9, 1e5, 1e-300] {
            for _ in 0..500 {
                compare(&std::array::from_fn(|_| next() * scale), &std::array::from_fn(|_| next()));
                compare(&std::array::from_fn(|_| next()), &std::array::from_fn(|_| next() * scale));
            }
        }
    }

    #[test]
    fn zeros_equal_sides_and_folds_get_the_same_bits() {
        let special = [0.0, -0.0, 1.0, -1.0, TAN_PI_8, -TAN_PI_8, 1e-310, -1e300];
        let y = std::array::from_fn(|lane| special[lane / 8]);
        let x = std::array::from_fn(|lane| special[lane % 8]);
        compare(&y, &x);
    }
}
