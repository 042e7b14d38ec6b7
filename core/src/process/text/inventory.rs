//! A count of everything in a program that compensation must neither lose nor double: blocks, and all words except
//! coordinates, contacts, extruder and feed.

use crate::program::{Address, Batch, Block, Keyword, Word, WordForm};

/// A count of blocks, and a checksum of words that does not depend on their order: M words move to the last part of
/// a divided block, all other words stay.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(in crate::process) struct Inventory {
    /// Blocks as the contract counts them.
    pub(in crate::process) blocks: u64,
    /// Blocks that compensation inserts.
    pub(in crate::process) inserted: u64,
    words: u64,
    checksum: u64,
}

/// Odd multiplier that spreads bits (the golden ratio's fraction times 2^64).
const SPREAD: u64 = 0x9E37_79B9_7F4A_7C15;

/// Addresses of words that are checked as motions and feeds.
const PLACES_AND_FEED: u32 = Address::COORDINATES | Address::F.bit();

/// Words of statements that inserted blocks have as well. They are checked as motions and feeds.
fn says_motion_or_feed(word: &Word) -> bool {
    use Keyword as K;
    word.keyword().is_some_and(|keyword| {
        matches!(
            keyword,
            K::L | K::Ln
                | K::Goto
                | K::Fedrat
                | K::MmPerMinute
                | K::InchPerMinute
                | K::UnitPerMinute
                | K::MmPerRevolution
                | K::InchPerRevolution
                | K::UnitPerRevolution
        )
    })
}

impl Inventory {
    /// Counts the blocks and words of a batch.
    pub(in crate::process) fn see(&mut self, batch: &Batch) {
        self.see_blocks(batch, batch.blocks());
    }

    /// Counts some blocks of a batch.
    pub(in crate::process) fn see_blocks(&mut self, batch: &Batch, blocks: &[Block]) {
        self.blocks += blocks.iter().filter(|block| block.counts()).count() as u64;
        batch.words_of(blocks).for_each(|word| {
            if word.address.bit() & PLACES_AND_FEED != 0 || says_motion_or_feed(word) {
                return;
            }
            // Constants may decide later what an expression is worth or an assignment means.
            let is_told = match word.form {
                WordForm::Number | WordForm::Comma => false,
                WordForm::Keyword => word.keyword().is_some_and(Keyword::is_assignment),
                _ => true,
            };
            let value = if is_told { u64::MAX } else { word.value.to_bits() };
            self.count(word.address, value);
        });
    }

    /// A block number that compensation adds.
    pub(in crate::process) fn add_number(&mut self, number: f64) {
        self.count(Address::N, number.to_bits());
    }

    /// Adds the counts of another inventory.
    pub(in crate::process) fn join(&mut self, other: &Self) {
        self.blocks += other.blocks;
        self.inserted += other.inserted;
        self.words += other.words;
        self.checksum = self.checksum.wrapping_add(other.checksum);
    }

    fn count(&mut self, address: Address, value: u64) {
        let mixed = (value ^ (address.index() as u64 + 1)).wrapping_mul(SPREAD);
        self.words += 1;
        self.checksum = self.checksum.wrapping_add((mixed ^ (mixed >> 29)).wrapping_mul(SPREAD));
    }

    /// Whether `written` has everything that this source has, and no more blocks than were inserted.
    pub(in crate::process) fn is_kept_by(&self, written: &Self) -> bool {
        (self.words, self.checksum) == (written.words, written.checksum)
            && self.blocks + self.inserted == written.blocks
    }
}
