//! A bound on the curvature of the tip's path in W while all five words run linearly.

use super::Kinematics;
use crate::geometry::Vec3;

/// Up to this total turn of the table axes \[rad\], the path's own length bounds the distance from the axis.
const SHORT_TURN_RAD: f64 = 1.0;

/// The part of the bound that depends on the machine alone. Plain numbers, so that loops over many motions can be
/// compiled for AVX2 and AVX-512.
#[derive(Debug, Clone, Copy)]
pub struct TipCurvature {
    /// Profile index of the axis next to the workpiece, and of the axis next to the tool.
    profile_index: [usize; 2],
    head_axes: usize,
    /// Columns of the directions of the linear axes.
    columns: [[f64; 3]; 3],
    work_offset_mm: [f64; 3],
    /// A point of the axis next to the workpiece \[mm\].
    point_mm: [f64; 3],
    /// Distance between the table axes; 0 if at most one axis is in the table \[mm\].
    table_between_mm: f64,
    /// The tip's distance along the chain of pivots \[mm\].
    head_reach_mm: f64,
}

impl Kinematics {
    /// The machine's part of [`Self::tip_curvature_bound_mm`].
    #[must_use]
    pub fn tip_curvature(&self) -> TipCurvature {
        let [u, v] = &self.screws;
        let between = (u.point_mm - v.point_mm).norm();
        let head_reach_mm = match self.head_axes {
            0 => 0.0,
            1 => v.point_mm.norm(),
            _ => v.point_mm.norm() + between,
        };
        TipCurvature {
            profile_index: self.profile_index,
            head_axes: self.head_axes,
            columns: self.linear_directions.into(),
            work_offset_mm: self.work_offset_mm.into(),
            point_mm: u.point_mm.into(),
            table_between_mm: if self.head_axes == 0 { between } else { 0.0 },
            head_reach_mm,
        }
    }

    /// An upper bound on `|w″|` \[mm\], derivatives by the block's fraction. The block's linear words run from
    /// `linear_mm[0]` to `linear_mm[1]`, its tips in W are `tips_mm`, and its rotary axes turn by `turns_rad`
    /// (magnitudes, profile order).
    ///
    /// For table axes this is §2's `Ω²ρ + 2Ω|Δq|` with `ρ = max|w + o − p_1| + |p_1 − p_2|`. Head axes add their
    /// own circle `Ω_h²ρ_h` about the pivots; `ρ_h` is the tip's distance along the chain of pivots.
    #[must_use]
    #[inline]
    pub fn tip_curvature_bound_mm(
        &self,
        linear_mm: [Vec3; 2],
        tips_mm: [Vec3; 2],
        turns_rad: [f64; 2],
    ) -> f64 {
        let plain = |of: [Vec3; 2]| of.map(<[f64; 3]>::from);
        self.tip_curvature().bound_mm(plain(linear_mm), plain(tips_mm), turns_rad)
    }
}

impl TipCurvature {
    /// [`Kinematics::tip_curvature_bound_mm`].
    #[must_use]
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "compiled into loops for several instruction sets")]
    pub fn bound_mm(&self, linear_mm: [[f64; 3]; 2], tips_mm: [[f64; 3]; 2], turns_rad: [f64; 2]) -> f64 {
        let [first, second] = self.profile_index.map(|index| turns_rad[index]);
        let (table_turn, head_turn) = match self.head_axes {
            0 => (first + second, 0.0),
            1 => (first, second),
            _ => (0.0, first + second),
        };
        let step: [f64; 3] = std::array::from_fn(|k| linear_mm[1][k] - linear_mm[0][k]);
        let [x, y, z] = &self.columns;
        let moved = std::array::from_fn(|k| x[k] * step[0] + y[k] * step[1] + z[k] * step[2]);
        let straight = square(moved).sqrt();
        let head_path = head_turn * self.head_reach_mm;
        let away = |tip: &[f64; 3]| {
            square(std::array::from_fn(|k| tip[k] + self.work_offset_mm[k] - self.point_mm[k]))
        };
        let at_ends = away(&tips_mm[0]).max(away(&tips_mm[1])).sqrt();
        let by_convexity = at_ends + 2.0 * self.table_between_mm + head_path;
        let by_path = (at_ends + 0.5 * (straight + head_path + table_turn * self.table_between_mm))
            / (1.0 - 0.5 * table_turn);
        let reach = if table_turn < SHORT_TURN_RAD { by_path.min(by_convexity) } else { by_convexity };
        table_turn * table_turn * (reach + self.table_between_mm)
            + 2.0 * table_turn * (straight + head_path)
            + head_turn * head_turn * self.head_reach_mm
    }
}

#[inline(always)]
#[expect(clippy::inline_always, reason = "compiled into loops for several instruction sets")]
fn square([x, y, z]: [f64; 3]) -> f64 {
    x * x + y * y + z * z
}
