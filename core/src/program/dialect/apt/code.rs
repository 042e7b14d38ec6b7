//! Blocks for a control that a statement carries unchanged (`INSERT`, `PREFUN/`), and which of them move nothing.

use crate::program::dialect::number::{Spelling, number};

/// G codes that move nothing and leave units, offsets and the sense of words and feeds as cutter location data has
/// them.
const HARMLESS_CODES: [f64; 9] = [4.0, 9.0, 17.0, 40.0, 61.0, 64.0, 80.0, 90.0, 94.0];

/// Whether a G code's number is that of a harmless code.
pub(super) fn is_harmless_number(text: &[u8]) -> bool {
    let code = number(text, 0, Spelling::Exponent).map(|number| number.value);
    code.is_some_and(|code| HARMLESS_CODES.iter().any(|known| (code - known).abs() < 1e-9))
}

/// Whether the text is for people, as in `Stock Size X95. Y150. Z120.`. Such a text has at least two words of only
/// letters. No block of a program for a control has these together with axis words.
fn is_prose(text: &[u8]) -> bool {
    let words = text.split(|byte| !byte.is_ascii_alphanumeric());
    words.filter(|word| word.len() > 1 && word.iter().all(u8::is_ascii_alphabetic)).nth(1).is_some()
}

/// Whether code that the posted program takes unchanged moves no axis and calls nothing. Comments between round
/// brackets do not count. They end at the first `)`, because some controls end the comment there and may run the text
/// after it.
pub(super) fn is_harmless_code(text: &[u8]) -> bool {
    if is_prose(text) {
        return true;
    }
    let mut in_comment = false;
    for (at, byte) in text.iter().enumerate() {
        match byte {
            b'(' => in_comment = true,
            b')' => in_comment = false,
            _ => {}
        }
        let before = at.checked_sub(1).and_then(|before| text.get(before));
        if in_comment || before.is_some_and(u8::is_ascii_alphabetic) {
            continue;
        }
        let value = text.get(at + 1..).unwrap_or_default().trim_ascii_start();
        let has_value = value.first().is_some_and(|byte| {
            byte.is_ascii_digit() || matches!(byte, b'-' | b'+' | b'.' | b'#' | b'=' | b'[')
        });
        let moves = match byte.to_ascii_uppercase() {
            _ if !has_value => false,
            b'X' | b'Y' | b'Z' | b'A' | b'B' | b'C' | b'U' | b'V' | b'W' => true,
            b'G' => !is_harmless_number(value),
            b'M' => number(value, 0, Spelling::Exponent)
                .is_none_or(|number| [96.0, 97.0, 98.0, 99.0, 198.0].contains(&number.value)),
            _ => false,
        };
        if moves {
            return false;
        }
    }
    true
}
