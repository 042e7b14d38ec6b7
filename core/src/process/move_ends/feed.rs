//! The F word of a block whose path changed. No block runs faster than the source's.

use crate::contact::{BlockTime, feed_word};
use crate::motion::{AxisWords, Feed, FeedMode, Motion, MotionKind};

use crate::process::fault::LineFaultKind;
use crate::process::pipeline::{FeedInTime, MIN_FEED, TIME_ROUNDING, feed_in_time, rounded_feed};
use crate::program::NewWord;

/// The lower F that a block needs if its path is shorter now, or if F now counts millimetres instead of degrees.
/// Without it, a purely rotary block that gains 0.02 mm of X would run through its degrees in no time. `None` if the
/// source's F can stay.
///
/// # Errors
/// The F is not known although its meaning changes, or it is too small to be written.
pub(super) fn lowered_feed(
    motion: &Motion,
    written: [&AxisWords; 2],
    has_feed_column: bool,
) -> Result<Option<NewWord>, LineFaultKind> {
    let Feed { mode, value, raw, .. } = motion.feed;
    let (Some(start), Some(end)) = (&motion.start, &motion.end) else { return Ok(None) };
    if motion.kind != MotionKind::Linear || mode == Some(FeedMode::InverseTime) || !has_feed_column {
        return Ok(None);
    }
    let [before, after] = [[start, end], written].map(|ends| BlockTime::of_words(ends, motion.mm_per_unit));
    // In G95 the same lengths count, per turn of the spindle.
    let share = feed_word(mode.unwrap_or(FeedMode::PerMinute), 1.0, &before, &after, 1.0);
    let Some(share) = share.filter(|share| *share < 1.0 - TIME_ROUNDING) else { return Ok(None) };
    if value.is_none() {
        let changes = before.is_purely_rotary() != after.is_purely_rotary();
        return if changes { Err(LineFaultKind::FeedUnknown) } else { Ok(None) };
    }
    // The new F is lower than the source's, so no limit is asked.
    match feed_in_time(motion, [&before, &after], 1.0, None) {
        // F0 and a negative F are no speed, and no share of them is one.
        None => Err(LineFaultKind::FeedTooSmall { feed: raw * share, min: MIN_FEED }),
        Some(FeedInTime::TooLow(feed)) => Err(LineFaultKind::FeedTooSmall { feed, min: MIN_FEED }),
        Some(FeedInTime::Fits(feed) | FeedInTime::TooHigh(feed)) => {
            Ok(Some(rounded_feed(&motion.feed, feed)))
        }
    }
}
