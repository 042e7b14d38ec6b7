//! The F word of a block whose path changed: no block runs faster than the source's.

use super::super::emit::rounded_feed;
use super::super::fault::LineFaultKind;
use super::super::plan::MIN_FEED;
use crate::contact::{BlockTime, feed_word};
use crate::motion::{AxisWords, Feed, FeedMode, Motion, MotionKind};
use crate::program::NewWord;

/// A block may take so much less of its time before its F is lowered (share).
const SAME_TIME: f64 = 0.01;
/// A linear path shorter than this is none: F then counts degrees [program units].
const PURELY_ROTARY_UNITS: f64 = 1e-9;

/// Time's measure of a motion between these words: the length F counts along, and the turn.
pub(super) fn travel(ends: [&AxisWords; 2], mm_per_unit: f64) -> BlockTime {
    let [from, to] = ends;
    let delta = |k: usize| to.linear_mm[k] - from.linear_mm[k];
    let path_mm = (delta(0) * delta(0) + delta(1) * delta(1) + delta(2) * delta(2)).sqrt();
    let turn = |k: usize| (to.rotary_deg[k] - from.rotary_deg[k]).abs();
    BlockTime { path_units: path_mm / mm_per_unit, turn_deg: turn(0).max(turn(1)) }
}

/// The lower F that a block needs because F counts along a shorter path now, or along millimetres instead of
/// degrees: a purely rotary block that gains 0.02 mm of X would run through its degrees in no time. `None`: the
/// source's F serves.
///
/// # Errors
/// The F is not known where its meaning changes, or too small to be written.
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
    let (before, after) = (travel([start, end], motion.mm_per_unit), travel(written, motion.mm_per_unit));
    // In G95 the same lengths count along the turns of the spindle.
    let share = feed_word(mode.unwrap_or(FeedMode::PerMinute), 1.0, &before, &after, 1.0);
    let Some(share) = share.filter(|share| *share < 1.0 - SAME_TIME) else { return Ok(None) };
    if value.is_none() {
        let is_rotary = |time: &BlockTime| time.path_units <= PURELY_ROTARY_UNITS;
        let changes = is_rotary(&before) != is_rotary(&after);
        return if changes { Err(LineFaultKind::FeedUnknown) } else { Ok(None) };
    }
    let feed = raw * share;
    if feed < MIN_FEED {
        return Err(LineFaultKind::FeedTooSmall { feed, min: MIN_FEED });
    }
    Ok(Some(rounded_feed(&motion.feed, feed)))
}
