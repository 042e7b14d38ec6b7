//! Decimal numbers, eight digits at a time.

use super::eight_digits::{digits_value, not_digits};

/// Powers of ten that are exact in an f64.
pub const POWERS_OF_TEN: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18,
    1e19, 1e20, 1e21, 1e22,
];

/// The largest magnitude of a number in a program: 10⁹ units.
pub const MAX_MAGNITUDE: f64 = 1e9;

/// Integers below this are exact in an f64.
const MAX_EXACT: u64 = 1 << 53;

/// A number without its sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unsigned {
    /// The f64 nearest to the decimal; infinite if it is too large.
    pub(super) value: f64,
    /// Digits after the point.
    pub(super) decimals: u8,
    /// Whether there is a point.
    pub(super) has_point: bool,
    /// Whether there is a digit before the point.
    pub(super) has_whole: bool,
    /// One after its last byte.
    pub(super) end: usize,
}

/// One after the digits of an exponent whose letter, `E` or `e`, is at this byte: an optional sign and digits, with or
/// without blanks between them. Also whether a decimal point is among or before the digits. `None` if no number
/// follows the letter.
pub(super) fn exponent_at(text: &[u8], at: usize) -> Option<(usize, bool)> {
    if !matches!(text.get(at), Some(b'E' | b'e')) {
        return None;
    }
    let blanks = |from: usize| {
        from + text.get(from..).unwrap_or_default().iter().take_while(|b| matches!(b, b' ' | b'\t')).count()
    };
    let mut from = blanks(at + 1);
    if matches!(text.get(from), Some(b'+' | b'-')) {
        from = blanks(from + 1);
    }
    read_unsigned(text, from).map(|number| (number.end, number.has_point))
}

/// Whether a number ends directly before this byte of a line that starts at `start`.
pub(super) fn follows_number(text: &[u8], start: usize, at: usize) -> bool {
    at > start && text.get(at - 1).is_some_and(|byte| byte.is_ascii_digit() || *byte == b'.')
}

/// The first byte of the number that ends before this byte of a line that starts at `start`, including its sign and
/// its letter.
pub(super) fn number_start(text: &[u8], start: usize, at: usize) -> usize {
    let line = text.get(start..at).unwrap_or_default();
    let part = |byte: &u8| byte.is_ascii_digit() || *byte == b'.';
    let digits = line.iter().rev().take_while(|byte| part(byte)).count();
    let sign = line.iter().rev().skip(digits).take_while(|byte| matches!(byte, b'+' | b'-')).count();
    let letter = line.iter().rev().nth(digits + sign).is_some_and(u8::is_ascii_alphabetic);
    at - digits - sign - usize::from(letter)
}

#[inline]
fn eight_bytes(text: &[u8], at: usize) -> Option<u64> {
    text.get(at..at + 8).and_then(|bytes| bytes.try_into().ok()).map(u64::from_le_bytes)
}

/// Reads digits with at most one point among, before or after them, starting at `at`; `None` if there is no digit.
#[inline]
pub(super) fn read_unsigned(text: &[u8], at: usize) -> Option<Unsigned> {
    read_short(text, at).or_else(|| read_long(text, at))
}

/// The bytes in which a short number is searched: a sign, eight bytes and one more, rounded up to a power of two.
const WINDOW: usize = 16;

/// The same for up to seven digits that are some bytes before the end of the text; `None` also if either does not
/// hold.
#[expect(clippy::inline_always, reason = "the innermost loop of every reader")]
#[inline(always)]
fn read_short(text: &[u8], at: usize) -> Option<Unsigned> {
    let window: &[u8; WINDOW] = text.get(at..)?.first_chunk()?;
    short_number(eight_bytes(window, 0)?, window[8], at)
}

/// A number with its sign directly before it, of up to seven digits and some bytes before the end of the text; `None`
/// if it is not. Also the sign, if there is one.
///
/// Both places where the digits may begin are loaded, because the choice between two words takes less time than a
/// load from a place that depends on the sign.
#[expect(clippy::inline_always, reason = "the innermost loop of every reader")]
#[inline(always)]
pub(super) fn read_short_signed(text: &[u8], at: usize) -> Option<(Unsigned, u8)> {
    let window: &[u8; WINDOW] = text.get(at..)?.first_chunk()?;
    let (unsigned, signed) = (eight_bytes(window, 0)?, eight_bytes(window, 1)?);
    let is_signed = matches!(window[0], b'+' | b'-');
    let (word, next) = if is_signed { (signed, window[9]) } else { (unsigned, window[8]) };
    Some((short_number(word, next, at + usize::from(is_signed))?, window[0]))
}

/// The number of up to seven digits whose first eight bytes are a word, and the byte after them.
#[expect(clippy::inline_always, reason = "the innermost loop of every reader")]
#[inline(always)]
fn short_number(word: u64, next: u8, at: usize) -> Option<Unsigned> {
    let stops = not_digits(word);
    let whole = stops.trailing_zeros() / 8;
    if whole == 8 {
        return None;
    }
    if (word >> (8 * whole)) & 0xff != u64::from(b'.') {
        if whole == 0 {
            return None;
        }
        let value = below_ten_million(word, whole);
        let end = at + whole as usize;
        return Some(Unsigned { value, decimals: 0, has_point: false, has_whole: true, end });
    }
    // The digits end before the second byte that is not a digit. Their value is not needed to find it.
    let count = (stops & (stops - 1)).trailing_zeros() / 8 - 1;
    if count == 0 || (count == 7 && next.is_ascii_digit()) {
        return None;
    }
    // Closes the gap of the point, so that seven digits are left.
    let below = (1_u64 << (8 * whole)) - 1;
    let digits = (word & below) | ((word >> 8) & !below);
    let decimals = count - whole;
    let value = below_ten_million(digits, count) / POWERS_OF_TEN[(decimals & 7) as usize];
    #[expect(clippy::cast_possible_truncation, reason = "at most 7")]
    let decimals = decimals as u8;
    Some(Unsigned { value, decimals, has_point: true, has_whole: whole > 0, end: at + count as usize + 1 })
}

/// The first `count` bytes. All of them are digits (1 ≤ count ≤ 7).
#[inline]
fn below_ten_million(word: u64, count: u32) -> f64 {
    #[expect(clippy::cast_possible_truncation, reason = "below 10⁷")]
    let value = digits_value(word, count) as u32;
    f64::from(value)
}

/// The factor for the digits before, by the number of digits after them.
const SCALE: [u64; 9] = [1, 10, 100, 1000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000];

/// The number of digits that always fit into a `u64`.
const MOST_DIGITS: u32 = 19;

/// A run of digits: the mantissa continued (saturating), and one after the last digit.
#[inline]
fn read_digits(text: &[u8], mut at: usize, mut mantissa: u64) -> (u64, usize) {
    while let Some(word) = eight_bytes(text, at) {
        let count = not_digits(word).trailing_zeros() / 8;
        if count == 0 {
            return (mantissa, at);
        }
        mantissa = mantissa.saturating_mul(SCALE[count as usize]).saturating_add(digits_value(word, count));
        at += count as usize;
        if count < 8 {
            return (mantissa, at);
        }
    }
    while let Some(digit @ b'0'..=b'9') = text.get(at) {
        mantissa = mantissa.saturating_mul(10).saturating_add(u64::from(digit - b'0'));
        at += 1;
    }
    (mantissa, at)
}

/// The same for numbers of any length, and near the end of the text.
#[inline(never)]
fn read_long(text: &[u8], at: usize) -> Option<Unsigned> {
    if let Some(number) = read_medium(text, at) {
        return Some(number);
    }
    read_any(text, at)
}

/// A number of any length with its sign directly before it. Also the sign, if there is one.
#[inline(never)]
pub(super) fn read_long_signed(text: &[u8], at: usize) -> Option<(Unsigned, u8)> {
    let first = *text.get(at)?;
    let digits = at + usize::from(matches!(first, b'+' | b'-'));
    if let Some(number) = read_medium(text, digits) {
        return Some((number, first));
    }
    read_any(text, digits).map(|number| (number, first))
}

/// The same for up to seven digits before a point and up to fifteen after it, some bytes before the end of the text.
#[expect(clippy::inline_always, reason = "a copy of its result takes as long as the number")]
#[inline(always)]
fn read_medium(text: &[u8], at: usize) -> Option<Unsigned> {
    let word = eight_bytes(text, at)?;
    let whole = not_digits(word).trailing_zeros() / 8;
    if whole == 8 || (word >> (8 * whole)) & 0xff != u64::from(b'.') {
        return None;
    }
    let fraction = at + whole as usize + 1;
    let digits = eight_bytes(text, fraction)?;
    let mut decimals = not_digits(digits).trailing_zeros() / 8;
    if decimals == 0 {
        return None;
    }
    let mut mantissa = if whole > 0 { digits_value(word, whole) } else { 0 };
    mantissa = mantissa * SCALE[decimals as usize] + digits_value(digits, decimals);
    if decimals == 8 {
        let digits = eight_bytes(text, fraction + 8)?;
        let more = not_digits(digits).trailing_zeros() / 8;
        if more == 8 || whole + 8 + more > MOST_DIGITS {
            return None;
        }
        if more > 0 {
            mantissa = mantissa * SCALE[more as usize] + digits_value(digits, more);
            decimals += more;
        }
    }
    let end = fraction + decimals as usize;
    let value = value_of(text.get(at..end)?, mantissa, decimals as usize);
    #[expect(clippy::cast_possible_truncation, reason = "at most 15")]
    let decimals = decimals as u8;
    Some(Unsigned { value, decimals, has_point: true, has_whole: whole > 0, end })
}

/// The value of the digits of a number's text, with this number of decimals.
#[inline]
fn value_of(text: &[u8], mantissa: u64, decimals: usize) -> f64 {
    match POWERS_OF_TEN.get(decimals) {
        #[expect(clippy::cast_precision_loss, reason = "below 2⁵³")]
        Some(power) if mantissa < MAX_EXACT => mantissa as f64 / power,
        // `f64::from_str` reads digits and one point, correctly rounded.
        _ => std::str::from_utf8(text).ok().and_then(|text| text.parse().ok()).unwrap_or(f64::INFINITY),
    }
}

#[expect(clippy::inline_always, reason = "a copy of its result takes as long as the number")]
#[inline(always)]
fn read_any(text: &[u8], at: usize) -> Option<Unsigned> {
    let (mut mantissa, mut end) = read_digits(text, at, 0);
    let mut digits = end - at;
    let has_whole = digits > 0;
    let has_point = text.get(end) == Some(&b'.');
    let mut decimals = 0;
    if has_point {
        let fraction = end + 1;
        (mantissa, end) = read_digits(text, fraction, mantissa);
        decimals = end - fraction;
        digits += decimals;
    }
    if digits == 0 {
        return None;
    }
    let value = value_of(text.get(at..end)?, mantissa, decimals);
    let decimals = u8::try_from(decimals).unwrap_or(u8::MAX);
    Some(Unsigned { value, decimals, has_point, has_whole, end })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_every_length_are_read_like_the_standard_library_does() {
        for text in [
            "0",
            "7",
            ".5",
            "5.",
            "0.0593",
            ".0593",
            "123456",
            "1234567",
            "12345678",
            "123456789",
            "12345.67",
            "12345.678",
            "123456.7",
            "1234567.",
            "000123.4500",
            ".1234567",
            ".12345678",
            "9007199254740993",
            "0.1234567890123456789",
            "1234567890.123456789012345678901234567890",
            "3.14159265358979",
            "00000000000000000000000000000000000001.5",
        ] {
            for tail in ["", "X", " Y1", "\r\n", "X12345678", ".."] {
                let padded = format!("{text}{tail}");
                if text.ends_with('.') && tail.starts_with('.') {
                    continue;
                }
                let read = read_unsigned(padded.as_bytes(), 0);
                let end = if tail == ".." && !text.contains('.') { text.len() + 1 } else { text.len() };
                let read = read.unwrap();
                assert_eq!(read.end, end, "{padded}");
                assert_eq!(read.value.to_bits(), text.parse::<f64>().unwrap().to_bits(), "{padded}");
            }
        }
    }

    #[test]
    fn an_exponent_is_a_letter_an_optional_sign_and_digits() {
        for (text, expected) in [
            ("e-17", Some((4, false))),
            ("E+2Y1", Some((3, false))),
            ("E5.", Some((3, true))),
            ("E-.8 ", Some((4, true))),
            ("E - 5", Some((5, false))),
            ("E", None),
            ("E=5", None),
            ("EX-5", None),
            ("D-5", None),
        ] {
            assert_eq!(exponent_at(text.as_bytes(), 0), expected, "{text}");
        }
    }

    #[test]
    fn a_number_is_followed_where_it_ends_and_starts_at_its_letter() {
        for (text, expected) in
            [("G0 X-6.12", Some(3)), ("X=-5.", Some(2)), ("12", Some(0)), ("X", None), ("X1 ", None)]
        {
            let text = text.as_bytes();
            let start = follows_number(text, 0, text.len()).then(|| number_start(text, 0, text.len()));
            assert_eq!(start, expected, "{}", String::from_utf8_lossy(text));
        }
    }

    #[test]
    fn no_digit_is_no_number() {
        for text in [".", "", "X12345678", ".X1234567", "-1234567", "..1234567", ".\n"] {
            assert_eq!(read_unsigned(text.as_bytes(), 0), None, "{text}");
        }
    }
}
