//! Whether the meaning of F changes before a motion restores the F that divided blocks replaced.

use crate::motion::{FeedMode, FeedRules};
use crate::program::{Address, Batch, BlockFlags, BlockKind, Keyword, Word};

/// G codes after which a block with axis words moves at feed, in tenths: G1 to G3, and canned cycles.
fn moves_at_feed(tenths: u32) -> bool {
    matches!(tenths, 10 | 20 | 30 | 730 | 740 | 760 | 810..=899)
}

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
        for word in words.iter().filter(|word| word.address == Address::G) {
            match word.code_tenths() {
                Some(0) => is_rapid = true,
                Some(code) if moves_at_feed(code) => is_rapid = false,
                _ => {}
            }
        }
        let here = words.iter().any(|word| matches!(word.keyword(), Some(Keyword::Fmax | Keyword::Rapid)));
        if has_coordinates(words) && !is_rapid && !here {
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

/// Whether the block moves by words of its own. Axis words of offsets and frames move nothing.
fn has_coordinates(words: &[Word]) -> bool {
    words.iter().any(|word| word.address.is_coordinate()) && !words.iter().any(takes_axis_words)
}

/// Whether the block is a dwell (G4), whose F may be a time.
fn is_dwell(words: &[Word]) -> bool {
    words.iter().any(|word| word.address == Address::G && word.code_tenths() == Some(40))
}

/// Whether this is a code or statement whose axis words are not a position to move to.
fn takes_axis_words(word: &Word) -> bool {
    use Keyword as K;
    let by_statement = matches!(
        word.keyword(),
        Some(
            K::DatumShift
                | K::AxisScaling
                | K::From
                | K::ToolAxis
                | K::Trans
                | K::Atrans
                | K::Rot
                | K::Arot
                | K::Scale
                | K::Ascale
                | K::Mirror
                | K::Amirror
        )
    );
    let by_code = word.address == Address::G
        && matches!(word.code_tenths(), Some(40 | 100 | 220 | 230 | 520 | 920..=923 | 1070));
    by_statement || by_code
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
        for (line, expected) in [("M136", true), ("M137", true), ("L X+1 R0 FAUTO", true), ("M8", false)] {
            let text = format!("0 BEGIN PGM A MM\n1 {line}\n2 L X+5\n");
            assert_eq!(at_risk(Dialect::Heidenhain, &text), Some(expected), "{line}");
        }
    }
}
