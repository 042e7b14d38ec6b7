//! A bound on the second derivative of the contact path, so that samples bound the values between them.

use super::{Carry, Segment, SourceBlock, Station};
use crate::geometry::Vec3;
use crate::kinematics::Kinematics;
use crate::machine::Tool;
use crate::motion::Interpolation;

/// How the contact swings over the tool during a stretch of motion: the values that a bound needs.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Swing {
    /// The tip is used as the contact.
    Tip,
    /// By its normal: the angle it turns, its directions and lengths at the ends.
    Normal {
        /// Angle turned \[rad\].
        arc_rad: f64,
        /// n at both ends.
        directions: [Vec3; 2],
        /// |n| at both ends of the stretch.
        magnitude: [f64; 2],
    },
    /// As a carried offset: the same for m, with axial and radial lengths at the ends.
    Offset {
        /// Angle turned \[rad\].
        arc_rad: f64,
        /// m at both ends.
        directions: [Vec3; 2],
        /// Along t at the ends \[mm\].
        axial_mm: [f64; 2],
        /// Away from t at the ends \[mm\].
        radial_mm: [f64; 2],
    },
}

impl SourceBlock<'_> {
    /// An upper bound on `|c″|` \[mm\], derivatives by the segment's own fraction s in [0, 1] (§2 "Between
    /// samples"): with N equal steps the true maximum is at most the sampled one plus `|c″|/(8N²)`.
    ///
    /// `None` if no bound exists: the side of the contact may turn right round while the normal passes near the
    /// tool axis. Valid for table, head and mixed machines: the tip's own share comes from
    /// [`crate::kinematics::Kinematics::tip_curvature_bound_mm`].
    #[must_use]
    pub fn curvature_bound_mm(&self, segment: &Segment) -> Option<f64> {
        let share = segment.fraction[1] - segment.fraction[0];
        let between = |ends: &[f64; 2]| segment.fraction.map(|u| ends[0] + (ends[1] - ends[0]) * u);
        let swing = match &self.carry {
            Carry::Tip => Swing::Tip,
            Carry::Normal { normal, magnitude } => Swing::Normal {
                arc_rad: normal.angle_rad() * share,
                directions: segment.fraction.map(|u| normal.at(u)),
                magnitude: between(magnitude),
            },
            Carry::Offset { axial_mm, radial_mm, inward } => Swing::Offset {
                arc_rad: inward.angle_rad() * share,
                directions: segment.fraction.map(|u| inward.at(u)),
                axial_mm: between(axial_mm),
                radial_mm: between(radial_mm),
            },
        };
        curvature_bound_mm(&self.kinematics, &self.tool, self.mode, segment.ends.each_ref(), &swing)
    }
}

/// [`SourceBlock::curvature_bound_mm`] of a stretch of motion between two stations.
#[inline]
pub(crate) fn curvature_bound_mm(
    kinematics: &Kinematics,
    tool: &Tool,
    mode: Interpolation,
    ends: [&Station; 2],
    swing: &Swing,
) -> Option<f64> {
    let [a, b] = ends;
    let turns: [f64; 2] =
        std::array::from_fn(|k| (b.words.rotary_deg[k] - a.words.rotary_deg[k]).abs().to_radians());
    let turn = turns[0] + turns[1];
    let tip = match mode {
        Interpolation::Tcp => 0.0,
        Interpolation::Machine => kinematics.tip_curvature_bound_mm(
            [a, b].map(|end| Vec3::from(end.words.linear_mm)),
            [a.pose.tip_mm, b.pose.tip_mm],
            turns,
        ),
    };
    let (corner, core) = (tool.corner_radius().mm(), tool.core_radius().mm());
    let largest = |ends: &[f64; 2]| ends[0].abs().max(ends[1].abs());
    let growth = |ends: &[f64; 2]| (ends[1] - ends[0]).abs();
    match swing {
        Swing::Tip => Some(tip),
        Swing::Normal { arc_rad: arc, directions, magnitude } => {
            let ball =
                corner * (turn * turn + largest(magnitude) * arc * arc + 2.0 * growth(magnitude) * arc);
            let side = if core > 0.0 { core * side_curvature(ends, directions, turn, *arc)?.1 } else { 0.0 };
            Some(tip + ball + side)
        }
        Swing::Offset { arc_rad: arc, directions, axial_mm, radial_mm } => {
            let (first, second) = side_curvature(ends, directions, turn, *arc)?;
            let axial = largest(axial_mm) * turn * turn + 2.0 * growth(axial_mm) * turn;
            let radial = largest(radial_mm) * second + 2.0 * growth(radial_mm) * first;
            Some(tip + axial + radial)
        }
    }
}

/// Bounds on |m′| and |m″|. m is the projection, across the turning axis, of a direction that turns by `arc`.
/// With Ψ = Ω + arc and s = sin(min over both ends of (ψ, π − ψ) − Ψ/2): `|m″| ≤ √5·Ψ²/s² + 2ΩΨ/s + Ω²`. `None`
/// if that angle is not positive.
///
/// s is taken slightly too small, by `cos(Ψ/2) ≥ 1 − Ψ²/8` and `sin(Ψ/2) ≤ Ψ/2`, to save the trigonometry.
fn side_curvature(ends: [&Station; 2], directions: &[Vec3; 2], turn: f64, arc: f64) -> Option<(f64, f64)> {
    let swing = turn + arc;
    let half = 0.5 * swing;
    let clear = |k: usize| {
        let (direction, axis) = (directions[k], ends[k].pose.axis);
        direction.cross(&axis).norm() * (1.0 - 0.5 * half * half) - direction.dot(&axis).abs() * half
    };
    let s = clear(0).min(clear(1));
    if half >= 1.0 || s <= 0.0 {
        return None;
    }
    let first = swing / s + turn;
    Some((first, 5.0_f64.sqrt() * (swing / s).powi(2) + 2.0 * turn * swing / s + turn * turn))
}
