//! Whether the meaning of F changes before a motion restores the F that divided blocks replaced.

use crate::motion::{BlockMotion, FeedMode, FeedRules};
use crate::program::{Address, Batch, BlockFlags, BlockKind, Keyword, Word};

/// Looks at the blocks from `first` on. True if a block changes the meaning of F before the next motion at feed
/// restores the F owed in this mode. False if that motion, an F of the source, or the program's end comes first.
/// `None` if this batch has none of these.
///
/// The number of G93 is meant for its own block. After a change of mode it is at risk only if a block then moves
/// without an F of its own: controls that keep the number would use it.
pub(in crate::process) fn feed_at_risk(
    batch: &Batch,
    first: usize,
    owed_in: Option<FeedMode>,
) -> Option<bool> {
    let rules = FeedRules::of(batch.dialect());
    let mut is_rapid = false;
    let mut is_changed = false;
    for block in batch.blocks().get(first..).unwrap_or_default() {
        if block.kind == BlockKind::Call {
            return Some(is_changed);
        }
        let words = batch.words(block);
        // It is not known whether a block that the operator may skip gives a feed.
        if block.flags.has(BlockFlags::DELETE) {
            return Some(true);
        }
        if words.iter().any(|word| word.address == Address::F) {
            return Some(is_dwell(words));
        }
        if block.kind == BlockKind::Words && words.iter().any(|word| rules.is_changed_by(word)) {
            is_changed = true;
            if owed_in != Some(FeedMode::InverseTime) {
                return Some(true);
            }
        }
        if ends_program(words) {
            return Some(false);
        }
        let mut moves = words.iter().any(|word| word.address.is_coordinate());
        for word in words {
            match FeedRules::block_motion(batch.dialect(), word) {
                Some(BlockMotion::Rapid) => is_rapid = true,
                Some(BlockMotion::AtFeed) => is_rapid = false,
                Some(BlockMotion::NotByAxisWords) => moves = false,
                None => {}
            }
        }
        let here = words.iter().any(|word| matches!(word.keyword(), Some(Keyword::Fmax | Keyword::Rapid)));
        if moves && !is_rapid && !here {
            return Some(is_changed);
        }
    }
    // The blocks after the batch are not known yet, and the number could no longer be restored before the change.
    is_changed.then_some(true)
}

/// Whether the block ends the program (M2 or M30).
fn ends_program(words: &[Word]) -> bool {
    let codes = words.iter().filter(|word| word.address == Address::M);
    codes.filter_map(Word::code_tenths).any(|code| matches!(code, 20 | 300))
}

/// Whether the block is a dwell (G4), whose F may be a time.
fn is_dwell(words: &[Word]) -> bool {
    words.iter().any(|word| word.address == Address::G && word.code_tenths() == Some(40))
}

#[cfg(test)]
mod tests {
    use super::{FeedMode, feed_at_risk};
    use crate::program::{Batch, Dialect, ReadLimits, Reader};

    fn at_risk(dialect: Dialect, text: &str) -> Option<bool> {
        let mut reader = Reader::new(Some(dialect), ReadLimits::default());
        reader.feed(text.as_bytes());
        reader.finish();
        let mut batch = Batch::new();
        assert!(reader.next_batch(&mut batch).expect("text"));
        feed_at_risk(&batch, 0, Some(FeedMode::PerMinute))
    }

    #[test]
    fn every_code_of_a_dialect_that_gives_f_another_meaning_is_seen() {
        for (dialect, codes) in [
            (Dialect::Iso, &["G20", "G21", "G93", "G94", "G95", "G96"][..]),
            (Dialect::Siemens, &["G70", "G700", "G710", "G93", "G95", "G96", "G961", "G971", "G973"]),
        ] {
            for code in codes {
                assert_eq!(at_risk(dialect, &format!("{code}\nG1 X5\n")), Some(true), "{code}");
            }
            assert_eq!(at_risk(dialect, "G64\nG1 X5\n"), Some(false));
        }
        for code in ["G20", "G21", "G94", "G95"] {
            assert_eq!(at_risk(Dialect::Okuma, &format!("{code}\nG1 X5\n")), Some(true), "{code}");
        }
        for (line, expected) in [("M136", true), ("M137", true), ("L X+1 R0 FAUTO", true), ("M8", false)] {
            let text = format!("0 BEGIN PGM A MM\n1 {line}\n2 L X+5\n");
            assert_eq!(at_risk(Dialect::Heidenhain, &text), Some(expected), "{line}");
        }
    }

    #[test]
    fn axis_words_that_are_no_place_to_go_to_restore_no_feed() {
        for (dialect, line) in [
            (Dialect::Iso, "G10 L2 P1 X5"),
            (Dialect::Iso, "G52 X5"),
            (Dialect::Iso, "G92 X5"),
            (Dialect::Iso, "G68 X5 Y0 R30"),
            (Dialect::Iso, "G22 X5 Y5"),
            (Dialect::Siemens, "TRANS X5"),
            (Dialect::Siemens, "G58 X5"),
            (Dialect::Okuma, "G71 Z100"),
            (Dialect::Okuma, "G11 X5 Y0 P30"),
            (Dialect::Okuma, "G22 X5 Y5"),
        ] {
            assert_eq!(at_risk(dialect, &format!("{line}\nG95\nG1 X5\n")), Some(true), "{line}");
        }
        assert_eq!(at_risk(Dialect::Okuma, "G1 X5\nG95\n"), Some(false));
        // G74 is a cycle of ISO programs, and goes to a reference point in Sinumerik programs.
        assert_eq!(at_risk(Dialect::Siemens, "G0\nG74 X5\nG95\nG1 X5\n"), Some(true));
        assert_eq!(at_risk(Dialect::Iso, "G0\nG74 X5 Z-5 R2\nG95\n"), Some(false));
    }
}
