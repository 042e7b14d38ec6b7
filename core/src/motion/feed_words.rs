//! The feed of a block: what its F word sets, and at what the motion runs.

use super::interpreter::Interpreter;
use super::modal::ModalFeed;
use super::{Feed, FeedMode};
use crate::program::{Address, round_to_decimals};

const FEED: usize = Address::F.index();
/// A feed stated from outside is rounded by less than this share.
const FEED_ROUNDING: f64 = 1e-6;
const MAX_FEED_DECIMALS: u8 = 6;

impl Interpreter {
    #[inline]
    pub(super) fn set_feed(&mut self) {
        if self.block.present & (1 << FEED) != 0 {
            let known = self.block.unknown & (1 << FEED) == 0 && !self.this_block.other_feed;
            self.modal.feed = if known {
                ModalFeed::Given(self.block.values[FEED], self.block.decimals[FEED])
            } else {
                ModalFeed::Unknown
            };
        }
    }

    #[inline]
    pub(super) fn feed(&self) -> Feed {
        let mode = self.modal.feed_mode();
        let paths = self.rules.feed.paths;
        let word_in_block = self.block.present & (1 << FEED) != 0;
        let stands = match self.modal.feed {
            // A time is one block's in every dialect, a speed goes on.
            ModalFeed::Given(..) if mode == Some(FeedMode::InverseTime) && !word_in_block => None,
            ModalFeed::Given(raw, decimals) => Some((raw, decimals)),
            ModalFeed::NeverGiven if mode == Some(FeedMode::PerMinute) => self.feed_before_the_first(),
            ModalFeed::NeverGiven | ModalFeed::Unknown => None,
        };
        let Some((raw, decimals)) = stands else {
            return Feed { mode, value: None, raw: 0.0, decimals: 0, paths, word_in_block };
        };
        let value = match mode {
            Some(FeedMode::PerMinute | FeedMode::PerRevolution) => {
                self.modal.mm_per_unit.map(|scale| raw * scale)
            }
            Some(FeedMode::InverseTime) => Some(raw),
            None => None,
        };
        Feed { mode, value, raw, decimals, paths, word_in_block }
    }

    /// The feed stated from outside, as an F word would be written in the program's units: the fewest decimals that
    /// come within `FEED_ROUNDING` of it, at most `MAX_FEED_DECIMALS`.
    fn feed_before_the_first(&self) -> Option<(f64, u8)> {
        let raw = self.options.feed_mm_per_min? / self.modal.mm_per_unit?;
        let near = |decimals: &u8| (round_to_decimals(raw, *decimals) - raw).abs() < FEED_ROUNDING * raw;
        let decimals = (0..MAX_FEED_DECIMALS).find(near).unwrap_or(MAX_FEED_DECIMALS);
        let rounded = round_to_decimals(raw, decimals);
        (rounded > 0.0 && rounded.is_finite()).then_some((rounded, decimals))
    }
}
