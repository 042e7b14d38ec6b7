//! Measures what the motions of a region need as uploaded.

use super::figures::{figures, time_s};
use super::pending::Pending;
use super::planner::Planner;
use super::report::{RegionFigures, RegionTreatment, SingularRegion};
use crate::contact::Effort;
use crate::kinematics::Singularity;
use crate::process::fault::{Fault, go_on};
use crate::units::Angle;

/// The figures of a region.
pub(super) struct Measured {
    /// The figures of each motion.
    pub(super) each: Vec<RegionFigures>,
    /// The figures of all motions together.
    pub(super) before: RegionFigures,
    /// The singularity where the region comes nearest to one.
    pub(super) nearest: Singularity,
}

/// Measures the motions of a region with a planner for its first motion. `None` if the region is empty.
pub(super) fn measured(
    planner: &Planner<'_>,
    region: &[Pending],
    effort: &mut Effort<'_>,
) -> Result<Option<Measured>, Fault> {
    let limits = planner.limits();
    let mut before = RegionFigures::default();
    let mut each = Vec::with_capacity(region.len());
    let mut nearest: Option<Singularity> = None;
    for pending in region {
        let block = planner.block(pending, effort);
        let time = time_s(&block, &pending.motion);
        let found = figures(&block, &block.whole(), time, &limits, effort);
        go_on(effort)?;
        before.take(&found);
        each.push(found);
        for polar_rad in pending.polar_rad {
            let found = planner.cutting.kinematics.singularity_at(polar_rad);
            if nearest.is_none_or(|least| found.gain < least.gain) {
                nearest = Some(found);
            }
        }
    }
    Ok(nearest.map(|nearest| Measured { each, before, nearest }))
}

/// An untreated region with these first and last motions.
pub(super) fn as_uploaded(
    [first, last]: [&Pending; 2],
    motions: usize,
    before: RegionFigures,
    nearest: &Singularity,
) -> SingularRegion {
    SingularRegion {
        first_line: first.motion.line,
        last_line: last.motion.line,
        motions: motions as u64,
        kind: nearest.kind,
        least_angle: Angle::from_rad(nearest.angle_rad),
        least_gain: nearest.gain,
        before,
        after: None,
        treatment: RegionTreatment::Reported,
    }
}
