//! Reads the number at the start of a text. Numbers are most of the bytes that the service reads.
//!
//! The library needs the end of a number first. It checks every form, and it runs six times for each pose. Here the
//! digits are collected while the end is found. Up to 2⁵³ the digits are an exact `f64`, and so is a power of ten up to
//! 10²². One multiplication or division of the two rounds once, so its result is the nearest number: the same bits as
//! the library's. All other numbers are left to the library. The price is this file; its test compares both.

use crate::program::{POWERS_OF_TEN, eight_digits};

/// Up to here every whole number is an exact `f64`.
const LARGEST_EXACT: u64 = 1 << 53;
/// The number of digits that always fit into a `u64`.
const MOST_DIGITS: usize = 19;

/// The number at the beginning of `text` and its length, if `text` begins with a finite number as JSON writes it. The
/// caller checks what follows.
#[inline]
pub(super) fn number_at(text: &[u8]) -> Option<(f64, usize)> {
    let negative = text.first() == Some(&b'-');
    let whole = usize::from(negative);
    let mut digits = Digits { value: 0, at: whole };
    digits.take(text);
    let whole_digits = digits.at - whole;
    // JSON has no number like 007.
    if whole_digits == 0 || (whole_digits > 1 && text.get(whole) == Some(&b'0')) {
        return None;
    }
    let mut decimals = 0;
    if text.get(digits.at) == Some(&b'.') {
        digits.at += 1;
        let point = digits.at;
        digits.take(text);
        decimals = digits.at - point;
        if decimals == 0 {
            return None;
        }
    }
    let has_exponent = matches!(text.get(digits.at), Some(b'e' | b'E'));
    if has_exponent || whole_digits + decimals > MOST_DIGITS || digits.value > LARGEST_EXACT {
        return by_library(text, digits.at, has_exponent);
    }
    let size = digits.value as f64 / POWERS_OF_TEN.get(decimals)?;
    Some((if negative { -size } else { size }, digits.at))
}

/// Digits in a row.
struct Digits {
    /// Their number, as long as it fits.
    value: u64,
    /// Place after the last of them.
    at: usize,
}

impl Digits {
    #[inline]
    fn take(&mut self, text: &[u8]) {
        while let Some(eight) =
            text.get(self.at..).and_then(|rest| rest.first_chunk().copied()).and_then(eight_digits)
        {
            self.value = self.value.wrapping_mul(100_000_000).wrapping_add(eight);
            self.at += 8;
        }
        while let Some(digit) =
            text.get(self.at).map(|byte| byte.wrapping_sub(b'0')).filter(|digit| *digit < 10)
        {
            self.value = self.value.wrapping_mul(10).wrapping_add(u64::from(digit));
            self.at += 1;
        }
    }
}

/// The number whose digits end at `end`, an exponent excluded.
fn by_library(text: &[u8], mut end: usize, has_exponent: bool) -> Option<(f64, usize)> {
    if has_exponent {
        end += 1;
        end += usize::from(matches!(text.get(end), Some(b'+' | b'-')));
        let digits = text.get(end..)?.iter().take_while(|byte| byte.is_ascii_digit()).count();
        if digits == 0 {
            return None;
        }
        end += digits;
    }
    let number: f64 = std::str::from_utf8(text.get(..end)?).ok()?.parse().ok()?;
    number.is_finite().then_some((number, end))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same by JSON's reader and by the standard library.
    fn compare(text: &str) {
        let by_json: Result<f64, _> = serde_json::from_str(text);
        let found = number_at(text.as_bytes()).filter(|(_, length)| *length == text.len());
        assert_eq!(found.map(|(number, _)| number.to_bits()), by_json.ok().map(f64::to_bits), "{text:?}");
        if let Some((number, _)) = found {
            assert_eq!(number.to_bits(), text.parse::<f64>().unwrap().to_bits(), "{text:?}");
        }
    }

    #[test]
    fn every_number_has_the_bits_of_the_library() {
        for text in [
            "0",
            "-0",
            "-0.0",
            "1",
            "-1",
            "007",
            "00",
            "0.5",
            ".5",
            "5.",
            "-",
            "",
            "+1",
            "1e5",
            "1E-5",
            "1e",
            "1e+",
            "1.e5",
            "1.5e3",
            "9007199254740992",
            "9007199254740993",
            "9007199254740993.5",
            "90071992547409930",
            "0.1",
            "0.30000000000000004",
            "1e22",
            "1e23",
            "1e308",
            "1e309",
            "-1e309",
            "5e-324",
            "1e-400",
            "123456789012345678901234567890",
            "0.0000000000000000000000001",
            "18446744073709551615",
            "18446744073709551616",
            "12345678",
            "123456789",
            "1234567.12345678",
            "NaN",
            "inf",
            "0x1",
            "1_0",
            "0.1234567890123456789",
            "99999999.99999999",
            "1234567:",
            "1234567/",
        ] {
            compare(text);
        }
        let mut state = 88_172_645_463_325_252_u64;
        for _ in 0..200_000 {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let number = f64::from_bits(state);
            let near = (state >> 11) as f64 / (1_u64 << 43) as f64 - 512.0;
            for number in [number, near] {
                if number.is_finite() {
                    compare(&number.to_string());
                    compare(&format!("{number:e}"));
                }
            }
            compare(&format!("{near:.*}", (state % 12) as usize));
        }
    }

    #[test]
    fn it_ends_where_the_number_ends() {
        for (text, length) in
            [("1,2", 1), ("-12.25}", 6), ("3 ", 1), ("4e2]", 3), ("5\n", 1), ("12345678,", 8)]
        {
            assert_eq!(number_at(text.as_bytes()).map(|(_, length)| length), Some(length), "{text}");
        }
    }
}
