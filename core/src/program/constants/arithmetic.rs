//! The functions of parameter arithmetic, with angles in degrees as controls take them. `None`: the function has no
//! value there.
//!
//! Powers and logarithms use our own series, so that a program reads the same on every platform.

use crate::geometry::trig;

/// ln 2 in two parts: the first has so few digits that its multiples are exact.
const LN_2_HIGH: f64 = 0.693_147_180_369_123_8;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// Outside ± this value, `exp` is infinite or zero.
const MAX_EXPONENT: f64 = 709.0;
/// Whole powers up to this number are computed as products.
const MAX_PRODUCT: f64 = 1024.0;

/// Sine of an angle in degrees.
pub(in crate::program) fn sin_deg(angle_deg: f64) -> Option<f64> {
    reduced(angle_deg).map(|angle| trig::sin_cos_deg(angle).0)
}

/// Cosine of an angle in degrees.
pub(in crate::program) fn cos_deg(angle_deg: f64) -> Option<f64> {
    reduced(angle_deg).map(|angle| trig::sin_cos_deg(angle).1)
}

/// Tangent of an angle in degrees; not defined at odd multiples of 90°.
pub(in crate::program) fn tan_deg(angle_deg: f64) -> Option<f64> {
    let (sin, cos) = trig::sin_cos_deg(reduced(angle_deg)?);
    (cos != 0.0).then(|| sin / cos)
}

/// Arc sine \[deg\], for values from −1 to 1.
pub(in crate::program) fn asin_deg(value: f64) -> Option<f64> {
    (-1.0..=1.0).contains(&value).then(|| atan2_deg(value, ((1.0 - value) * (1.0 + value)).sqrt()))
}

/// Arc cosine \[deg\], for values from −1 to 1.
pub(in crate::program) fn acos_deg(value: f64) -> Option<f64> {
    (-1.0..=1.0).contains(&value).then(|| atan2_deg(((1.0 - value) * (1.0 + value)).sqrt(), value))
}

/// Angle of the point (x, y) from the x axis \[deg\], −180 to 180.
pub(in crate::program) fn atan2_deg(y: f64, x: f64) -> f64 {
    trig::atan2(y, x).to_degrees()
}

/// Square root of a value that is not negative.
pub(in crate::program) fn sqrt(value: f64) -> Option<f64> {
    (value >= 0.0).then(|| value.sqrt())
}

/// Natural logarithm of a positive value.
pub(in crate::program) fn ln(value: f64) -> Option<f64> {
    if !(value > 0.0 && value.is_finite()) {
        return None;
    }
    // value = m · 2^k with m from √½ to √2, and ln m = 2 artanh((m − 1) / (m + 1)).
    let (mut mantissa, mut exponent) = (value, 0.0);
    while mantissa > std::f64::consts::SQRT_2 {
        mantissa *= 0.5;
        exponent += 1.0;
    }
    while mantissa < std::f64::consts::FRAC_1_SQRT_2 {
        mantissa *= 2.0;
        exponent -= 1.0;
    }
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let square = s * s;
    let series = (0..11).rev().fold(0.0, |sum, k| sum * square + 1.0 / f64::from(2 * k + 1));
    Some(exponent * LN_2_HIGH + (2.0 * s * series + exponent * LN_2_LOW))
}

/// e to the power of `value`; not defined if the result is too large for a number.
pub(in crate::program) fn exp(value: f64) -> Option<f64> {
    if value.is_nan() || value > MAX_EXPONENT {
        return None;
    }
    if value < -MAX_EXPONENT {
        return Some(0.0);
    }
    let halvings = (value * std::f64::consts::LOG2_E).round();
    let rest = (value - halvings * LN_2_HIGH) - halvings * LN_2_LOW;
    let series = (1..17).rev().fold(1.0, |sum, k| 1.0 + sum * rest / f64::from(k));
    Some(product(if halvings < 0.0 { 0.5 } else { 2.0 }, halvings.abs()) * series)
}

/// `base` to the power of `exponent`. For whole exponents it is a product; otherwise the base must not be negative.
pub(in crate::program) fn power(base: f64, exponent: f64) -> Option<f64> {
    let value = if exponent.abs() <= MAX_PRODUCT && exponent.fract() == 0.0 {
        let value = product(base, exponent.abs());
        if exponent < 0.0 { 1.0 / value } else { value }
    } else if base == 0.0 && exponent > 0.0 {
        0.0
    } else {
        exp(ln(base)? * exponent)?
    };
    value.is_finite().then_some(value)
}

/// `base` multiplied by itself `count` times.
fn product(mut base: f64, mut count: f64) -> f64 {
    let mut value = 1.0;
    while count >= 1.0 {
        if count % 2.0 >= 1.0 {
            value *= base;
        }
        base *= base;
        count = (count * 0.5).floor();
    }
    value
}

/// The same direction, between −360° and 360°.
fn reduced(angle_deg: f64) -> Option<f64> {
    angle_deg.is_finite().then_some(angle_deg % 360.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Share of the largest result: a few units in the last place.
    const RELATIVE: f64 = 1e-14;

    #[test]
    fn powers_and_logarithms_agree_with_the_platform() {
        for value in [1e-300, 1e-9, 0.1, 0.5, 0.9999, 1.0, 1.0001, 2.0, 3.7, 12_345.678, 1e300] {
            let expected = f64::ln(value);
            let found = ln(value).unwrap();
            assert!((found - expected).abs() <= RELATIVE * expected.abs(), "ln {value}: {found}, {expected}");
        }
        for value in [-700.0, -12.5, -1.0, -1e-9, 0.0, 1e-9, 0.3, 1.0, 2.5, 88.7, 700.0] {
            let expected = f64::exp(value);
            let found = exp(value).unwrap();
            assert!((found / expected - 1.0).abs() <= RELATIVE, "exp {value}: {found}, {expected}");
        }
        for (base, exponent) in [(2.0, 10.0), (2.0, 0.5), (-3.0, 3.0), (1.5, -4.0), (10.0, 2.5), (0.0, 2.0)] {
            let expected = f64::powf(base, exponent);
            let found = power(base, exponent).unwrap();
            assert!((found - expected).abs() <= RELATIVE * expected.abs(), "{base} ** {exponent}: {found}");
        }
    }

    #[test]
    fn what_is_not_defined_has_no_value() {
        for undefined in [
            ln(0.0),
            ln(-1.0),
            sqrt(-1e-9),
            asin_deg(1.000_1),
            acos_deg(-2.0),
            tan_deg(90.0),
            tan_deg(-270.0),
            exp(710.0),
            power(-2.0, 0.5),
            power(0.0, -1.0),
            sin_deg(f64::INFINITY),
        ] {
            assert_eq!(undefined, None);
        }
    }

    #[test]
    fn angles_are_degrees() {
        assert_eq!(sin_deg(30.0).map(|sin| (sin * 1e15).round()), Some(0.5e15));
        assert_eq!(cos_deg(-450.0), Some(0.0));
        assert!((asin_deg(0.5).unwrap() - 30.0).abs() < 1e-13);
        assert!((acos_deg(-0.5).unwrap() - 120.0).abs() < 1e-13);
        assert!((atan2_deg(-1.0, -1.0) + 135.0).abs() < 1e-13);
        assert!((tan_deg(45.0).unwrap() - 1.0).abs() < 1e-15);
    }
}
