//! Client texts in tables that people open in a spreadsheet.

use std::borrow::Cow;

/// The text as a cell that no spreadsheet takes for a formula. A text that begins like a formula gets an
/// apostrophe in front, which spreadsheets do not show.
#[must_use]
pub(super) fn table_text(text: &str) -> Cow<'_, str> {
    match text.chars().next() {
        Some('=' | '+' | '-' | '@' | '\t' | '\r' | '\n' | '＝' | '＋' | '－' | '＠') => {
            format!("'{text}").into()
        }
        _ => text.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_begins_as_a_formula_is_shown_as_text() {
        for formula in ["=1+1", "+1", "-1", "@sum(a1)", "\t=1", "\r=1", "=HYPERLINK(\"http://x\")", "＝1"] {
            assert_eq!(table_text(formula), format!("'{formula}"));
        }
        for text in ["", "1", "edge 2", "a=b", "'=1"] {
            assert_eq!(table_text(text), text);
        }
    }
}
