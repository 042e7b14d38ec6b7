//! The F word of a block that is written again or inserted. The block takes the time of its source, the F is not below
//! the smallest one that can be written, and not above the largest one allowed.

use crate::contact::{BlockTime, feed_word};
use crate::motion::{Feed, FeedMode, Motion};
use crate::program::{Address, NewWord, round_to_decimals};
use crate::units::Feedrate;

/// Smallest F that is written, in the program's own unit.
pub(in crate::process) const MIN_FEED: f64 = 1e-6;
/// Without a stated limit, the largest F is this number of times the programmed F.
pub(in crate::process) const FEED_TIMES: f64 = 10.0;
/// The time of a written block may differ from the time of its source by this share, because F words are rounded.
pub(in crate::process) const TIME_ROUNDING: f64 = 0.01;

/// An F counts as at its limit if it exceeds it by no more than this share.
const SAME_FEED: f64 = 1e-9;
/// Largest relative rounding error of an F word. If the source's decimals are too coarse, finer ones are used.
const FEED_ROUNDING: f64 = 0.005;
/// Most decimals of an F word: the smallest one written still has three digits.
const MAX_FEED_DECIMALS: u8 = 9;

/// The F value with which a block takes the time of its source, in program units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::process) enum FeedInTime {
    /// It can be written.
    Fits(f64),
    /// It is smaller than [`MIN_FEED`].
    TooLow(f64),
    /// It is faster than allowed.
    TooHigh(f64),
}

impl FeedInTime {
    /// The value, whether it can be written or not.
    pub(in crate::process) fn value(self) -> f64 {
        let (Self::Fits(value) | Self::TooLow(value) | Self::TooHigh(value)) = self;
        value
    }
}

/// The F value of a block that takes the share `share` of the time of the motion's source. `None` if the feed mode is
/// not known, or if the source has no travel along which F counts.
pub(in crate::process) fn feed_in_time(
    motion: &Motion,
    [source, written]: [&BlockTime; 2],
    share: f64,
    max_feed: Option<Feedrate>,
) -> Option<FeedInTime> {
    let feed = feed_word(motion.feed.mode?, motion.feed.raw, source, written, share)?;
    Some(if feed < MIN_FEED {
        FeedInTime::TooLow(feed)
    } else if is_too_fast(max_feed, motion, [source, written], feed) {
        FeedInTime::TooHigh(feed)
    } else {
        FeedInTime::Fits(feed)
    })
}

/// The F word with this value, with the source's decimals or more if needed.
pub(in crate::process) fn rounded_feed(feed: &Feed, value: f64) -> NewWord {
    let mut decimals = feed.decimals;
    while (round_to_decimals(value, decimals) / value - 1.0).abs() > FEED_ROUNDING
        && decimals < MAX_FEED_DECIMALS.max(feed.decimals)
    {
        decimals += 1;
    }
    NewWord { address: Address::F, value: round_to_decimals(value, decimals), decimals }
}

/// Whether a block with this F runs faster than allowed. If the limit cannot be compared with this F (degrees, or a
/// length per spindle turn), the limit is [`FEED_TIMES`] the programmed F.
fn is_too_fast(
    max_feed: Option<Feedrate>,
    motion: &Motion,
    [source, written]: [&BlockTime; 2],
    feed: f64,
) -> bool {
    let max_units_per_min = max_feed.map(|max| max.mm_per_min() / motion.mm_per_unit);
    let programmed = motion.feed.raw;
    let (speed, limit) = match motion.feed.mode {
        Some(FeedMode::InverseTime) => {
            let limit = max_units_per_min.unwrap_or(FEED_TIMES * source.path_units * programmed);
            // A source that only turns has no speed of its tip to compare with.
            let has_limit = max_units_per_min.is_some() || !source.is_purely_rotary();
            (written.path_units * feed, if has_limit { limit } else { f64::INFINITY })
        }
        Some(FeedMode::PerMinute) if !written.is_purely_rotary() => {
            (feed, max_units_per_min.unwrap_or(FEED_TIMES * programmed))
        }
        _ => (feed, FEED_TIMES * programmed),
    };
    speed > limit * (1.0 + SAME_FEED)
}
