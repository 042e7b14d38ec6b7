//! The demands of one motion on the rotary axes, and the deviation of contact and tool axis along it.

use super::report::RegionFigures;
use crate::contact::{BlockTime, Effort, Segment, SourceBlock, block_time_s, sample_until_sure};
use crate::geometry::{GreatCircle, angle_between};
use crate::motion::Motion;
use crate::units::{Angle, Length};

/// Samples of the tool axis leave this share of the tolerance open.
const OPEN_SHARE: f64 = 0.02;
/// Largest and smallest number of steps along one motion.
const MAX_STEPS: f64 = 4096.0;
const MIN_STEPS: f64 = 8.0;

/// The angle between tool axis and great circle along a segment.
#[derive(Debug, Clone, Copy)]
pub(super) struct AxisDeviation {
    /// Largest sampled angle \[rad\].
    pub(super) sampled_rad: f64,
    /// Bound on the excess over it between samples \[rad\].
    pub(super) open_rad: f64,
    pub(super) evaluations: u64,
}

/// The great circle between the directions at the ends of a block.
pub(super) fn great_circle(block: &SourceBlock<'_>) -> GreatCircle {
    let [start, end] = block.ends;
    GreatCircle::between(start.pose.axis, end.pose.axis, start.pose.tip_mm)
}

/// The deviation of the tool axis from the great circle of its block along one segment, if both run at constant
/// rates. Each bends by no more than the squares of its angles, so `|e″| ≤ Ω² + α²` bounds the deviation between
/// samples.
pub(super) fn axis_deviation(
    block: &SourceBlock<'_>,
    segment: &Segment,
    arc: &GreatCircle,
    tolerance_rad: f64,
) -> AxisDeviation {
    let [from, to] = segment.fraction;
    let turns = rotary_steps_deg(segment).map(f64::to_radians);
    let bend = (turns[0] + turns[1]).powi(2) + (arc.angle_rad() * (to - from)).powi(2);
    let steps = (bend / (8.0 * OPEN_SHARE * tolerance_rad)).sqrt().ceil().clamp(MIN_STEPS, MAX_STEPS);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
    let count = steps as u32;
    let mut sampled_rad: f64 = 0.0;
    for index in 0..=count {
        let s = f64::from(index) / steps;
        let axis = block.pose_at(segment, s).axis;
        sampled_rad = sampled_rad.max(angle_between(axis, arc.at(from + (to - from) * s)));
    }
    AxisDeviation { sampled_rad, open_rad: bend / (8.0 * steps * steps), evaluations: u64::from(count) + 1 }
}

/// The turns of both rotary axes in a segment \[deg\], in profile order.
pub(super) fn rotary_steps_deg(segment: &Segment) -> [f64; 2] {
    let [a, b] = segment.ends.map(|end| end.words.rotary_deg);
    [(b[0] - a[0]).abs(), (b[1] - a[1]).abs()]
}

/// The time of the whole block \[s\], if its feed gives one.
pub(super) fn time_s(block: &SourceBlock<'_>, motion: &Motion) -> Option<f64> {
    let (mode, _) = motion.feed.mode.zip(motion.feed.value)?;
    let time = BlockTime::of(block, &block.whole(), motion.mm_per_unit, motion.feed.paths);
    block_time_s(mode, motion.feed.raw, &time).filter(|time_s| time_s.is_finite() && *time_s > 0.0)
}

/// The limits for the figures of a motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub(super) tolerance_mm: f64,
    pub(super) axis_tolerance_rad: f64,
    pub(super) max_deg_per_s: f64,
}

/// The figures of a segment of a block. `time_s` is the time of the whole block.
pub(super) fn figures(
    block: &SourceBlock<'_>,
    segment: &Segment,
    time_s: Option<f64>,
    limits: &Limits,
    effort: &mut Effort<'_>,
) -> RegionFigures {
    let steps = rotary_steps_deg(segment);
    let step_deg = steps[0].max(steps[1]);
    let speed = time_s.map(|time_s| step_deg / (time_s * (segment.fraction[1] - segment.fraction[0])));
    let axis = axis_deviation(block, segment, &great_circle(block), limits.axis_tolerance_rad);
    let contact = sample_until_sure(block, segment, limits.tolerance_mm);
    effort.spend(axis.evaluations + contact.evaluations);
    RegionFigures {
        rotary_deg_per_s: speed,
        motions_over_speed: u64::from(speed.is_some_and(|speed| speed > limits.max_deg_per_s)),
        step_deg,
        travel_deg: steps[0] + steps[1],
        deviation: Length::from_mm(contact.max_mm),
        axis_deviation: Angle::from_rad(axis.sampled_rad),
    }
}
