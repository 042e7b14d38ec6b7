//! Whether the F that divided blocks owe would meet another meaning before a motion gives it back.

use crate::motion::FeedMode;
use crate::program::{Address, Batch, Block, BlockFlags, BlockKind, Dialect, Keyword, Word};

/// G codes by which F counts in other units or along something else, in tenths: inch and metric, G93 to G97.
fn changes_feed(tenths: u32) -> bool {
    matches!(tenths, 200 | 210 | 700 | 710 | 7000 | 7100 | 930..=979)
}

/// G codes behind which a block with axis words moves at feed, in tenths: G1 to G3, and canned cycles.
fn moves_at_feed(tenths: u32) -> bool {
    matches!(tenths, 10 | 20 | 30 | 730 | 740 | 760 | 810..=899)
}

/// Looks at the blocks from `first` on: true where one changes what F means before the next motion at feed takes the F owed
/// in this mode back, false where that motion (or an F of the source, or the program's end) comes first, `None` where
/// neither is in this batch.
///
/// The number of G93 is meant for its own block. Where the mode changes it is at risk only if something then moves
/// without an F of its own: controls that keep the number would take it.
pub(super) fn feed_at_risk(batch: &Batch, first: usize, owed_in: Option<FeedMode>) -> Option<bool> {
    let mut is_rapid = false;
    let mut is_changed = false;
    for block in batch.blocks().get(first..).unwrap_or_default() {
        if block.kind == BlockKind::Call {
            return Some(is_changed);
        }
        let words = batch.words(block);
        // Whether a block that the operator may skip gives a feed, nobody knows.
        if block.flags.has(BlockFlags::DELETE) {
            return Some(true);
        }
        if words.iter().any(|word| word.address == Address::F) {
            return Some(is_dwell(words));
        }
        if says_otherwise(batch, block, words) {
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
    // What follows the batch is not seen yet, and the number could not be given back before the change any more.
    is_changed.then_some(true)
}

/// M2 and M30.
fn ends_program(words: &[Word]) -> bool {
    let codes = words.iter().filter(|word| word.address == Address::M);
    codes.filter_map(Word::code_tenths).any(|code| matches!(code, 20 | 300))
}

/// Whether the block moves by words of its own. Axis words of offsets and frames move nothing.
fn has_coordinates(words: &[Word]) -> bool {
    words.iter().any(|word| word.address.is_coordinate()) && !words.iter().any(takes_axis_words)
}

/// G4, whose F may be a time.
fn is_dwell(words: &[Word]) -> bool {
    words.iter().any(|word| word.address == Address::G && word.code_tenths() == Some(40))
}

/// A code or statement whose axis words are no place to go to.
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

/// Whether the block gives F another meaning, or may.
fn says_otherwise(batch: &Batch, block: &Block, words: &[Word]) -> bool {
    if block.kind != BlockKind::Words {
        return false;
    }
    let codes = words.iter().filter(|word| word.address == Address::G);
    let by_code = codes.filter_map(Word::code_tenths).any(changes_feed);
    // FAUTO and its kin; M136 and M137.
    let by_statement = batch.dialect() == Dialect::Heidenhain
        && words.iter().any(|word| match word.address {
            Address::M => matches!(word.code_tenths(), Some(1360 | 1370)),
            _ => word.keyword() == Some(Keyword::FeedElsewhere),
        });
    by_code || by_statement
}
