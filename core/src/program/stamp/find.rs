//! Stamps found in a text, wherever they stand and in letters of any size: controls and transfers change both.

use super::{MACHINE, MARK, STEPS, Steps};

/// Longest stamp that is looked for, from its mark to the word after its steps \[bytes\].
const MAX_HEAD_BYTES: usize = 256;

/// The steps that the stamps in a text name. A stamp that begins in the last bytes may not be whole yet.
#[must_use]
pub fn borne_by(text: &[u8]) -> Steps {
    let mark = MARK.as_bytes();
    let first = [mark[0].to_ascii_lowercase(), mark[0].to_ascii_uppercase()];
    memchr::memchr2_iter(first[0], first[1], text).fold(Steps::NONE, |steps, at| {
        let starts = text.get(at..at + mark.len()).is_some_and(|word| word.eq_ignore_ascii_case(mark));
        if starts { steps.and(steps_at(&text[at..]).unwrap_or_default()) } else { steps }
    })
}

/// The steps of a stamp that begins here, if one does.
fn steps_at(text: &[u8]) -> Option<Steps> {
    let head = text.get(..MAX_HEAD_BYTES).unwrap_or(text);
    let end = memchr::memchr2(b'\n', b'\r', head).unwrap_or(head.len());
    let head = String::from_utf8_lossy(&head[..end]);
    let mut words = head.split_ascii_whitespace();
    let is = |word: Option<&str>, wanted: &str| word.is_some_and(|word| word.eq_ignore_ascii_case(wanted));
    if !is(words.next(), MARK) {
        return None;
    }
    // Version and operation.
    words.next()?;
    words.next()?;
    if !is(words.next(), STEPS) {
        return None;
    }
    let steps = Steps::from_names(words.next()?)?;
    is(words.next(), MACHINE).then_some(steps)
}

/// Looks for stamps in a text that comes in pieces.
#[derive(Debug, Default)]
pub struct StampFinder {
    /// The last bytes, in which a stamp may begin that goes on in the next piece.
    tail: Vec<u8>,
    steps: Steps,
}

impl StampFinder {
    /// Goes on with a piece of the text.
    pub fn see(&mut self, piece: &[u8]) {
        self.steps = self.steps.and(borne_by(piece));
        if piece.len() < MAX_HEAD_BYTES {
            self.tail.extend_from_slice(piece);
            self.steps = self.steps.and(borne_by(&self.tail));
        } else {
            self.tail.extend_from_slice(&piece[..MAX_HEAD_BYTES]);
            self.steps = self.steps.and(borne_by(&self.tail));
            self.tail.clear();
            self.tail.extend_from_slice(&piece[piece.len() - MAX_HEAD_BYTES..]);
        }
        let surplus = self.tail.len().saturating_sub(MAX_HEAD_BYTES);
        self.tail.drain(..surplus);
    }

    /// The steps named so far.
    #[must_use]
    pub fn steps(&self) -> Steps {
        self.steps
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Stamp, Step};
    use super::*;

    fn stamp() -> Stamp {
        Stamp {
            version: "0.2.0".to_owned(),
            operation: "compensation".to_owned(),
            steps: Steps::of(&[Step::Cc, Step::Wear]),
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
        let without = Stamp { tool: None, steps: Steps::of(&[Step::LocationErrors]), ..stamp() };
        assert!(without.to_string().contains(" steps location_errors machine dmu-80 revision 3 source 0a1b"));
    }

    #[test]
    fn stamps_are_found_in_any_comment_and_letters_of_any_size_and_nothing_else_is_one() {
        let both = Steps::of(&[Step::Wear, Step::Cc]);
        for text in [
            format!("%\nO1\n({})\nG0 X0\n", stamp()),
            format!("; {}\r\n", stamp().to_string().to_uppercase()),
            format!("0 BEGIN PGM A MM\n;{}", stamp().to_string().to_lowercase()),
            format!("T T Trunnion {}", stamp()),
        ] {
            assert_eq!(borne_by(text.as_bytes()), both, "{text}");
        }
        for text in [
            "(Trunnion)",
            "(made with Trunnion 0.2.0)",
            "(Trunnion 0.2.0 cc-compensation steps)",
            "(Trunnion 0.2.0 cc-compensation steps cc,mill machine a)",
            "(Trunnion 0.2.0 cc-compensation steps cc\nmachine a)",
            "Trunnio",
        ] {
            assert_eq!(borne_by(text.as_bytes()), Steps::NONE, "{text}");
        }
    }

    #[test]
    fn a_stamp_is_found_however_the_text_is_cut() {
        let text = format!("{}({}){}", "G0 X1\n".repeat(90), stamp(), "\nG1 X2 T3".repeat(60));
        for size in [1, 7, 100, 255, 256, 257, 600] {
            let mut finder = StampFinder::default();
            text.as_bytes().chunks(size).for_each(|piece| finder.see(piece));
            assert_eq!(finder.steps(), stamp().steps, "pieces of {size}");
        }
    }
}
