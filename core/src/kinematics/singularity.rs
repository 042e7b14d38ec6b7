//! Near the pole the axis next to the workpiece is held, and the other axis gets its best fit.
//!
//! On a calibrated machine the exact inverse changes wildly near the direction along u (§1 "Pole"): 50 µrad of
//! tilt move C by 35° at A = 0.01°. Path selection therefore holds u inside a cone about the pole; the tip stays
//! exact.

use super::pointing::{DEG_PER_RAD, principal_deg};
use super::{COMPUTED_WORD_SLACK, Kinematics};
use crate::geometry::{Vec3, angle_about, angle_between};
use crate::machine::Machine;

/// Smallest half-angle of the cone \[deg\].
pub const MIN_CONE_DEG: f64 = 0.01;

impl Kinematics {
    /// The half-angle of the cone about ±u in which path selection holds u: the larger of 0.01° and twice
    /// [`Kinematics::tilt_rad`] \[rad\].
    #[must_use]
    pub fn pole_cone_rad(&self) -> f64 {
        MIN_CONE_DEG.to_radians().max(2.0 * self.tilt_rad)
    }

    /// The word of v \[deg\] that points the tool best to the unit `axis` while u is at `u_deg`. If a travel ends
    /// before the best word by less than twice the cone, its end is used.
    pub(super) fn held_word_deg(&self, axis: Vec3, u_deg: f64) -> f64 {
        let [u, v] = &self.screws;
        let wanted = u.turn(-self.sense[0] * u_deg.to_radians(), axis);
        let best =
            principal_deg(self.sense[1] * angle_about(v.direction, Machine::TOOL_AXIS, wanted) * DEG_PER_RAD);
        let Some(travel) = self.travel_deg[1] else { return best };
        let turns = ((0.5 * (travel.min + travel.max) - best) / 360.0).round();
        // The end of the travel that is nearest in either direction.
        [best + 360.0 * turns, best + 360.0 * (turns - 1.0), best + 360.0 * (turns + 1.0)]
            .into_iter()
            .map(|word| {
                (word.clamp(travel.min, travel.max), (word.clamp(travel.min, travel.max) - word).abs())
            })
            .filter(|(_, miss)| {
                *miss > COMPUTED_WORD_SLACK && *miss <= 2.0 * self.pole_cone_rad().to_degrees()
            })
            .map(|(word, _)| principal_deg(word))
            .next()
            .filter(|_| super::inverse::turn_range(best, self.travel_deg[1]).is_empty())
            .unwrap_or(best)
    }

    /// Conditioning, and the angle \[rad\] between the tool and the unit `axis` at these words of u, v \[deg\].
    pub(super) fn held_quality(&self, axis: Vec3, words_deg: [f64; 2]) -> (f64, f64) {
        let mut rotary_rad = [0.0; 2];
        for k in 0..2 {
            rotary_rad[self.profile_index[k]] = self.sense[k] * words_deg[k].to_radians();
        }
        let pointed = self.axis(rotary_rad);
        let [u, v] = &self.screws;
        let turned_v = u.turn(self.sense[0] * words_deg[0].to_radians(), v.direction);
        (pointed.dot(&u.direction.cross(&turned_v)).abs(), angle_between(pointed, axis))
    }
}
