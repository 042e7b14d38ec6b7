//! What of a program's parameters can be left out when its loops and calls are written out.

use crate::program::OwnNames;
use crate::program::dialect::WritingOut;
use crate::program::dialect::rules::without_comment;

/// The rules of ISO programs.
pub(super) const RULES: WritingOut = WritingOut {
    names_value: |text, _| without_comment(text, b"(;").contains(&b'#'),
    is_own,
    feed_keeps_point: true,
    ..WritingOut::PLAIN
};

/// Whether all targets of an assignment are parameters that only programs use: not alarms, messages and values of the
/// control, and not a number that is computed.
fn is_own(text: &[u8], _: &OwnNames) -> bool {
    let targets = without_comment(text, b"(;").split(|byte| *byte == b'=').rev().skip(1);
    targets.into_iter().all(|before| is_common(before.trim_ascii_end()))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_of_programs_are_told_from_values_of_the_control() {
        let own = OwnNames::default();
        for (text, is_own) in [
            ("N5 #1=3 #<depth> = [#1+1] (a=b)", true),
            ("#3000=1 (WRONG PART)", false),
            ("#[3000]=1", false),
            ("##2=1", false),
            ("#<_hal[x]>=5", false),
        ] {
            assert_eq!((RULES.is_own)(text.as_bytes(), &own), is_own, "{text}");
        }
        for (text, named) in [("G1 X5. (#1)", false), ("G65 P1 A#1", true)] {
            assert_eq!((RULES.names_value)(text.as_bytes(), &own), named, "{text}");
        }
    }
}
