//! Whether a block names a parameter or a variable. A text that is written out has numbers in their place.

use std::collections::BTreeSet;

use crate::program::Dialect;

/// The variables that a program has set so far, in upper case.
#[derive(Debug, Default)]
pub(super) struct Variables(BTreeSet<Vec<u8>>);

impl Variables {
    /// Notes the names that an assignment or a declaration gives values to.
    pub(super) fn note(&mut self, text: &[u8]) {
        let is_declaration = text.get(..3).is_some_and(|word| word.eq_ignore_ascii_case(b"DEF"));
        let set = if is_declaration { text } else { text.split(|byte| *byte == b'=').next().unwrap_or(text) };
        self.0.extend(names(set));
    }

    /// Whether a block names one of them, or a parameter by its number.
    pub(super) fn are_named_in(&self, dialect: Dialect, text: &[u8]) -> bool {
        let code = code(dialect, text);
        match dialect {
            Dialect::Iso => code.contains(&b'#'),
            Dialect::Heidenhain => names(code).any(|name| is_numbered(&name, b'Q')),
            Dialect::Siemens => names(code).any(|name| is_numbered(&name, b'R') || self.0.contains(&name)),
            Dialect::Apt | Dialect::Csv | Dialect::Okuma => false,
        }
    }
}

/// A block without its comments.
fn code(dialect: Dialect, text: &[u8]) -> &[u8] {
    let mark = if dialect == Dialect::Iso { b'(' } else { b';' };
    let end = memchr::memchr2(mark, b';', text).unwrap_or(text.len());
    text.get(..end).unwrap_or_default()
}

/// The names of a text that begin with a letter or `_`, without those in quotation marks.
fn names(text: &[u8]) -> impl Iterator<Item = Vec<u8>> {
    let outside = text.split(|byte| *byte == b'"').step_by(2);
    let is_name = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    let words = outside.flat_map(move |part| part.split(move |byte| !is_name(byte)));
    words
        .filter(|word| word.first().is_some_and(|first| !first.is_ascii_digit()))
        .map(<[u8]>::to_ascii_uppercase)
}

/// `R5`, `Q5`, `QL5`.
fn is_numbered(name: &[u8], letter: u8) -> bool {
    let [first, rest @ ..] = name else { return false };
    let digits = match rest {
        [b'L' | b'R' | b'S', digits @ ..] if letter == b'Q' => digits,
        digits => digits,
    };
    *first == letter && !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_and_variables_are_found_where_they_are_used() {
        let mut variables = Variables::default();
        variables.note(b"DEF REAL DEPTH=5");
        variables.note(b"_WIDTH = COS(5)");
        for (dialect, text, named) in [
            (Dialect::Iso, "G1 X5. (#1)", false),
            (Dialect::Iso, "G65 P1 A#1", true),
            (Dialect::Heidenhain, "L X+5 FMAX ; Q5", false),
            (Dialect::Heidenhain, "CYCL DEF 7.1 X+Q5", true),
            (Dialect::Heidenhain, "FN 0: QL1 = +5", true),
            (Dialect::Siemens, "G1 X5 RND=2 CR=5", false),
            (Dialect::Siemens, "CYCLE832(R5)", true),
            (Dialect::Siemens, "CYCLE832(depth,1)", true),
            (Dialect::Siemens, "X=COS(5)", false),
            (Dialect::Siemens, "CYCLE832(_width,1)", true),
            (Dialect::Siemens, "MSG(\"DEPTH\")", false),
        ] {
            assert_eq!(variables.are_named_in(dialect, text.as_bytes()), named, "{text}");
        }
    }
}
