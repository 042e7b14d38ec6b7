//! The time a block takes, and the F words that let inserted blocks share it.

use super::{Segment, SourceBlock};
use crate::geometry::Vec3;
use crate::motion::{AxisWords, FeedMode, FeedPath, FeedPaths};
use crate::units::S_PER_MIN;

/// A linear path shorter than this has no length: the block is purely rotary \[mm or inch\].
const PURELY_ROTARY_UNITS: f64 = 1e-9;

/// The values on which a block's time depends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockTime {
    /// The length along which an F as a speed counts, in program units (mm or inch).
    pub path_units: f64,
    /// Largest rotary travel \[deg\].
    pub turn_deg: f64,
}

impl BlockTime {
    /// The values of a segment of a block. A program unit is `mm_per_unit` millimetres, and a speed counts along
    /// `paths`.
    #[must_use]
    pub fn of(block: &SourceBlock<'_>, segment: &Segment, mm_per_unit: f64, paths: FeedPaths) -> Self {
        let [a, b] = segment.ends;
        let by_words = Self::of_words([&a.words, &b.words], mm_per_unit);
        match paths.of(block.mode) {
            FeedPath::LinearAxes => by_words,
            FeedPath::Tip => {
                Self { path_units: (b.pose.tip_mm - a.pose.tip_mm).norm() / mm_per_unit, ..by_words }
            }
        }
    }

    /// The values of a motion between words whose X Y Z are the path along which a speed counts: of the axes, or of
    /// the tip under tool-centre-point control.
    #[must_use]
    pub fn of_words(ends: [&AxisWords; 2], mm_per_unit: f64) -> Self {
        let [a, b] = ends;
        let path_mm = (Vec3::from(b.linear_mm) - Vec3::from(a.linear_mm)).norm();
        let turn = |k: usize| (b.rotary_deg[k] - a.rotary_deg[k]).abs();
        Self { path_units: path_mm / mm_per_unit, turn_deg: turn(0).max(turn(1)) }
    }

    /// Whether only rotary axes move, and F counts degrees.
    #[must_use]
    pub fn is_purely_rotary(&self) -> bool {
        self.path_units <= PURELY_ROTARY_UNITS
    }

    /// The length along which F counts: program units, or degrees if the block is purely rotary.
    fn travel(&self) -> f64 {
        if self.is_purely_rotary() { self.turn_deg } else { self.path_units }
    }
}

/// The time τ of a block \[s\] for `feed` in program units per minute (§2, P0's steps): `60·D/F` in G94, `60/F` in
/// G93, `60·max|Δθ|/F` if it is purely rotary. `None` in G95, where the spindle speed decides, or if F is not
/// positive.
#[must_use]
pub fn block_time_s(mode: FeedMode, feed: f64, time: &BlockTime) -> Option<f64> {
    if feed.is_nan() || feed <= 0.0 {
        return None;
    }
    match mode {
        FeedMode::PerMinute => Some(S_PER_MIN * time.travel() / feed),
        FeedMode::InverseTime => Some(S_PER_MIN / feed),
        FeedMode::PerRevolution => None,
    }
}

/// The F value of an inserted block with the share `share` of the source block, so that it takes `τ·share`: G93
/// `F/Δu`; G94 and G95 `F·travel_j/(travel·Δu)`, which is `60·|Δq_j|/τ_j`.
///
/// `None` if the source block has no travel along which F counts.
#[must_use]
pub fn feed_word(mode: FeedMode, feed: f64, source: &BlockTime, part: &BlockTime, share: f64) -> Option<f64> {
    let value = match mode {
        FeedMode::InverseTime => feed / share,
        FeedMode::PerMinute | FeedMode::PerRevolution => feed * part.travel() / (source.travel() * share),
    };
    (value.is_finite() && value > 0.0).then_some(value)
}
