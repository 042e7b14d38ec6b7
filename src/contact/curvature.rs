//! A bound on the contact path's second derivative, so that samples speak for what lies between them.

use super::{Carry, Segment, SourceBlock};
use crate::geometry::{Vec3, angle_between};
use crate::motion::Interpolation;

impl SourceBlock<'_> {
    /// An upper bound on `|c″|` \[mm\], derivatives by the segment's own fraction s in [0, 1] (§2 "Between
    /// samples"): with N equal steps the true maximum is at most the sampled one plus `|c″|/(8N²)`.
    ///
    /// `None` where no bound exists: the contact's side may swing right round while the normal passes near the
    /// tool axis. Valid for table, head and mixed machines: the tip's own share comes from
    /// [`crate::kinematics::Kinematics::tip_curvature_bound_mm`].
    #[must_use]
    pub fn curvature_bound_mm(&self, segment: &Segment) -> Option<f64> {
        let turn: f64 = (0..2).map(|k| turn_rad(segment, k)).sum();
        let tip = match self.mode {
            Interpolation::Tcp => 0.0,
            Interpolation::Machine => {
                let [a, b] = segment.ends.map(|end| Vec3::from(end.words.linear_mm));
                let turns = std::array::from_fn(|k| turn_rad(segment, k));
                self.kinematics.tip_curvature_bound_mm([a, b], segment.ends.map(|end| end.pose.tip_mm), turns)
            }
        };
        let share = segment.fraction[1] - segment.fraction[0];
        let (corner, core) = (self.tool.corner_radius().mm(), self.tool.core_radius().mm());
        match &self.carry {
            Carry::Tip => Some(tip),
            Carry::Normal { normal, magnitude } => {
                let arc = normal.angle_rad() * share;
                let [from, to] = *magnitude;
                let scale = from.max(to);
                let growth = (to - from).abs() * share;
                let ball = corner * (turn * turn + scale * arc * arc + 2.0 * growth * arc);
                let swing = if core > 0.0 {
                    let directions = segment.fraction.map(|u| normal.at(u));
                    core * side_curvature(segment, directions, turn, arc)?.1
                } else {
                    0.0
                };
                Some(tip + ball + swing)
            }
            Carry::Offset { axial_mm, radial_mm, inward } => {
                let arc = inward.angle_rad() * share;
                let largest = |ends: &[f64; 2]| ends[0].abs().max(ends[1].abs());
                let growth = |ends: &[f64; 2]| (ends[1] - ends[0]).abs() * share;
                let directions = segment.fraction.map(|u| inward.at(u));
                let (first, second) = side_curvature(segment, directions, turn, arc)?;
                let axial = largest(axial_mm) * turn * turn + 2.0 * growth(axial_mm) * turn;
                let radial = largest(radial_mm) * second + 2.0 * growth(radial_mm) * first;
                Some(tip + axial + radial)
            }
        }
    }
}

/// Bounds on |m′| and |m″| for m the projection, across the turning axis, of a direction that runs `arc`:
/// with Ψ = Ω + arc and s = sin(min over both ends of (ψ, π − ψ) − Ψ/2):
/// `|m″| ≤ √5·Ψ²/s² + 2ΩΨ/s + Ω²`. `None` where that angle is not positive.
fn side_curvature(segment: &Segment, directions: [Vec3; 2], turn: f64, arc: f64) -> Option<(f64, f64)> {
    let swing = turn + arc;
    let nearest = segment
        .ends
        .iter()
        .zip(directions)
        .map(|(end, direction)| {
            let angle = angle_between(direction, end.pose.axis);
            angle.min(std::f64::consts::PI - angle)
        })
        .fold(f64::INFINITY, f64::min);
    let clear = nearest - swing / 2.0;
    if clear <= 0.0 {
        return None;
    }
    let s = clear.sin();
    let first = swing / s + turn;
    Some((first, 5.0_f64.sqrt() * (swing / s).powi(2) + 2.0 * turn * swing / s + turn * turn))
}

fn turn_rad(segment: &Segment, k: usize) -> f64 {
    let [a, b] = segment.ends;
    (b.words.rotary_deg[k] - a.words.rotary_deg[k]).abs().to_radians()
}
