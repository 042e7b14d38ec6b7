//! Functions of the Sinumerik, with angles in degrees.

use super::expression::{Arguments, Number};
use crate::program::constants::arithmetic;

/// If a value is closer than this to a whole number, the result of TRUNC and similar functions depends on the
/// control's own rounding.
const NEARLY_WHOLE: f64 = 1e-9;

/// The value of a function; `None` if the function or its arguments are not known.
pub(super) fn function(name: &[u8], arguments: &Arguments) -> Option<Number> {
    let is = |wanted: &[u8]| name.eq_ignore_ascii_case(wanted);
    let known: Option<Number> = match *arguments.values() {
        [Some(a)] if arguments.count == 1 => {
            let x = a.value;
            let value = if is(b"SIN") {
                arithmetic::sin_deg(x)?
            } else if is(b"COS") {
                arithmetic::cos_deg(x)?
            } else if is(b"TAN") {
                if arithmetic::cos_deg(x)?.abs() < NEARLY_WHOLE {
                    return None;
                }
                arithmetic::tan_deg(x)?
            } else if is(b"ASIN") {
                arithmetic::asin_deg(x)?
            } else if is(b"ACOS") {
                arithmetic::acos_deg(x)?
            } else if is(b"SQRT") {
                arithmetic::sqrt(x)?
            } else if is(b"ABS") {
                return Some(Number { value: x.abs(), ..a });
            } else if is(b"POT") {
                return Some(Number { value: x * x, ..a });
            } else if is(b"TRUNC") {
                return cut(x, f64::trunc);
            } else if is(b"ROUND") {
                return rounded(x);
            } else if is(b"ROUNDUP") {
                return cut(x, f64::ceil);
            } else if is(b"LN") {
                arithmetic::ln(x)?
            } else if is(b"EXP") {
                arithmetic::exp(x)?
            } else {
                return None;
            };
            Some(Number::real(value + 0.0))
        }
        // The angle of (second, first). Angles count from the direction of the second.
        [Some(a), Some(b)] if arguments.count == 2 && is(b"ATAN2") => {
            (a.value != 0.0 || b.value != 0.0).then(|| Number::real(arithmetic::atan2_deg(a.value, b.value)))
        }
        [Some(a), Some(b)] if arguments.count == 2 && is(b"MINVAL") => {
            Some(if b.value < a.value { b } else { a })
        }
        [Some(a), Some(b)] if arguments.count == 2 && is(b"MAXVAL") => {
            Some(if b.value > a.value { b } else { a })
        }
        [Some(low), Some(high), Some(value)]
            if arguments.count == 3 && is(b"BOUND") && low.value <= high.value =>
        {
            Some(if value.value < low.value {
                low
            } else if value.value > high.value {
                high
            } else {
                value
            })
        }
        _ => None,
    };
    known.filter(|number| number.value.is_finite())
}

/// Cuts to a whole number if it is certain which.
fn cut(value: f64, how: fn(f64) -> f64) -> Option<Number> {
    let nearest = value.round();
    let is_near = (value - nearest).abs() <= NEARLY_WHOLE * value.abs().max(1.0);
    #[expect(clippy::float_cmp, reason = "whole to the last bit, or too near to tell")]
    let is_whole = value == nearest;
    (is_whole || !is_near).then(|| Number::whole(how(value) + 0.0))
}

/// Rounds half up. The manuals do not describe halves below zero.
pub(super) fn rounded(value: f64) -> Option<Number> {
    let is_half = ((value - value.floor()) - 0.5).abs() <= NEARLY_WHOLE;
    let is_exact_half = value.fract().to_bits() == 0.5_f64.to_bits();
    (is_exact_half || !is_half).then(|| Number::whole((value + 0.5).floor() + 0.0))
}
