//! Eight digits at a time. They are the bytes of one machine word, and a few multiplications make a number of them or
//! give them all. The price is this file; its tests compare it with plain digits.

/// Eight times the digit 0.
pub(super) const ZEROS: u64 = 0x3030_3030_3030_3030;

/// The high bit of every byte that is not a digit.
#[inline]
pub(super) const fn not_digits(word: u64) -> u64 {
    let x = word ^ ZEROS;
    (((x & 0x7f7f_7f7f_7f7f_7f7f) + 0x7676_7676_7676_7676) | x) & 0x8080_8080_8080_8080
}

/// The first `count` bytes as a number. All of them are digits (1 ≤ count ≤ 8).
#[inline]
pub(super) const fn digits_value(word: u64, count: u32) -> u64 {
    let x = (word ^ ZEROS) << (64 - 8 * count);
    let pairs = x.wrapping_mul(10).wrapping_add(x >> 8);
    let low = (pairs & 0x0000_00ff_0000_00ff).wrapping_mul(0x000f_4240_0000_0064);
    let high = ((pairs >> 16) & 0x0000_00ff_0000_00ff).wrapping_mul(0x0000_2710_0000_0001);
    low.wrapping_add(high) >> 32
}

/// The number that these bytes write, if all eight are digits.
#[must_use]
#[inline]
pub const fn eight_digits(bytes: [u8; 8]) -> Option<u64> {
    let word = u64::from_le_bytes(bytes);
    if not_digits(word) == 0 { Some(digits_value(word, 8)) } else { None }
}

/// The eight digits of a number below 10⁸, the first one in the lowest byte. They are numbers from 0 to 9, not text.
#[inline]
pub(super) const fn digits_of(number: u32) -> u64 {
    // Four digits in each half, then two in each quarter, then one in each byte. The factors divide by 100 and 10.
    let fours = (number / 10_000) as u64 | ((number % 10_000) as u64) << 32;
    let hundreds = ((fours * 10_486) >> 20) & 0x0000_007f_0000_007f;
    let twos = hundreds | (fours - 100 * hundreds) << 16;
    let tens = ((twos * 103) >> 10) & 0x000f_000f_000f_000f;
    tens | (twos - 10 * tens) << 8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_those_of_the_number_in_both_directions() {
        for number in (0..100_000_000).step_by(7919).chain([0, 9, 10, 9_999, 10_000, 99_999_999]) {
            let text = (digits_of(number) | ZEROS).to_le_bytes();
            assert_eq!(String::from_utf8_lossy(&text), format!("{number:08}"));
            assert_eq!(eight_digits(text), Some(u64::from(number)));
        }
    }

    #[test]
    fn any_other_byte_is_no_digit() {
        for place in 0..8 {
            for byte in 0..=u8::MAX {
                let mut text = *b"90182736";
                text[place] = byte;
                let plainly = str::from_utf8(&text).ok().filter(|_| text.iter().all(u8::is_ascii_digit));
                assert_eq!(eight_digits(text), plainly.and_then(|text| text.parse().ok()), "{text:?}");
            }
        }
    }
}
