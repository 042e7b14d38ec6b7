//! What of a program's variables can be left out when its loops and calls are written out.

use crate::program::OwnNames;
use crate::program::dialect::WritingOut;
use crate::program::dialect::rules::without_comment;
use crate::program::own_names::names;

/// The rules of Sinumerik programs.
pub(super) const RULES: WritingOut = WritingOut { names_value, is_own, ..WritingOut::PLAIN };

/// Whether a block names an R parameter, a variable of the program or a value of the control.
fn names_value(text: &[u8], own: &OwnNames) -> bool {
    let code = without_comment(text, b";");
    let by_index = code.iter().enumerate().any(|(at, byte)| {
        let before = at.checked_sub(1).and_then(|at| code.get(at));
        let is_word = before.is_none_or(|before| !before.is_ascii_alphanumeric() && *before != b'_');
        let rest = code.get(at + 1..).unwrap_or_default().trim_ascii_start();
        byte.eq_ignore_ascii_case(&b'R') && is_word && rest.first() == Some(&b'[')
    });
    by_index || code.contains(&b'$') || names(code).any(|name| is_parameter(&name) || own.has(&name))
}

/// Whether an assignment sets an R parameter or a variable that the program declares. Others belong to the control.
fn is_own(text: &[u8], own: &OwnNames) -> bool {
    let code = without_comment(text, b";");
    let target = names(code.split(|byte| *byte == b'=').next().unwrap_or(code)).last();
    names(code).any(|name| name == b"DEF")
        || target.is_some_and(|name| is_parameter(&name) || own.declares(&name))
}

/// `R5`.
fn is_parameter(name: &[u8]) -> bool {
    matches!(name, [b'R', digits @ ..] if !digits.is_empty() && digits.iter().all(u8::is_ascii_digit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_are_found_where_they_are_used_and_told_from_those_of_the_control() {
        let mut own = OwnNames::default();
        own.note(b"DEF REAL DEPTH=5");
        own.note(b"_WIDTH = COS(5)");
        for (text, named) in [
            ("G1 X5 RND=2 CR=5 AR[2]", false),
            ("X=COS(5)", false),
            ("MSG(\"DEPTH\")", false),
            ("CYCLE832(R5)", true),
            ("CYCLE832(depth,1)", true),
            ("CYCLE832(_width,1)", true),
            ("CYCLE81(R [7],2)", true),
            ("X=$AA_IM[X]", true),
        ] {
            assert_eq!(names_value(text.as_bytes(), &own), named, "{text}");
        }
        for (text, found) in
            [("R1=R2+1", true), ("N10 DEPTH=3", true), ("DEF INT N", true), ("_ZSD[1]=1", false)]
        {
            assert_eq!(is_own(text.as_bytes(), &own), found, "{text}");
        }
    }
}
