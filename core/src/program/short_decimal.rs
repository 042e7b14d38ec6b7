//! Short decimals, printed eight digits at a time.
//!
//! Nearly every number of a program has at most eight digits. These fit into one machine word: a few multiplications
//! give all of them at once, and the point goes between two shifted copies. There is no loop and hardly a branch, so a
//! processor begins a number before it has finished the one before. The price is a second way to print a number. The
//! tests compare the two.
//!
//! Text is written in pieces of a fixed length, and what is too much is written over. A copy of a fixed length is two
//! instructions; a copy of any other length is a call.

use super::decimal::Look;
use super::eight_digits::{ZEROS, digits_of};
use super::number::POWERS_OF_TEN;

/// The most decimals of a short number: one digit is left before the point.
const MOST_DECIMALS: u8 = 7;
/// Numbers below this many whole units of their last decimal round to at most eight digits.
const EIGHT_DIGITS_END: f64 = 99_999_999.0;
/// Sign, eight digits, a point, and what the last eight bytes reach beyond.
const ROOM: usize = 32;
/// The longest text that is copied in one piece [bytes].
const PIECE: usize = 16;
/// The longest row, with the room that its last number needs [bytes].
const ROW: usize = 192;

/// A number of at most eight digits, of which at most seven are decimals, and how it is written.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShortDecimal {
    /// The number in units of its last decimal, without its sign.
    units: u32,
    decimals: u8,
    /// The least number of digits.
    least: u8,
    sign: u8,
    /// Whether the sign is written.
    is_signed: bool,
    has_point: bool,
}

impl ShortDecimal {
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
        let units = (units + 0.5) as i64 as u32;
        let is_negative = value < 0.0 && units > 0;
        Some(Self {
            units,
            decimals,
            least: decimals + u8::from(decimals == 0 || !look.drops_zero),
            sign: if is_negative { b'-' } else { b'+' },
            is_signed: is_negative || look.plus,
            has_point: decimals > 0 || look.ends_in_point,
        })
    }

    /// Writes the number and returns the length of its text.
    #[inline]
    fn write_to(self, room: &mut [u8; ROOM]) -> usize {
        let digits = digits_of(self.units);
        let significant = 8 - digits.trailing_zeros() / 8;
        let count = significant.max(u32::from(self.least));
        let digits = (digits | ZEROS) >> ((64 - 8 * count) & 63);
        let whole = (count - u32::from(self.decimals)) as usize & 15;
        let start = usize::from(self.is_signed);
        room[0] = self.sign;
        room[start..start + 8].copy_from_slice(&digits.to_le_bytes());
        room[start + whole] = b'.';
        // All eight digits may be before the point. A shift by 64 bits is not allowed.
        let fraction = (digits >> (4 * whole)) >> (4 * whole);
        room[start + whole + 1..start + whole + 9].copy_from_slice(&fraction.to_le_bytes());
        start + count as usize + usize::from(self.has_point)
    }
}

/// A row of text that is being written. Its room has a fixed length and is already at the end of the longer text, so
/// nothing is copied afterwards, and no piece asks whether the text must grow.
pub(super) struct Row<'a> {
    room: &'a mut [u8; ROW],
    length: usize,
}

/// Appends the row that `write` writes. If it gives `None`, nothing is appended and the answer is false.
#[inline]
pub(super) fn append_row(out: &mut Vec<u8>, write: impl FnOnce(&mut Row<'_>) -> Option<()>) -> bool {
    let start = out.len();
    out.resize(start + ROW, 0);
    let written = out.last_chunk_mut().and_then(|room| {
        let mut row = Row { room, length: 0 };
        write(&mut row)?;
        Some(row.length)
    });
    out.truncate(start + written.unwrap_or(0));
    written.is_some()
}

impl Row<'_> {
    /// Appends the bytes between two positions of a text; `None` if there is no room for them.
    #[inline]
    pub(super) fn push_piece(&mut self, text: &[u8], from: usize, to: usize) -> Option<()> {
        let piece = text.get(from..to).unwrap_or_default();
        self.room.get_mut(self.length..)?.get_mut(..piece.len())?.copy_from_slice(piece);
        self.length += piece.len();
        Some(())
    }

    /// Appends a number, and before it the bytes between two positions of a text; `None` if there is no room for them.
    #[inline]
    pub(super) fn push_word(
        &mut self,
        text: &[u8],
        from: usize,
        to: usize,
        number: ShortDecimal,
    ) -> Option<()> {
        let mut before = to.saturating_sub(from);
        let piece = text.get(from..).and_then(<[u8]>::first_chunk::<PIECE>);
        let piece = if let Some(piece) = piece.filter(|_| before <= PIECE) {
            piece
        } else {
            // A long piece, or one at the end of the text.
            self.push_piece(text, from, to)?;
            before = 0;
            &[0; PIECE]
        };
        let room: &mut [u8; PIECE + ROOM] = self.room.get_mut(self.length..)?.first_chunk_mut()?;
        room[..PIECE].copy_from_slice(piece);
        let length = number.write_to(room.get_mut(before..)?.first_chunk_mut()?);
        self.length += before + length;
        Some(())
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
            assert!(append_row(&mut out, |row| row.push_word(b"", 0, 0, number)));
            let text = plainly(value, decimals, look);
            assert_eq!(out[1..], text, "{value:?} with {decimals} decimals, {look:?}");
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
        for from in 0..=text.len() {
            for to in from..=text.len() {
                let (value, decimals) = (from as f64 / 8.0 - 3.0, u8::try_from(to % 8).unwrap());
                let number = ShortDecimal::of(value, decimals, Look::default()).unwrap();
                let printed = plainly(value, decimals, Look::default());
                for words in 0..6 {
                    let (mut quickly, mut plain) = (vec![7], vec![7]);
                    let fits = append_row(&mut quickly, |row| {
                        row.push_piece(&text, 0, words)?;
                        (0..words).try_for_each(|_| row.push_word(&text, from, to, number))
                    });
                    plain.extend_from_slice(&text[..words]);
                    (0..words).for_each(|_| plain.extend([&text[from..to], &printed].concat()));
                    assert_eq!(fits, quickly.len() > 1 || words == 0);
                    assert!(fits || plain.len() + PIECE + ROOM > ROW, "{} bytes have room", plain.len());
                    assert_eq!(quickly, if fits { plain } else { vec![7] });
                }
            }
        }
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
