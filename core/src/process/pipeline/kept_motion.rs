//! What must not change in a block that a step leaves unchanged.

use super::read_back::failed;
use crate::geometry::PlaneFrame;
use crate::motion::{
    AxisWords, ContactWords, Extra, FeedMode, Interpolation, Motion, MotionKind, Unfollowable,
};
use crate::process::fault::Fault;

/// Words that are read back may differ by this from the planned ones, because inches and increments pass through
/// binary fractions \[mm or deg\].
pub(in crate::process) const SAME_READ_BACK: f64 = 1e-7;
/// The same for words so large that double precision has no such difference: some roundings of a tilted plane, as a share
/// of the word.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Half a unit of the last decimal on three axes. Squareness errors stretch it a little.
pub(in crate::process) const LINEAR_ROUNDING: f64 = 1.732_050_808 * 1.1;
/// Error of arithmetic with inches and increments \[mm\].
pub(in crate::process) const ARITHMETIC_MM: f64 = 1e-7;

/// The properties of a motion that must not change in a block that is left unchanged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::process) struct KeptMotion {
    /// Its line of the source.
    pub(in crate::process) line: u64,
    pub(in crate::process) kind: MotionKind,
    interpolation: Interpolation,
    frame: Option<PlaneFrame>,
    unfollowable: Option<Unfollowable>,
    offset_changed: bool,
    feed_mode: Option<FeedMode>,
    feed: Option<f64>,
    contact: ContactWords,
    extra: Option<Extra>,
    incremental: bool,
    exact_stop: bool,
    mm_per_unit: f64,
    start: Option<AxisWords>,
    end: Option<AxisWords>,
}

impl KeptMotion {
    pub(in crate::process) fn of(motion: &Motion) -> Self {
        Self {
            line: motion.line,
            kind: motion.kind,
            interpolation: motion.interpolation,
            frame: motion.frame,
            unfollowable: motion.unfollowable,
            offset_changed: motion.offset_changed,
            feed_mode: motion.feed.mode,
            feed: stated_feed(motion),
            contact: motion.contact,
            extra: motion.extra,
            incremental: motion.incremental,
            exact_stop: motion.exact_stop,
            mm_per_unit: motion.mm_per_unit,
            start: motion.start,
            end: motion.end,
        }
    }

    /// Checks that a motion that was read back has this meaning, apart from its line.
    pub(in crate::process) fn check(&self, read: &Motion) -> Result<(), Fault> {
        if !same_words(read.start, self.start) || !same_words(read.end, self.end) {
            return Err(failed(self.line, "a motion is not where it was planned"));
        }
        // A rapid has no feed of its own. The next block that uses the modal feed restores it.
        let same_feed = self.kind == MotionKind::Rapid || stated_feed(read) == self.feed;
        let same = same_feed
            && read.kind == self.kind
            && read.interpolation == self.interpolation
            && read.frame == self.frame
            && read.unfollowable == self.unfollowable
            && read.offset_changed == self.offset_changed
            && read.feed.mode == self.feed_mode
            && read.contact == self.contact
            && read.extra == self.extra
            && read.incremental == self.incremental
            && read.exact_stop == self.exact_stop
            && read.mm_per_unit.total_cmp(&self.mm_per_unit).is_eq();
        if same { Ok(()) } else { Err(failed(self.line, "a motion changed its meaning or its feed")) }
    }
}

/// F as written, if it states a feed.
fn stated_feed(motion: &Motion) -> Option<f64> {
    motion.feed.value.map(|_| motion.feed.raw)
}

/// Whether these words are the same, or both are unknown.
pub(in crate::process) fn same_words(a: Option<AxisWords>, b: Option<AxisWords>) -> bool {
    let same = |a: f64, b: f64| (a - b).abs() <= SAME_READ_BACK.max(ROUNDING * a.abs());
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| same(*a, *b));
    match (a, b) {
        (None, None) => true,
        (Some(a), Some(b)) => near(&a.linear_mm, &b.linear_mm) && near(&a.rotary_deg, &b.rotary_deg),
        _ => false,
    }
}
