//! The names to which a program gives values.

use std::collections::BTreeSet;

/// The variables that a program has declared or set so far, in upper case.
#[derive(Debug, Default)]
pub struct OwnNames {
    set: BTreeSet<Vec<u8>>,
    declared: BTreeSet<Vec<u8>>,
}

impl OwnNames {
    /// Notes the names to which an assignment or a declaration (`DEF`) gives values.
    pub fn note(&mut self, text: &[u8]) {
        let is_declaration = text.get(..3).is_some_and(|word| word.eq_ignore_ascii_case(b"DEF"));
        let set = if is_declaration { text } else { text.split(|byte| *byte == b'=').next().unwrap_or(text) };
        self.set.extend(names(set));
        if is_declaration {
            self.declared.extend(names(text));
        }
    }

    /// Whether the program has set a name or declared it.
    pub(super) fn has(&self, name: &[u8]) -> bool {
        self.set.contains(name)
    }

    /// Whether the program has declared a name.
    pub(super) fn declares(&self, name: &[u8]) -> bool {
        self.declared.contains(name)
    }
}

/// The names of a text that begin with a letter or `_`, without those in quotation marks.
pub(super) fn names(text: &[u8]) -> impl Iterator<Item = Vec<u8>> {
    let outside = text.split(|byte| *byte == b'"').step_by(2);
    let is_name = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
    let words = outside.flat_map(move |part| part.split(move |byte| !is_name(byte)));
    words
        .filter(|word| word.first().is_some_and(|first| !first.is_ascii_digit()))
        .map(<[u8]>::to_ascii_uppercase)
}
