//! Where lines end: at LF, CR LF or CR.

/// Start of the ending of the line that has byte `from`; the end of the text if the line has no ending.
#[inline]
pub(super) fn line_end(text: &[u8], from: usize) -> usize {
    let rest = text.get(from..).unwrap_or_default();
    from + memchr::memchr2(b'\n', b'\r', rest).unwrap_or(rest.len())
}

/// Start of the next line, after the ending at `line_end`.
#[inline]
pub(super) fn next_line(text: &[u8], line_end: usize) -> usize {
    match (text.get(line_end), text.get(line_end + 1)) {
        (None, _) => line_end,
        (Some(b'\r'), Some(b'\n')) => line_end + 2,
        _ => line_end + 1,
    }
}

/// Whether a line shows no text: blanks and control bytes that tapes, printers and old systems leave.
#[inline]
pub(super) fn is_blank(line: &[u8]) -> bool {
    line.iter().all(|byte| *byte <= b' ' || *byte == 0x7f)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_at_any_of_the_three_endings_or_with_the_text() {
        let text = b"a\r\nb\rc\n\nd";
        let mut lines = Vec::new();
        let mut at = 0;
        while at < text.len() {
            let end = line_end(text, at);
            lines.push(&text[at..end]);
            at = next_line(text, end);
        }
        assert_eq!(lines, [&b"a"[..], b"b", b"c", b"", b"d"]);
    }
}
