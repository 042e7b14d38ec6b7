//! Comments between round brackets. Some controls end a comment at its first `)`, others at the `)` that closes its
//! first `(`. If a comment contains brackets, these two are different.

use super::number::read_unsigned;

/// A longer comment with brackets in it ends at its first `)`. No control takes a block of this length, and the limit
/// keeps the reader from searching a line again and again [bytes].
const MAX_NESTED_BYTES: usize = 1024;
/// Words that do nothing by themselves and occur in comments: `D10`, `R5`.
const IDLE: &[u8] = b"DLNPQR";

/// The end of the comment that begins at the `(` at `at`: one after its `)`, or the line end if it is not closed.
///
/// If a comment contains brackets that are all closed on its line, it is one comment up to its last bracket, within
/// [`MAX_NESTED_BYTES`]. Other brackets within a comment are text, and it ends at its first `)`.
///
/// # Errors
/// The text between the first `)` and the last bracket reads as words that move or set something. A control that ends
/// the comment at the first `)` executes them; other controls do not.
pub(super) fn comment_end(text: &[u8], at: usize) -> Result<usize, AmbiguousComment> {
    let rest = text.get(at..).unwrap_or_default();
    let first = match memchr::memchr3(b')', b'\n', b'\r', rest) {
        Some(length) if rest.get(length) == Some(&b')') => length,
        Some(length) => return Ok(at + length),
        None => return Ok(at + rest.len()),
    };
    let inner = rest.get(1..first).unwrap_or_default();
    if memchr::memchr(b'(', inner).is_none() {
        return Ok(at + first + 1);
    }
    let Some(last) = closing_bracket(rest.get(..MAX_NESTED_BYTES).unwrap_or(rest)) else {
        return Ok(at + first + 1);
    };
    if commands(rest.get(first + 1..last).unwrap_or_default()) {
        return Err(AmbiguousComment);
    }
    Ok(at + last + 1)
}

/// Some controls end this comment before words that act.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct AmbiguousComment;

/// The position of the `)` that closes the `(` at the beginning of the text; `None` if no bracket on the line closes
/// it.
fn closing_bracket(text: &[u8]) -> Option<usize> {
    let mut depth = 0_usize;
    for (at, byte) in text.iter().enumerate() {
        match byte {
            b'(' => depth += 1,
            b')' if depth <= 1 => return Some(at),
            b')' => depth -= 1,
            b'\n' | b'\r' => return None,
            _ => {}
        }
    }
    None
}

/// Whether a text reads as words of which at least one moves or sets something. Comments end at their first `)` here.
fn commands(text: &[u8]) -> bool {
    let mut commands = false;
    let mut at = 0;
    while let Some(&byte) = text.get(at) {
        match byte {
            b'(' => {
                let rest = text.get(at..).unwrap_or_default();
                at += memchr::memchr(b')', rest).map_or(rest.len(), |length| length + 1);
            }
            b';' => break,
            // The closing bracket of a comment that has ended.
            b')' | b'/' => at += 1,
            byte if byte <= b' ' || byte == 0x7f => at += 1,
            // A parameter is set, whatever follows.
            b'#' => return true,
            byte if byte.is_ascii_alphabetic() => {
                let Some(end) = value_end(text, at + 1) else { return false };
                commands |= !IDLE.contains(&byte.to_ascii_uppercase());
                at = end;
            }
            _ => return false,
        }
    }
    commands
}

/// One after the number, parameter or expression at `from`.
fn value_end(text: &[u8], from: usize) -> Option<usize> {
    let blanks = |mut at: usize| {
        while matches!(text.get(at), Some(b' ' | b'\t')) {
            at += 1;
        }
        at
    };
    let mut at = blanks(from);
    while matches!(text.get(at), Some(b'+' | b'-')) {
        at = blanks(at + 1);
    }
    match text.get(at)? {
        // Its value does not matter, because comments for people have no parameters or expressions.
        b'#' | b'[' => Some(text.len()),
        _ => read_unsigned(text, at).map(|number| number.end),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn rest_behind(line: &str) -> Result<&str, AmbiguousComment> {
        comment_end(line.as_bytes(), 0).map(|end| &line[end..])
    }

    #[test]
    fn a_comment_ends_at_its_bracket_or_with_its_line() {
        assert_eq!(rest_behind("(BALL) X1"), Ok(" X1"));
        assert_eq!(rest_behind("() X1"), Ok(" X1"));
        assert_eq!(rest_behind("(BALL X1\nY1)"), Ok("\nY1)"));
        assert_eq!(rest_behind("(BALL X1"), Ok(""));
    }

    #[test]
    fn brackets_that_are_closed_belong_to_their_comment() {
        assert_eq!(rest_behind("(T1 (BALL) 10MM) G1 X5"), Ok(" G1 X5"));
        assert_eq!(rest_behind("((A)) X1"), Ok(" X1"));
        assert_eq!(rest_behind("(A (B (C) D) E) (F) X1"), Ok(" (F) X1"));
        // The radius of a cutter does not move anything.
        assert_eq!(rest_behind("(NOSE (D10) R5) X1"), Ok(" X1"));
        assert_eq!(rest_behind("(CUT (OLD) 5 TIMES, G1 X5 TOO) X1"), Ok(" X1"));
    }

    #[test]
    fn brackets_that_are_not_closed_are_text() {
        assert_eq!(rest_behind("(TOOL (BALL) X1"), Ok(" X1"));
        assert_eq!(rest_behind("(TOOL (BALL) X1\n)"), Ok(" X1\n)"));
    }

    #[test]
    fn a_line_of_brackets_is_looked_through_once() {
        let line = "((a)".repeat(1 << 16);
        let mut at = 0;
        while at < line.len() {
            at = comment_end(line.as_bytes(), at).unwrap();
        }
        let long = format!("(A (B) {}) X1", "C".repeat(MAX_NESTED_BYTES));
        assert_eq!(rest_behind(&long), Ok(&long[6..]));
    }

    #[test]
    fn words_that_some_controls_run_are_never_lost() {
        for line in [
            "(OLD (Z5) G1 X10)",
            "(OLD (Z5) G1 X10 ;)",
            "(OLD (Z5) M3)",
            "(OLD (Z5) F 100.)",
            "(OLD (Z5) X-[#1+2])",
            "(OLD (Z5) #100=5)",
            "(OLD (Z5) T5 (BALL) M6)",
            "(OLD ((Z5) X1) D5)",
        ] {
            assert_eq!(rest_behind(line), Err(AmbiguousComment), "{line}");
        }
    }
}
