//! Into which parts a block over tolerance is divided.

use super::fault::LineFaultKind;
use super::judge::Checked;
use super::survey::Survey;
use super::{CcParameters, OutputForm};
use crate::contact::{
    BlockTime, Correction, Effort, Node, Resolution, block_time_s, divide, feed_word, nodes, prove, segments,
};
use crate::machine::Machine;
use crate::motion::{FeedMode, Motion};
use crate::units::UM_PER_MM;

/// Plans keep this share of the tolerance free, so that what sampling and rounding leave open cannot exceed it.
const RESERVE: f64 = 2e-4;
/// Most parts of one block: two hundred seconds of two-millisecond steps.
const MAX_PARTS: f64 = 100_000.0;
/// Smallest F that is written, in the program's own unit.
pub(super) const MIN_FEED: f64 = 1e-6;

/// A block that is divided: where its parts end, and with which decimals.
#[derive(Debug, Clone)]
pub(super) struct Division {
    pub(super) nodes: Vec<Node>,
    pub(super) resolution: Resolution,
    /// Whether the parts can carry F words: there is a feed, and in a table a column for it.
    pub(super) carries_feed: bool,
}

/// Plans the division of a block over tolerance. Where the effort is over then, it means nothing.
///
/// # Errors
/// What is wrong with the line.
pub(super) fn plan(
    parameters: &CcParameters,
    machine: &Machine,
    survey: Survey,
    checked: &Checked<'_>,
    motion: &Motion,
    effort: &mut Effort<'_>,
) -> Result<Division, LineFaultKind> {
    if motion.feed.mode == Some(FeedMode::InverseTime) && motion.feed.value.is_none() {
        return Err(LineFaultKind::NoInverseTime);
    }
    if motion.extra.is_some_and(|extra| extra.start.is_none()) {
        return Err(LineFaultKind::ExtraUnknown);
    }
    let tolerance_mm = parameters.tolerance.mm();
    let own = resolution(checked, motion, motion.decimals.linear, motion.decimals.rotary);
    // Posts strip trailing zeros: where the block's own decimals are too coarse, the program's finest count.
    let finest = resolution(
        checked,
        motion,
        motion.decimals.linear.max(survey.linear_decimals),
        motion.decimals.rotary.max(survey.rotary_decimals),
    );
    let mut reachable_mm = f64::INFINITY;
    let tries: &[Resolution] = if own == finest { &[own] } else { &[own, finest] };
    for resolution in tries {
        match divided(parameters, machine, checked, motion, resolution, effort)? {
            Ok(nodes) => {
                let carries_feed = motion.feed.value.is_some() && survey.has_feed_column;
                if carries_feed {
                    check_feeds(checked, motion, &nodes)?;
                }
                return Ok(Division { nodes, resolution: *resolution, carries_feed });
            }
            Err(mm) => reachable_mm = reachable_mm.min(mm),
        }
    }
    Err(LineFaultKind::ToleranceOutOfReach {
        reachable_um: reachable_mm * UM_PER_MM,
        tolerance_um: tolerance_mm * UM_PER_MM,
    })
}

/// The nodes, or the smallest deviation that can be reached.
fn divided(
    parameters: &CcParameters,
    machine: &Machine,
    checked: &Checked<'_>,
    motion: &Motion,
    resolution: &Resolution,
    effort: &mut Effort<'_>,
) -> Result<Result<Vec<Node>, f64>, LineFaultKind> {
    let (block, correction) = (&checked.block, parameters.correction);
    let within_mm = parameters.tolerance.mm() * (1.0 - RESERVE);
    Ok(match parameters.output {
        OutputForm::Minimal if correction == Correction::Seed => {
            let ratio = checked.before.max_mm / parameters.tolerance.mm();
            Ok(nodes(block, correction, count(ratio.sqrt())?, resolution, effort))
        }
        OutputForm::Minimal => {
            divide(block, correction, checked.before.max_mm, within_mm, resolution, effort)
        }
        OutputForm::Interpolated => {
            let parts = interpolation_steps(machine, checked, motion)?;
            let nodes = nodes(block, correction, parts, resolution, effort);
            if correction == Correction::Seed {
                Ok(nodes)
            } else {
                prove(block, &nodes, within_mm, effort).map(|()| nodes)
            }
        }
    })
}

pub(super) fn resolution(
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

/// P0's `n = max(1, ⌈τ/T⌉)`.
fn interpolation_steps(
    machine: &Machine,
    checked: &Checked<'_>,
    motion: &Motion,
) -> Result<u32, LineFaultKind> {
    let time = BlockTime::of(&checked.block, &checked.block.whole(), motion.mm_per_unit, motion.feed.paths);
    let (Some(mode), Some(_)) = (motion.feed.mode, motion.feed.value) else {
        return Err(LineFaultKind::NoFeed);
    };
    let tau_s = block_time_s(mode, motion.feed.raw, &time).ok_or(LineFaultKind::NoFeed)?;
    count(tau_s / machine.interpolation_period_s())
}

/// Rounds up to at least one, refusing what no program would want.
fn count(parts: f64) -> Result<u32, LineFaultKind> {
    if !(0.0..=MAX_PARTS).contains(&parts) {
        return Err(LineFaultKind::TooManyParts { parts, max: MAX_PARTS });
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "in 1 ..= MAX_PARTS")]
    Ok(parts.ceil().max(1.0) as u32)
}

/// Every part must get an F that can be written.
pub(super) fn check_feeds(
    checked: &Checked<'_>,
    motion: &Motion,
    nodes: &[Node],
) -> Result<(), LineFaultKind> {
    let source = BlockTime::of(&checked.block, &checked.block.whole(), motion.mm_per_unit, motion.feed.paths);
    for segment in segments(&checked.block, nodes) {
        let share = segment.fraction[1] - segment.fraction[0];
        let part = BlockTime::of(&checked.block, &segment, motion.mm_per_unit, motion.feed.paths);
        let feed = motion
            .feed
            .mode
            .and_then(|mode| feed_word(mode, motion.feed.raw, &source, &part, share))
            .unwrap_or(0.0);
        if feed < MIN_FEED {
            return Err(LineFaultKind::FeedTooSmall { feed, min: MIN_FEED });
        }
    }
    Ok(())
}
