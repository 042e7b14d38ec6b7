//! Numbers as decimals: printing, and rounding to the value that a control reads back.

use super::number::POWERS_OF_TEN;

/// The most decimals that are ever printed. More are cut to this number.
pub const MAX_DECIMALS: u8 = 15;

/// The most whole units of the last decimal. Above this the integer is not exact, so fewer decimals are printed.
const MAX_WHOLE: f64 = 1e18;

/// From 2⁵² on every double is a whole number.
const FRACTIONS_END: f64 = 4_503_599_627_370_496.0;

/// `value` in whole units of the last decimal, and the number of decimals that are kept.
#[inline]
fn whole_units(value: f64, decimals: u8) -> (i64, usize) {
    let mut decimals = usize::from(decimals.min(MAX_DECIMALS));
    while decimals > 0 && value.abs() * POWERS_OF_TEN[decimals] >= MAX_WHOLE {
        decimals -= 1;
    }
    let units = value * POWERS_OF_TEN[decimals];
    // Adds a half and cuts, because `f64::round` is a call on targets without an instruction for it.
    let half = if units.abs() < FRACTIONS_END { 0.5_f64.copysign(units) } else { 0.0 };
    #[expect(
        clippy::cast_possible_truncation,
        reason = "below 10¹⁸, or saturating for what no program holds"
    )]
    let whole = (units + half) as i64;
    (whole, decimals)
}

/// The decimal with `decimals` digits nearest to `value`, as a control (and [`super::Reader`]) reads it back: n/10^d,
/// correctly rounded to an f64. Never −0. A value that is not finite stays unchanged.
#[must_use]
#[inline]
pub fn round_to_decimals(value: f64, decimals: u8) -> f64 {
    if !value.is_finite() {
        return value;
    }
    let (whole, decimals) = whole_units(value, decimals);
    // 0 / 10^d is +0. The integer loses the sign of a negative zero.
    #[expect(clippy::cast_precision_loss, reason = "it came from an f64 and is one")]
    let numerator = whole as f64;
    numerator / POWERS_OF_TEN[decimals]
}

const PAIRS: [[u8; 2]; 100] = {
    let mut pairs = [[0; 2]; 100];
    let mut n = 0;
    while n < 100 {
        #[expect(clippy::cast_possible_truncation, reason = "below 100")]
        let digits = [b'0' + (n / 10) as u8, b'0' + (n % 10) as u8];
        pairs[n] = digits;
        n += 1;
    }
    pairs
};

/// The style of a number besides its digits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Look {
    /// `.5` instead of `0.5`.
    pub(super) drops_zero: bool,
    /// `5.` instead of `5`.
    pub(super) ends_in_point: bool,
    /// `+5` instead of `5`.
    pub(super) plus: bool,
}

/// Sign, 19 digits, point, and room.
pub(super) const BUFFER: usize = 40;

/// Prints into the end of `buffer` and returns where the text starts.
#[inline]
pub(super) fn print_into(value: f64, decimals: u8, look: Look, buffer: &mut [u8; BUFFER]) -> usize {
    let (whole, decimals) = whole_units(value, decimals);
    let mut rest = whole.unsigned_abs();
    let mut at = BUFFER;
    // Digits of the fraction, two at a time from the right.
    let mut left = decimals;
    while left >= 2 {
        let pair = PAIRS[(rest % 100) as usize];
        rest /= 100;
        at -= 2;
        buffer[at..at + 2].copy_from_slice(&pair);
        left -= 2;
    }
    if left == 1 {
        at -= 1;
        buffer[at] = PAIRS[(rest % 10) as usize][1];
        rest /= 10;
    }
    if decimals > 0 || look.ends_in_point {
        at -= 1;
        buffer[at] = b'.';
    }
    if rest > 0 || decimals == 0 || !look.drops_zero {
        while rest >= 100 {
            let pair = PAIRS[(rest % 100) as usize];
            rest /= 100;
            at -= 2;
            buffer[at..at + 2].copy_from_slice(&pair);
        }
        let [tens, ones] = PAIRS[(rest % 100) as usize];
        at -= 1;
        buffer[at] = ones;
        if tens != b'0' {
            at -= 1;
            buffer[at] = tens;
        }
    }
    if whole < 0 || look.plus {
        at -= 1;
        buffer[at] = if whole < 0 { b'-' } else { b'+' };
    }
    at
}

/// Appends `value` with `decimals` digits after the point. The printed text reads back as [`round_to_decimals`] gives
/// it. Never `-0.000`. A value that is not finite cannot be printed; callers check this before.
pub fn print_decimal(value: f64, decimals: u8, out: &mut Vec<u8>) {
    let mut buffer = [0; BUFFER];
    let start = print_into(value, decimals, Look::default(), &mut buffer);
    out.extend_from_slice(&buffer[start..]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn printed(value: f64, decimals: u8) -> String {
        let mut out = Vec::new();
        print_decimal(value, decimals, &mut out);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn zero_never_has_a_minus() {
        assert_eq!(printed(-0.0, 3), "0.000");
        assert_eq!(printed(-0.0004, 3), "0.000");
        assert!(round_to_decimals(-0.0004, 3).is_sign_positive());
    }

    #[test]
    fn every_length_prints() {
        assert_eq!(printed(1.5, 0), "2");
        assert_eq!(printed(-12.3456, 2), "-12.35");
        assert_eq!(printed(100.0, 0), "100");
        assert_eq!(printed(0.05, 4), "0.0500");
        assert_eq!(printed(-360_000.125, 3), "-360000.125");
        assert_eq!(printed(1e9, 15), "1000000000.00000000");
        assert_eq!(printed(0.001, 15), "0.001000000000000");
    }

    #[test]
    fn the_look_of_a_program_is_kept() {
        let mut buffer = [0; BUFFER];
        let look = Look { drops_zero: true, ends_in_point: true, plus: true };
        for (value, decimals, text) in [(0.5, 1, "+.5"), (-0.5, 2, "-.50"), (3.0, 0, "+3."), (0.0, 0, "+0.")]
        {
            let start = print_into(value, decimals, look, &mut buffer);
            assert_eq!(&buffer[start..], text.as_bytes());
        }
    }
}
