//! Numbers with a sign, as they occur in statements: with a decimal comma, or with an exponent.

use crate::program::number::read_unsigned;

/// The longest number with a decimal comma or an exponent.
const MAX_NUMBER: usize = 64;

/// A number with its sign.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "independent facts about its spelling")]
pub(super) struct Number {
    pub(super) value: f64,
    pub(super) decimals: u8,
    pub(super) has_point: bool,
    pub(super) has_whole: bool,
    pub(super) has_comma: bool,
    pub(super) has_plus: bool,
    pub(super) end: usize,
}

impl Number {
    /// A value that represents text ending at `end`.
    pub(super) const fn standing_for(value: f64, end: usize) -> Self {
        Self { value, decimals: 0, has_point: false, has_whole: true, has_comma: false, has_plus: false, end }
    }
}

/// A number below 2²³ that distinguishes texts: FNV-1a, cut to the size that a number word can hold.
pub(super) fn fingerprint(text: impl Iterator<Item = u8>) -> f64 {
    let hash = text.fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    });
    #[expect(clippy::cast_precision_loss, reason = "23 bits")]
    let number = (hash >> 41) as f64;
    number
}

/// What a number may have besides digits, sign and point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Spelling {
    /// A decimal comma.
    Comma,
    /// An exponent: `1.5E-03`.
    Exponent,
}

/// Reads a number at `at`, including blanks after its sign; `None` if there is no number.
#[inline]
pub(super) fn number(text: &[u8], at: usize, spelling: Spelling) -> Option<Number> {
    let mut from = at;
    let negative = text.get(from) == Some(&b'-');
    if negative || text.get(from) == Some(&b'+') {
        from += 1;
        while matches!(text.get(from), Some(b' ' | b'\t')) {
            from += 1;
        }
    }
    let (read, has_comma) = match spelling {
        Spelling::Comma => match read_unsigned(text, from) {
            Some(read) if read.has_point || text.get(read.end) != Some(&b',') => (read, false),
            None if text.get(from) != Some(&b',') => return None,
            _ => (read_respelled(text, from, |byte| if byte == b',' { b'.' } else { byte })?, true),
        },
        Spelling::Exponent => (read_unsigned(text, from)?, false),
    };
    let mut number = Number {
        value: read.value,
        decimals: read.decimals,
        has_point: read.has_point,
        has_whole: read.has_whole,
        has_comma,
        has_plus: text.get(at) == Some(&b'+'),
        end: read.end,
    };
    if spelling == Spelling::Exponent && matches!(text.get(number.end), Some(b'E' | b'e' | b'D' | b'd')) {
        number = with_exponent(text, from, number)?;
    }
    // 0 − 0 is +0, so a negative zero never gets in.
    number.value = if negative { 0.0 - number.value } else { number.value };
    Some(number)
}

/// The number at `from`, read with some bytes replaced.
fn read_respelled(
    text: &[u8],
    from: usize,
    spell: impl Fn(u8) -> u8,
) -> Option<crate::program::number::Unsigned> {
    let mut buffer = [b' '; MAX_NUMBER + 8];
    for (slot, byte) in buffer.iter_mut().zip(text.get(from..)?).take(MAX_NUMBER) {
        *slot = spell(*byte);
    }
    let mut read = read_unsigned(&buffer, 0)?;
    read.end += from;
    Some(read)
}

/// The same number with the exponent after it. An exponent counts as the decimals that are needed to write the value
/// without it.
fn with_exponent(text: &[u8], from: usize, number: Number) -> Option<Number> {
    let mut end = number.end + 1;
    end += usize::from(matches!(text.get(end), Some(b'+' | b'-')));
    let digits = text.get(end..)?.iter().take_while(|byte| byte.is_ascii_digit()).count();
    if digits == 0 || end + digits - from > MAX_NUMBER {
        return None;
    }
    end += digits;
    let mut buffer = [0; MAX_NUMBER];
    let spelled = buffer.get_mut(..end - from)?;
    spelled.copy_from_slice(text.get(from..end)?);
    for byte in spelled.iter_mut().filter(|byte| matches!(byte, b'D' | b'd')) {
        *byte = b'e';
    }
    let spelled = std::str::from_utf8(spelled).ok()?;
    let exponent: i64 = spelled.get(number.end - from + 1..)?.parse().ok()?;
    let decimals = (i64::from(number.decimals) - exponent).clamp(0, 15);
    let value = spelled.parse::<f64>().ok()?;
    Some(Number { value, decimals: u8::try_from(decimals).unwrap_or(15), end, ..number })
}
