//! The time a block takes, and the F words that let inserted blocks share it.

use super::{Segment, SourceBlock};
use crate::geometry::Vec3;
use crate::motion::{FeedMode, Interpolation};
use crate::units::S_PER_MIN;

/// A linear path shorter than this is none: the block is purely rotary \[mm or inch\].
const PURELY_ROTARY_UNITS: f64 = 1e-9;

/// What a block's time depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlockTime {
    /// Length that F in G94 is measured along: words in machine interpolation, tip in W with TCP, in program units
    /// (mm or inch).
    pub path_units: f64,
    /// Largest rotary travel \[deg\].
    pub turn_deg: f64,
}

impl BlockTime {
    /// Of a segment of a block; a program unit is `mm_per_unit` millimetres.
    #[must_use]
    pub fn of(block: &SourceBlock<'_>, segment: &Segment, mm_per_unit: f64) -> Self {
        let [a, b] = segment.ends;
        let path_mm = match block.mode {
            Interpolation::Machine => (Vec3::from(b.words.linear_mm) - Vec3::from(a.words.linear_mm)).norm(),
            Interpolation::Tcp => (b.pose.tip_mm - a.pose.tip_mm).norm(),
        };
        let turn = |k: usize| (b.words.rotary_deg[k] - a.words.rotary_deg[k]).abs();
        Self { path_units: path_mm / mm_per_unit, turn_deg: turn(0).max(turn(1)) }
    }

    /// What F counts along: program units, or degrees where the block is purely rotary.
    fn travel(&self) -> f64 {
        if self.path_units > PURELY_ROTARY_UNITS { self.path_units } else { self.turn_deg }
    }
}

/// The time τ of a block \[s\] for `feed` in program units per minute (§2, P0's steps): `60·D/F` in G94, `60/F` in G93, `60·max|Δθ|/F` where it is purely
/// rotary. `None` in G95, where the spindle speed decides, or where F is not positive.
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

/// The F value of an inserted block of share `share` of the source block, so that it takes `τ·share`:
/// G93 `F/Δu`; G94 and G95 `F·travel_j/(travel·Δu)`, which is `60·|Δq_j|/τ_j`.
///
/// `None` where the source block has no travel that F could be measured along.
#[must_use]
pub fn feed_word(mode: FeedMode, feed: f64, source: &BlockTime, part: &BlockTime, share: f64) -> Option<f64> {
    let value = match mode {
        FeedMode::InverseTime => feed / share,
        FeedMode::PerMinute | FeedMode::PerRevolution => feed * part.travel() / (source.travel() * share),
    };
    (value.is_finite() && value > 0.0).then_some(value)
}
