//! A division: where the parts of a block end, and whether their F words can be written.

use super::checked::Checked;
use crate::contact::{BlockTime, Node, Resolution, segments};
use crate::motion::Motion;
use crate::process::pipeline::{FeedInTime, feed_in_time};
use crate::units::Feedrate;

/// A block that is divided: where its parts end, and with which decimals.
#[derive(Debug, Clone)]
pub(in crate::process) struct Division {
    pub(in crate::process) nodes: Vec<Node>,
    pub(in crate::process) resolution: Resolution,
    /// Whether the parts can carry F words: a feed is known, and a table has a column for it.
    pub(in crate::process) carries_feed: bool,
}

/// The resolution of the parts: these decimals, in G91 the place from which words count, and the tilted plane.
pub(in crate::process) fn resolution(
    checked: &Checked<'_>,
    motion: &Motion,
    linear_decimals: u8,
    rotary_decimals: u8,
) -> Resolution {
    let axis_decimals = motion.tool_axis.map(|_| rotary_decimals);
    let absolute = Resolution::absolute(linear_decimals, rotary_decimals, motion.mm_per_unit);
    let absolute = Resolution { axis_decimals, frame: motion.frame, ..absolute };
    if motion.incremental {
        Resolution { origin: motion.stated(checked.block.ends[0].words), ..absolute }
    } else {
        absolute
    }
}

/// The first F word of the parts that is too small or too fast; `None` if all can be written.
pub(in crate::process) fn unfit_feed(
    checked: &Checked<'_>,
    motion: &Motion,
    nodes: &[Node],
    max_feed: Option<Feedrate>,
) -> Option<FeedInTime> {
    let source = BlockTime::of(&checked.block, &checked.block.whole(), motion.mm_per_unit, motion.feed.paths);
    segments(&checked.block, nodes).find_map(|segment| {
        let share = segment.fraction[1] - segment.fraction[0];
        let part = BlockTime::of(&checked.block, &segment, motion.mm_per_unit, motion.feed.paths);
        match feed_in_time(motion, [&source, &part], share, max_feed) {
            Some(FeedInTime::Fits(_)) => None,
            unfit => Some(unfit.unwrap_or(FeedInTime::TooLow(0.0))),
        }
    })
}
