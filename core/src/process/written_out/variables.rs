//! Whether a block names a parameter or a variable. A text that is written out has numbers in their place.

use std::collections::BTreeSet;

use crate::program::Dialect;

/// The variables that a program has declared or set so far, in upper case.
#[derive(Debug, Default)]
pub(super) struct Variables {
    set: BTreeSet<Vec<u8>>,
    declared: BTreeSet<Vec<u8>>,
}

impl Variables {
    /// Notes the names that an assignment or a declaration of a Sinumerik program gives values to.
    pub(super) fn note(&mut self, text: &[u8]) {
        let is_declaration = text.get(..3).is_some_and(|word| word.eq_ignore_ascii_case(b"DEF"));
        let set = if is_declaration { text } else { text.split(|byte| *byte == b'=').next().unwrap_or(text) };
        self.set.extend(names(set));
        if is_declaration {
            self.declared.extend(names(text));
        }
    }

    /// Whether an assignment can be left out: nothing but the program itself uses its target.
    pub(super) fn are_own(&self, dialect: Dialect, text: &[u8]) -> bool {
        let code = code(dialect, text);
        let targets = code.split(|byte| *byte == b'=').rev().skip(1);
        match dialect {
            // Not alarms, messages and values of the control, and not a number that is computed.
            Dialect::Iso => targets.into_iter().all(|before| is_common(before.trim_ascii_end())),
            Dialect::Siemens => {
                let target = names(code.split(|byte| *byte == b'=').next().unwrap_or(code)).last();
                let is_known = |name: &Vec<u8>| is_numbered(name, b'R') || self.declared.contains(name);
                let is_declaration = names(code).any(|name| name == b"DEF");
                is_declaration || target.is_some_and(|name| is_known(&name))
            }
            Dialect::Heidenhain => true,
            Dialect::Apt | Dialect::Csv | Dialect::Okuma => false,
        }
    }

    /// Whether a block names one of them, a parameter by its number, or a value of the control.
    pub(super) fn are_named_in(&self, dialect: Dialect, text: &[u8]) -> bool {
        let code = code(dialect, text);
        match dialect {
            Dialect::Iso => code.contains(&b'#'),
            Dialect::Heidenhain => has_q(code),
            Dialect::Siemens => {
                let by_index = code.iter().enumerate().any(|(at, byte)| {
                    let before = at.checked_sub(1).and_then(|at| code.get(at));
                    let is_word =
                        before.is_none_or(|before| !before.is_ascii_alphanumeric() && *before != b'_');
                    let rest = code.get(at + 1..).unwrap_or_default().trim_ascii_start();
                    byte.eq_ignore_ascii_case(&b'R') && is_word && rest.first() == Some(&b'[')
                });
                let is_named = |name: &Vec<u8>| is_numbered(name, b'R') || self.set.contains(name);
                by_index || code.contains(&b'$') || names(code).any(|name| is_named(&name))
            }
            Dialect::Apt | Dialect::Csv | Dialect::Okuma => false,
        }
    }
}

/// Whether a text ends with `#12`, a parameter below 1000, or with `#<name>` that is no name of the control.
fn is_common(text: &[u8]) -> bool {
    if let Some(rest) = text.strip_suffix(b">") {
        let name = memchr::memrchr(b'<', rest).and_then(|at| Some((rest.get(..at)?, rest.get(at + 1..)?)));
        return name.is_some_and(|(before, name)| before.ends_with(b"#") && name.first() != Some(&b'_'));
    }
    let digits = text.iter().rev().take_while(|byte| byte.is_ascii_digit()).count();
    let (before, digits) = text.split_at(text.len() - digits);
    before.ends_with(b"#") && !before.ends_with(b"##") && (1..=3).contains(&digits.len())
}

/// Whether a text has Q, QL, QR or QS with a number, also behind a letter.
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

/// `R5`.
fn is_numbered(name: &[u8], letter: u8) -> bool {
    matches!(name, [first, digits @ ..] if *first == letter && !digits.is_empty() && digits.iter().all(u8::is_ascii_digit))
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
            (Dialect::Heidenhain, "RND RQ5", true),
            (Dialect::Heidenhain, "M128 FQL5", true),
            (Dialect::Siemens, "CYCLE81(R [7],2)", true),
            (Dialect::Siemens, "X=$AA_IM[X]", true),
            (Dialect::Siemens, "G1 X5 RND=2 CR=5 AR[2]", false),
            (Dialect::Siemens, "CYCLE832(R5)", true),
            (Dialect::Siemens, "CYCLE832(depth,1)", true),
            (Dialect::Siemens, "X=COS(5)", false),
            (Dialect::Siemens, "CYCLE832(_width,1)", true),
            (Dialect::Siemens, "MSG(\"DEPTH\")", false),
        ] {
            assert_eq!(variables.are_named_in(dialect, text.as_bytes()), named, "{text}");
        }
    }

    #[test]
    fn an_assignment_is_left_out_only_if_nothing_else_uses_it() {
        let mut variables = Variables::default();
        variables.note(b"DEF REAL DEPTH=5");
        for (dialect, text, own) in [
            (Dialect::Iso, "N5 #1=3 #<depth> = [#1+1] (a=b)", true),
            (Dialect::Iso, "#3000=1 (WRONG PART)", false),
            (Dialect::Iso, "#[3000]=1", false),
            (Dialect::Iso, "##2=1", false),
            (Dialect::Iso, "#<_hal[x]>=5", false),
            (Dialect::Siemens, "R1=R2+1", true),
            (Dialect::Siemens, "N10 DEPTH=3", true),
            (Dialect::Siemens, "DEF INT N", true),
            (Dialect::Siemens, "_ZSD[1]=1", false),
        ] {
            assert_eq!(variables.are_own(dialect, text.as_bytes()), own, "{text}");
        }
    }
}
