//! A division: where the parts of a block end, and whether their F words can be written.

use super::checked::Checked;
use crate::contact::{BlockTime, Node, Resolution, feed_word, segments};
use crate::motion::{FeedMode, Motion};
use crate::process::pipeline::MIN_FEED;
use crate::units::Feedrate;

/// An F counts as at its limit if it exceeds it by no more than this share.
const SAME_FEED: f64 = 1e-9;
/// Without a stated limit, the largest F is this number of times the programmed F.
pub(in crate::process) const FEED_TIMES: f64 = 10.0;

/// A block that is divided: where its parts end, and with which decimals.
#[derive(Debug, Clone)]
pub(in crate::process) struct Division {
    pub(in crate::process) nodes: Vec<Node>,
    pub(in crate::process) resolution: Resolution,
    /// Whether the parts can carry F words: a feed is known, and a table has a column for it.
    pub(in crate::process) carries_feed: bool,
}

/// The resolution of the parts: these decimals, and in G91 the place from which words count.
pub(in crate::process) fn resolution(
    checked: &Checked<'_>,
    motion: &Motion,
    linear_decimals: u8,
    rotary_decimals: u8,
) -> Resolution {
    let axis_decimals = motion.tool_axis.map(|_| rotary_decimals);
    let absolute = Resolution::absolute(linear_decimals, rotary_decimals, motion.mm_per_unit);
    let absolute = Resolution { axis_decimals, ..absolute };
    if motion.incremental { Resolution { origin: checked.block.ends[0].words, ..absolute } } else { absolute }
}

/// The result for the F words of all parts.
pub(in crate::process) enum PartFeeds {
    /// All F words can be written.
    Fit,
    /// One F word is above the limit.
    TooHigh,
    /// One F word is too small to be written.
    TooLow {
        /// The F word, in program units.
        feed: f64,
    },
}

/// Checks the F words of all parts: each must be large enough to be written, and no faster than allowed.
pub(in crate::process) fn part_feeds(
    checked: &Checked<'_>,
    motion: &Motion,
    nodes: &[Node],
    max_feed: Option<Feedrate>,
) -> PartFeeds {
    let source = BlockTime::of(&checked.block, &checked.block.whole(), motion.mm_per_unit, motion.feed.paths);
    for segment in segments(&checked.block, nodes) {
        let share = segment.fraction[1] - segment.fraction[0];
        let part = BlockTime::of(&checked.block, &segment, motion.mm_per_unit, motion.feed.paths);
        let Some(mode) = motion.feed.mode else { return PartFeeds::TooLow { feed: 0.0 } };
        let feed = feed_word(mode, motion.feed.raw, &source, &part, share).unwrap_or(0.0);
        if feed < MIN_FEED {
            return PartFeeds::TooLow { feed };
        }
        if is_too_fast(max_feed, motion, [&source, &part], feed) {
            return PartFeeds::TooHigh;
        }
    }
    PartFeeds::Fit
}

/// Whether a part with this F runs faster than allowed. If the limit cannot be compared with this F (degrees, or a
/// length per spindle turn), the limit is [`FEED_TIMES`] the programmed F.
pub(in crate::process) fn is_too_fast(
    max_feed: Option<Feedrate>,
    motion: &Motion,
    [source, part]: [&BlockTime; 2],
    feed: f64,
) -> bool {
    let max_units_per_min = max_feed.map(|max| max.mm_per_min() / motion.mm_per_unit);
    let programmed = motion.feed.raw;
    let (speed, limit) = match motion.feed.mode {
        Some(FeedMode::InverseTime) => {
            let limit = max_units_per_min.unwrap_or(FEED_TIMES * source.path_units * programmed);
            // A source that only turns has no speed of its tip to compare with.
            let has_limit = max_units_per_min.is_some() || !source.is_purely_rotary();
            (part.path_units * feed, if has_limit { limit } else { f64::INFINITY })
        }
        Some(FeedMode::PerMinute) if !part.is_purely_rotary() => {
            (feed, max_units_per_min.unwrap_or(FEED_TIMES * programmed))
        }
        _ => (feed, FEED_TIMES * programmed),
    };
    speed > limit * (1.0 + SAME_FEED)
}
