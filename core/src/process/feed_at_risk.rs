//! Whether the F that divided blocks owe would meet another meaning before a motion gives it back.

use crate::program::{Address, Batch, Block, BlockKind, Dialect, Keyword, Word};

/// G codes by which F counts in other units or along something else, in tenths: inch and metric, G93 to G97.
fn changes_feed(tenths: u32) -> bool {
    matches!(tenths, 200 | 210 | 700 | 710 | 7000 | 7100 | 930..=979)
}

/// Looks at the blocks from `first` on: true where one changes what F means before the next motion at feed takes the owed F
/// back, false where that motion (or an F of the source) comes first, `None` where neither is in this batch.
pub(super) fn feed_at_risk(batch: &Batch, first: usize) -> Option<bool> {
    let mut is_rapid = false;
    for block in batch.blocks().get(first..).unwrap_or_default() {
        if block.kind == BlockKind::Call {
            return Some(false);
        }
        let words = batch.words(block);
        if words.iter().any(|word| word.address == Address::F) {
            return Some(false);
        }
        if says_otherwise(batch, block, words) {
            return Some(true);
        }
        for word in words.iter().filter(|word| word.address == Address::G) {
            match word.code_tenths() {
                Some(0) => is_rapid = true,
                Some(10 | 20 | 30) => is_rapid = false,
                _ => {}
            }
        }
        let here = words.iter().any(|word| matches!(word.keyword(), Some(Keyword::Fmax | Keyword::Rapid)));
        if has_coordinates(words) && !is_rapid && !here {
            return Some(false);
        }
    }
    None
}

fn has_coordinates(words: &[Word]) -> bool {
    words.iter().any(|word| word.address.is_coordinate())
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
