//! Names that people read on a screen and type at a control.

/// Whether people can read every character of a name: no control character, no invisible character, no blank
/// other than the space, and no space at either end.
pub(super) fn is_printable(name: &str) -> bool {
    // The printable characters of Unicode are those that Rust writes unescaped, and three more that Rust
    // escapes.
    let shows = |letter: char| "\"'\\".contains(letter) || letter.escape_debug().len() == 1;
    name.trim() == name && name.chars().all(shows)
}

#[cfg(test)]
mod tests {
    use super::is_printable;

    #[test]
    fn a_name_that_can_be_read_is_printable_and_no_other() {
        for name in ["", "BALL_10", "Kugel Ø 10", "G54.1 P3", "\"x\"", "a'b\\c", "刀具 7"] {
            assert!(is_printable(name), "{name:?}");
        }
        let invisible = ["a\nb", "\u{7f}", "a\u{200b}b", "\u{feff}a", "a\u{a0}b", "a\u{202e}b", "\u{e000}"];
        for name in invisible.into_iter().chain([" a", "a ", "\t"]) {
            assert!(!is_printable(name), "{name:?}");
        }
    }
}
