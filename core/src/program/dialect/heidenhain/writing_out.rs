//! What of a program's parameters can be left out when its loops and calls are written out.

use crate::program::dialect::WritingOut;
use crate::program::dialect::rules::without_comment;

/// The rules of conversational programs. Cycles use Q parameters.
pub(super) const RULES: WritingOut = WritingOut {
    names_value: |text, _| has_q(without_comment(text, b";")),
    is_own: |_, _| true,
    cycle: Some(b"CYCL"),
    places_have_signs: true,
    feed_keeps_point: false,
};

/// Whether a text has Q, QL, QR or QS with a number, also after a letter.
fn has_q(text: &[u8]) -> bool {
    text.iter().enumerate().any(|(at, byte)| {
        let rest = text.get(at + 1..).unwrap_or_default();
        let rest = match rest.first().map(u8::to_ascii_uppercase) {
            Some(b'L' | b'R' | b'S') => rest.get(1..).unwrap_or_default(),
            _ => rest,
        };
        byte.eq_ignore_ascii_case(&b'Q') && rest.first().is_some_and(u8::is_ascii_digit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::program::OwnNames;

    #[test]
    fn parameters_are_found_where_they_are_used() {
        for (text, named) in [
            ("L X+5 FMAX ; Q5", false),
            ("CYCL DEF 7.1 X+Q5", true),
            ("FN 0: QL1 = +5", true),
            ("RND RQ5", true),
            ("M128 FQL5", true),
        ] {
            assert_eq!((RULES.names_value)(text.as_bytes(), &OwnNames::default()), named, "{text}");
        }
    }
}
