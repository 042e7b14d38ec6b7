//! A bound on the curvature of the tip's path in W while all five words run linearly.

use super::Kinematics;
use crate::geometry::Vec3;

/// Up to this total turn of the table axes \[rad\], the path's own length bounds the distance from the axis.
const SHORT_TURN_RAD: f64 = 1.0;

impl Kinematics {
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
        let turn = |k: usize| turns_rad[self.profile_index[k]];
        let [u, v] = &self.screws;
        let between = (u.point_mm - v.point_mm).norm();
        let (table_turn, head_turn) = match self.head_axes {
            0 => (turn(0) + turn(1), 0.0),
            1 => (turn(0), turn(1)),
            _ => (0.0, turn(0) + turn(1)),
        };
        let head_reach = match self.head_axes {
            0 => 0.0,
            1 => v.point_mm.norm(),
            _ => v.point_mm.norm() + between,
        };
        let table_between = if self.head_axes == 0 { between } else { 0.0 };
        let straight = (self.linear_directions * (linear_mm[1] - linear_mm[0])).norm();
        let head_path = head_turn * head_reach;
        let away = |tip: Vec3| (tip + self.work_offset_mm - u.point_mm).norm_squared();
        let at_ends = away(tips_mm[0]).max(away(tips_mm[1])).sqrt();
        let by_convexity = at_ends + 2.0 * table_between + head_path;
        let reach = if table_turn < SHORT_TURN_RAD {
            let by_path = (at_ends + 0.5 * (straight + head_path + table_turn * table_between))
                / (1.0 - 0.5 * table_turn);
            by_path.min(by_convexity)
        } else {
            by_convexity
        };
        table_turn * table_turn * (reach + table_between)
            + 2.0 * table_turn * (straight + head_path)
            + head_turn * head_turn * head_reach
    }
}
