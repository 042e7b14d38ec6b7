//! Short decimals, printed eight digits at a time.
//!
//! Nearly every number of a program has at most eight digits. These fit into one machine word: a few multiplications
//! give all of them at once, and the point goes between two shifted copies. One such number takes about as long as with
//! [`print_into`](super::decimal::print_into). But it is a value, so a block's numbers are computed side by side before
//! the first one is written. The price is a second way to print a number. The tests compare the two.
//!
//! Text is appended in pieces of a fixed length and cut to its own length afterwards. A copy of a fixed length is two
//! instructions; a copy of any other length is a call.

use super::decimal::Look;
use super::number::POWERS_OF_TEN;

/// The most decimals of a short number: one digit is left before the point.
const MOST_DECIMALS: u8 = 7;
/// Numbers below this many whole units of their last decimal round to at most eight digits.
const EIGHT_DIGITS_END: f64 = 99_999_999.0;
/// Sign, eight digits, a point, and what the last eight bytes reach beyond.
const ROOM: usize = 32;
/// The longest text that is copied in one piece [bytes].
const PIECE: usize = 16;
/// The bytes of a row that wait.
const ROW: usize = 128;
/// Eight times the digit 0.
const ZEROS: u64 = 0x3030_3030_3030_3030;

/// The eight digits of a number below 10⁸, the first one in the lowest byte.
#[inline]
const fn eight_digits(number: u32) -> u64 {
    // Four digits in each half, then two in each quarter, then one in each byte. The factors divide by 100 and 10.
    let fours = (number / 10_000) as u64 | ((number % 10_000) as u64) << 32;
    let hundreds = ((fours * 10_486) >> 20) & 0x0000_007f_0000_007f;
    let twos = hundreds | (fours - 100 * hundreds) << 16;
    let tens = ((twos * 103) >> 10) & 0x000f_000f_000f_000f;
    tens | (twos - 10 * tens) << 8
}

/// A number of at most eight digits, of which at most seven are decimals, as it is written.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShortDecimal {
    /// The digits, the first one in the lowest byte.
    digits: u64,
    /// The number of digits before the point.
    whole: u32,
    /// The length of the whole text.
    length: u32,
    sign: u8,
    /// Whether the sign is written.
    is_signed: bool,
}

impl ShortDecimal {
    /// No text.
    pub(super) const NOTHING: Self = Self { digits: 0, whole: 0, length: 0, sign: 0, is_signed: false };

    /// The number with this number of decimals; `None` if it is not short.
    #[inline]
    pub(super) fn of(value: f64, decimals: u8, look: Look) -> Option<Self> {
        if decimals > MOST_DECIMALS {
            return None;
        }
        let units = (value * POWERS_OF_TEN[usize::from(decimals)]).abs();
        let is_short = units < EIGHT_DIGITS_END;
        if !is_short {
            return None;
        }
        // Adds a half and cuts, as the plain version does.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 10⁸")]
        let number = (units + 0.5) as u32;
        let is_negative = value < 0.0 && number > 0;
        let digits = eight_digits(number);
        let significant = 8 - digits.trailing_zeros() / 8;
        let decimals = u32::from(decimals);
        let least = decimals + u32::from(decimals == 0 || !look.drops_zero);
        let count = significant.max(least);
        let is_signed = is_negative || look.plus;
        Some(Self {
            digits: (digits | ZEROS) >> ((64 - 8 * count) & 63),
            whole: count - decimals,
            length: u32::from(is_signed) + count + u32::from(decimals > 0 || look.ends_in_point),
            sign: if is_negative { b'-' } else { b'+' },
            is_signed,
        })
    }

    #[inline]
    fn write_to(self, room: &mut [u8; ROOM]) -> usize {
        let (start, whole) = (usize::from(self.is_signed), (self.whole & 15) as usize);
        room[0] = self.sign;
        room[start..start + 8].copy_from_slice(&self.digits.to_le_bytes());
        room[start + whole] = b'.';
        // All eight digits may be before the point. A shift by 64 bits is not allowed.
        let fraction = (self.digits >> (4 * whole)) >> (4 * whole);
        room[start + whole + 1..start + whole + 9].copy_from_slice(&fraction.to_le_bytes());
        self.length as usize
    }
}

/// A row of text on its way to the end of a longer text. The first bytes wait in an array, which is faster to write to
/// than the end of a vector.
pub(super) struct Row<'a> {
    bytes: [u8; ROW],
    length: usize,
    out: &'a mut Vec<u8>,
}

impl<'a> Row<'a> {
    pub(super) fn new(out: &'a mut Vec<u8>) -> Self {
        Self { bytes: [0; ROW], length: 0, out }
    }

    /// Appends the bytes between two positions of a text.
    #[inline]
    pub(super) fn push_piece(&mut self, text: &[u8], from: usize, to: usize) {
        if to <= from + PIECE
            && let Some(piece) = text.get(from..).and_then(<[u8]>::first_chunk::<PIECE>)
            && let Some(room) = self.bytes.get_mut(self.length..).and_then(<[u8]>::first_chunk_mut)
        {
            *room = *piece;
            self.length += to.saturating_sub(from);
        } else {
            self.flush().extend_from_slice(text.get(from..to).unwrap_or_default());
        }
    }

    /// Appends a number.
    #[inline]
    pub(super) fn push_short(&mut self, number: ShortDecimal) {
        if self.length + ROOM > ROW {
            self.flush();
        }
        if let Some(room) = self.bytes.get_mut(self.length..).and_then(<[u8]>::first_chunk_mut) {
            self.length += number.write_to(room);
        }
    }

    /// Hands the bytes over that wait, and gives the text to which others can be appended.
    pub(super) fn flush(&mut self) -> &mut Vec<u8> {
        self.out.extend_from_slice(self.bytes.get(..self.length).unwrap_or_default());
        self.length = 0;
        self.out
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::program::decimal::{BUFFER, print_into};

    fn plainly(value: f64, decimals: u8, look: Look) -> Vec<u8> {
        let mut buffer = [0; BUFFER];
        let start = print_into(value, decimals, look, &mut buffer);
        buffer[start..].to_vec()
    }

    fn assert_same(value: f64, decimals: u8) {
        for bits in 0..8 {
            let look = Look { drops_zero: bits & 1 > 0, ends_in_point: bits & 2 > 0, plus: bits & 4 > 0 };
            let Some(number) = ShortDecimal::of(value, decimals, look) else { continue };
            let mut out = b"X".to_vec();
            let mut row = Row::new(&mut out);
            row.push_short(number);
            row.flush();
            let text = plainly(value, decimals, look);
            assert_eq!(out[1..], text, "{value:?} with {decimals} decimals, {look:?}");
        }
    }

    #[test]
    fn digits_are_those_of_the_number() {
        for number in (0..100_000_000).step_by(7919).chain([0, 9, 10, 9_999, 10_000, 99_999_999]) {
            let text = (eight_digits(number) | ZEROS).to_le_bytes();
            assert_eq!(String::from_utf8_lossy(&text), format!("{number:08}"));
        }
    }

    #[test]
    fn ends_and_ties_print_as_with_the_plain_version() {
        for decimals in 0..=9 {
            for value in [0.0, 0.5, 1.5, 0.0625, 0.125, 9.5, 0.99, 12.345_678, 1e5, 1e7, 1e9] {
                assert_same(value, decimals);
                assert_same(-value, decimals);
            }
            for units in [0.49, 0.5, 1.0, 99_999_998.0, 99_999_998.5, 99_999_999.0, 99_999_999.5, 1e8, 1e9] {
                assert_same(units / POWERS_OF_TEN[usize::from(decimals)], decimals);
                assert_same(-units / POWERS_OF_TEN[usize::from(decimals)], decimals);
            }
        }
    }

    #[test]
    fn rows_of_every_length_hold_their_pieces_and_numbers() {
        let text: Vec<u8> = (0..64).collect();
        let (mut quickly, mut plain) = (vec![7], vec![7]);
        let mut row = Row::new(&mut quickly);
        for from in 0..=text.len() {
            for to in from..=text.len() {
                row.push_piece(&text, from, to);
                plain.extend_from_slice(&text[from..to]);
                let (value, decimals) = (from as f64 / 8.0 - 3.0, u8::try_from(to % 8).unwrap());
                row.push_short(ShortDecimal::of(value, decimals, Look::default()).unwrap());
                plain.extend(plainly(value, decimals, Look::default()));
            }
        }
        row.flush();
        assert_eq!(quickly, plain);
    }

    proptest! {
        #[test]
        fn every_number_prints_as_with_the_plain_version(
            units in -200_000_000_i32..200_000_000,
            part in -0.5..0.5_f64,
            decimals in 0_u8..10,
            own in 0_u8..10,
        ) {
            assert_same((f64::from(units) + part) / POWERS_OF_TEN[usize::from(own)], decimals);
        }
    }
}
