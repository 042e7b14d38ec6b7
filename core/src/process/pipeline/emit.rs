//! The style of blocks that are written again: block numbers and feeds, with the F words that the written program owes.

use super::feed_at_risk::feed_at_risk;
use crate::motion::{AxisWords, Feed, FeedForm, FeedMode, FeedRules, Motion, Unfollowable};
use crate::process::text::{Inventory, Numbering};
use crate::program::{
    Address, Batch, BlockFlags, MAX_DECIMALS, NewWord, WriteFault, print_changed, round_to_decimals,
};

/// A written number this close to the intended one is equal to it \[program units\].
pub(in crate::process) const SAME_WORD: f64 = 1e-9;

/// Writes blocks and keeps track of the feed in force in the written program.
#[derive(Debug, Default)]
pub(in crate::process) struct Emitter {
    /// The source's F, if divided blocks left another F in force. It has to be restored.
    owed: Option<OwedFeed>,
    pub(super) feeds_restored: u64,
    /// Number of written blocks with an F word only.
    pub(super) feed_blocks: u64,
    numbering: Numbering,
    /// Numbers given to inserted blocks.
    pub(super) numbers: Inventory,
}

/// The F word in force in the source that divided blocks replaced in the output. It has to be restored.
#[derive(Debug, Clone, Copy)]
struct OwedFeed {
    raw: f64,
    decimals: u8,
    mode: Option<FeedMode>,
}

impl OwedFeed {
    /// Whether the source itself states another F, or changes the meaning of F, at this feed. An unknown feed
    /// counts as not stated.
    fn is_given_again(&self, feed: &Feed) -> bool {
        // In G93 a block without F has no value to compare.
        let is_compared = feed.value.is_some() && self.mode != Some(FeedMode::InverseTime);
        feed.word_in_block || feed.mode != self.mode || (is_compared && differs(feed.raw, self.raw))
    }
}

impl Emitter {
    /// For a program with this numbering.
    pub(super) fn new(numbering: Numbering) -> Self {
        Self { numbering, ..Self::default() }
    }

    /// Whether divided blocks have left another modal feed than the source's.
    pub(super) fn owes_feed(&self) -> bool {
        self.owed.is_some()
    }

    /// Records that the written program has another modal F than this feed of the source.
    pub(super) fn owe(&mut self, feed: &Feed) {
        self.owed = Some(OwedFeed { raw: feed.raw, decimals: feed.decimals, mode: feed.mode });
    }

    /// The F word that a block with this feed must restore when it is written again. It is then no longer owed.
    pub(super) fn take_owed(&mut self, feed: &Feed) -> Option<NewWord> {
        let owed = self.owed.take()?;
        (!owed.is_given_again(feed)).then_some(NewWord {
            address: Address::F,
            value: owed.raw,
            decimals: owed.decimals,
        })
    }

    /// Counts a feed written with these words. In cutter location data a feed is a statement of its own. Returns
    /// whether there is one.
    pub(in crate::process) fn count_feed(&mut self, batch: &Batch, words: &[NewWord]) -> bool {
        let states_feed =
            form(batch) == FeedForm::Statement && words.iter().any(|word| word.address == Address::F);
        self.feed_blocks += u64::from(states_feed);
        states_feed
    }

    /// Restores the owed F in a block of its own, in the style of this one, if the blocks from `first` on would
    /// change the meaning of F before a motion restores it. The written program must not continue with the F of
    /// divided blocks.
    pub(super) fn settle(
        &mut self,
        batch: &Batch,
        style: usize,
        first: usize,
        out: &mut Vec<u8>,
    ) -> Result<(), WriteFault> {
        let is_at_risk = |owed: &OwedFeed| feed_at_risk(batch, first, owed.mode) == Some(true);
        let Some(owed) = self.owed.filter(is_at_risk) else {
            return Ok(());
        };
        crate::program::print_feed_only(batch, style, owed.raw, owed.decimals, out)?;
        self.owed = None;
        self.feeds_restored += 1;
        self.feed_blocks += 1;
        Ok(())
    }

    /// Restores the source's feed for a block that is left unchanged. Returns true if it wrote the block with its
    /// F. Returns false if the block can be copied; a block with only F may then be written before it.
    pub(super) fn restore_feed(
        &mut self,
        batch: &Batch,
        motion: &Motion,
        out: &mut Vec<u8>,
    ) -> Result<bool, WriteFault> {
        use crate::motion::MotionKind::{Arc, Linear, Opaque, Rapid};
        let Some(owed) = self.owed else { return Ok(false) };
        let feed = &motion.feed;
        let skipped_perhaps = batch
            .blocks()
            .get(motion.block as usize)
            .is_some_and(|block| block.flags.has(BlockFlags::DELETE));
        match motion.kind {
            Rapid => return Ok(false),
            _ if !skipped_perhaps && owed.is_given_again(feed) => {
                self.owed = None;
                return Ok(false);
            }
            // A block that the operator may skip must not be the one that restores the feed. Nor may a block
            // without F in G93: a control can stop there, or use the number in force.
            Linear | Arc
                if motion.unfollowable != Some(Unfollowable::BlockDelete)
                    && owed.mode != Some(FeedMode::InverseTime) =>
            {
                let word = NewWord { address: Address::F, value: owed.raw, decimals: owed.decimals };
                print_changed(batch, motion.block as usize, &[word], false, out)?;
                self.count_feed(batch, &[word]);
                self.owed = None;
                self.feeds_restored += 1;
                return Ok(true);
            }
            Linear | Arc | Opaque => {
                crate::program::print_feed_only(batch, motion.block as usize, owed.raw, owed.decimals, out)?;
                self.owed = None;
                self.feeds_restored += 1;
                self.feed_blocks += 1;
            }
        }
        Ok(false)
    }

    /// The modal feed in the written program before a block with this feed \[its unit\]; NaN if unknown.
    pub(in crate::process) fn modal_feed_before(&self, feed: &Feed) -> f64 {
        // The source block may state its own feed, whatever was modal before.
        if self.owed.is_some() || feed.word_in_block { f64::NAN } else { feed.raw }
    }

    /// The number of the first of `inserted` blocks after this one, if the program numbers its blocks.
    pub(in crate::process) fn number_after(&self, batch: &Batch, block: usize, inserted: u64) -> Option<u64> {
        self.numbering.behind(batch, block, inserted)
    }

    /// Counts the number of an inserted block.
    pub(in crate::process) fn count_number(&mut self, number: f64) {
        self.numbers.add_number(number);
    }

    /// Records that a block was divided and left this modal feed in the written program. The source's feed is owed
    /// if it differs.
    ///
    /// # Errors
    /// The feed cannot be written.
    pub(in crate::process) fn owe_after_division(
        &mut self,
        batch: &Batch,
        block: usize,
        feed: &Feed,
        modal_feed: f64,
        out: &mut Vec<u8>,
    ) -> Result<(), WriteFault> {
        // Also in G93: a cycle, or a motion after G94, may use the number in force.
        self.owed = differs(modal_feed, feed.raw).then_some(OwedFeed {
            raw: feed.raw,
            decimals: feed.decimals,
            mode: feed.mode,
        });
        // Statements between this point and the next may belong to the next point.
        if form(batch) == FeedForm::Statement
            && let Some(owed) = self.owed.take()
        {
            crate::program::print_feed_only(batch, block, owed.raw, owed.decimals, out)?;
            self.feeds_restored += 1;
            self.feed_blocks += 1;
        }
        Ok(())
    }

    /// A divided block without a feed: nothing is owed after it.
    pub(in crate::process) fn owe_nothing(&mut self) {
        self.owed = None;
    }
}

/// The form of a feed in programs of this batch's dialect.
pub(in crate::process) fn form(batch: &Batch) -> FeedForm {
    FeedRules::of(batch.dialect()).form
}

/// Whether two written numbers differ. An unknown number (NaN) differs from every other.
pub(in crate::process) fn differs(a: f64, b: f64) -> bool {
    a.is_nan() || b.is_nan() || (a - b).abs() > SAME_WORD
}

/// X Y Z in program units, rotary words in degrees.
pub(in crate::process) fn in_units(words: &AxisWords, mm_per_unit: f64) -> [f64; 5] {
    let [x, y, z] = words.linear_mm.map(|mm| mm / mm_per_unit);
    let [first, second] = words.rotary_deg;
    [x, y, z, first, second]
}

/// The fewest decimals, at least `decimals`, that reproduce `value`.
pub(in crate::process) fn exact_decimals(value: f64, decimals: u8) -> u8 {
    (decimals..=MAX_DECIMALS)
        .find(|&digits| !differs(round_to_decimals(value, digits), value))
        .unwrap_or(decimals)
}
