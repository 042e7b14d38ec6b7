//! Finds stamps in a text, anywhere and in upper or lower case. Controls and transfers change the place and the case
//! of stamps, and cut them.

use super::{MACHINE, MARK, STEPS, Steps};
use crate::program::Excerpt;

/// The longest stamp that is searched for, from its mark to the word after its steps \[bytes\].
const MAX_HEAD_BYTES: usize = 256;
/// The bytes that may be between the mark and the version.
const SEPARATORS: &[u8] = b" \t_-/,:";
/// The count of numbers in a version.
const VERSION_NUMBERS: usize = 3;

/// What the stamps in a text state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Borne {
    /// The steps that the stamps name.
    pub steps: Steps,
    /// The beginning of the first stamp whose steps cannot be read, if there is one. In this case any step may have
    /// been done.
    pub unreadable: Option<Excerpt>,
}

impl Borne {
    /// Combines this with the stamps that come after it in the same text.
    fn and(self, others: Self) -> Self {
        Self { steps: self.steps.and(others.steps), unreadable: self.unreadable.or(others.unreadable) }
    }
}

/// What the stamps in a text state. A stamp is `Trunnion` with a version number after it.
#[must_use]
pub fn borne_by(text: &[u8]) -> Borne {
    borne_before(text, text.len())
}

/// The same for the stamps that begin before this byte of the text.
fn borne_before(text: &[u8], end: usize) -> Borne {
    let first = MARK.as_bytes().first().copied().unwrap_or_default();
    let starts = text.get(..end).unwrap_or(text);
    memchr::memchr2_iter(first.to_ascii_lowercase(), first.to_ascii_uppercase(), starts)
        .filter_map(|at| stamp_at(text.get(at..)?))
        .fold(Borne::default(), Borne::and)
}

/// What a stamp that begins here states, if there is one.
fn stamp_at(text: &[u8]) -> Option<Borne> {
    let mark = MARK.as_bytes();
    if !text.get(..mark.len())?.eq_ignore_ascii_case(mark) {
        return None;
    }
    let head = text.get(..MAX_HEAD_BYTES).unwrap_or(text);
    let end = memchr::memchr2(b'\n', b'\r', head).unwrap_or(head.len());
    let head = head.get(..end)?;
    let behind = after_version(head.get(mark.len()..)?)?;
    Some(match steps_in(&String::from_utf8_lossy(behind)) {
        Some(steps) => Borne { steps, unreadable: None },
        None => Borne { steps: Steps::NONE, unreadable: Some(Excerpt::new(head)) },
    })
}

/// The text after a version of three numbers, `0.2.0`, with or without a `v` before it and a suffix after it.
fn after_version(text: &[u8]) -> Option<&[u8]> {
    let blanks = text.iter().take_while(|byte| SEPARATORS.contains(byte)).count();
    let mut rest = text.get(blanks..)?;
    rest = rest.strip_prefix(b"v").or_else(|| rest.strip_prefix(b"V")).unwrap_or(rest);
    for number in 0..VERSION_NUMBERS {
        if number > 0 {
            rest = rest.strip_prefix(b".")?;
        }
        let digits = rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        rest = rest.get(digits..).filter(|_| digits > 0)?;
    }
    let suffix = rest.iter().take_while(|byte| !byte.is_ascii_whitespace()).count();
    rest.get(suffix..)
}

/// The steps in the text after the version: the operation, `steps`, their names, `machine`. Without the word after the
/// names, some names may have been cut off.
fn steps_in(text: &str) -> Option<Steps> {
    let mut words = text.split_ascii_whitespace();
    let is = |word: &str, wanted: &str| word.eq_ignore_ascii_case(wanted);
    words.next()?;
    words.next().filter(|word| is(word, STEPS))?;
    let mut names = String::new();
    loop {
        let word = words.next()?;
        if is(word, MACHINE) {
            return Steps::from_names(&names);
        }
        names.push_str(word);
        names.push(' ');
    }
}

/// Searches for stamps in a text that comes in pieces.
#[derive(Debug, Default)]
pub struct StampFinder {
    /// The last bytes. A stamp may begin in them and continue in the next piece.
    rest: Vec<u8>,
    borne: Borne,
}

impl StampFinder {
    /// Continues with a piece of the text.
    pub fn see(&mut self, piece: &[u8]) {
        self.rest.extend_from_slice(piece);
        let whole = self.rest.len().saturating_sub(MAX_HEAD_BYTES - 1);
        self.borne = self.borne.and(borne_before(&self.rest, whole));
        self.rest.drain(..whole);
    }

    /// The statements of the stamps that are complete up to here.
    #[must_use]
    pub fn so_far(&self) -> Borne {
        self.borne
    }

    /// Ends the text and returns what its stamps state.
    #[must_use]
    pub fn finish(self) -> Borne {
        self.borne.and(borne_by(&self.rest))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Stamp, StepName};
    use super::*;

    fn stamp() -> Stamp {
        Stamp {
            version: "0.2.0".to_owned(),
            operation: "compensation".to_owned(),
            steps: Steps::of(&[StepName::Cc, StepName::Wear]),
            machine: "dmu-80".to_owned(),
            revision: 3,
            tool: Some("BALL (10)".to_owned()),
            source: "0a1b2c3d4e5f6789".to_owned(),
            parameters: "9f8e7d6c5b4a3928".to_owned(),
        }
    }

    #[test]
    fn a_stamp_says_what_the_contract_says() {
        let expected = "Trunnion 0.2.0 compensation steps wear,cc machine dmu-80 revision 3 tool BALL__10_ source 0a1b2c3d4e5f6789 parameters 9f8e7d6c5b4a3928";
        assert_eq!(stamp().to_string(), expected);
        let without = Stamp { tool: None, steps: Steps::of(&[StepName::LocationErrors]), ..stamp() };
        assert!(without.to_string().contains(" steps location_errors machine dmu-80 revision 3 source 0a1b"));
    }

    #[test]
    fn stamps_are_found_in_any_comment_and_letters_of_any_size_and_nothing_else_is_one() {
        let both = Steps::of(&[StepName::Wear, StepName::Cc]);
        for text in [
            format!("%\nO1\n({})\nG0 X0\n", stamp()),
            format!("; {}\r\n", stamp().to_string().to_uppercase()),
            format!("0 BEGIN PGM A MM\n;{}", stamp().to_string().to_lowercase()),
            format!("T T Trunnion {}", stamp()),
            "(Trunnion 0.2.0 compensation steps wear, cc machine a)".to_owned(),
            "(Trunnion 0.2.0-rc.1 compensation steps cc ,wear machine a)".to_owned(),
            "(Trunnion 0.2.0 a steps cc machine b)\n(Trunnion 0.2.0 c steps wear machine b)".to_owned(),
        ] {
            assert_eq!(borne_by(text.as_bytes()), Borne { steps: both, unreadable: None }, "{text}");
        }
        for text in [
            "(Trunnion)",
            "(TRUNNION TABLE 160)",
            "(TRUNNION 5.2 MM LOWER)",
            "(TR160 TRUNNION, REV 3)",
            "(Trunnion\n0.2.0 compensation steps cc machine a)",
            "Trunnio",
        ] {
            assert_eq!(borne_by(text.as_bytes()), Borne::default(), "{text}");
        }
    }

    #[test]
    fn a_stamp_whose_steps_cannot_be_read_completely_is_one_all_the_same() {
        for text in [
            "(Trunnion 0.2.0 wear-compensatio)",
            "(Trunnion 0.2.0)",
            "(Trunnion 0.2.0 wear-compensation steps wear,lo",
            "(Trunnion 0.2.0 compensation steps wear)",
            "(Trunnion 0.2.0 compensation steps cc wear machine a)",
            "(Trunnion 0.2.0 compensation steps  machine a)",
            "(Trunnion 0.2.0 compensation steps cc,polish machine a)",
            "(Trunnion 0.2.0 compensation steps cc\nmachine a)",
            "(Trunnion 0.2.0 wear machine a)",
            "(TRUNNION0.2.0WEAR-COMPENSATION)",
            "; made by Trunnion v0.2.0",
            "(Trunnion_0_2_0 steps)(Trunnion 10.20.30 x",
        ] {
            let borne = borne_by(text.as_bytes());
            assert_eq!(borne.steps, Steps::NONE, "{text}");
            let excerpt = borne.unreadable.map(|text| text.to_string()).unwrap_or_default();
            assert!(!excerpt.is_empty() && text.contains(&excerpt), "{text}: {excerpt}");
        }
        // A readable stamp does not make up for an unreadable one.
        let text = format!("({})\n(Trunnion 0.2.0 wear-co)", stamp());
        let borne = borne_by(text.as_bytes());
        assert_eq!(borne.steps, stamp().steps);
        assert_eq!(borne.unreadable.map(|text| text.to_string()).as_deref(), Some("Trunnion 0.2.0 wear-co)"));
    }

    #[test]
    fn a_stamp_is_found_however_the_text_is_cut() {
        let text = format!("{}({}){}", "G0 X1\n".repeat(90), stamp(), "\nG1 X2 T3".repeat(60));
        let at_the_end = format!("{}({})", "G0 X1\n".repeat(90), stamp());
        for text in [text, at_the_end] {
            for size in [1, 7, 100, 255, 256, 257, 560, 600, 5000] {
                let mut finder = StampFinder::default();
                text.as_bytes().chunks(size).for_each(|piece| finder.see(piece));
                let expected = Borne { steps: stamp().steps, unreadable: None };
                assert_eq!(finder.finish(), expected, "pieces of {size}");
            }
        }
    }
}
