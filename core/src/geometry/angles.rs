//! Angles between vectors, computed so that no digit is lost near 0 and π.

use std::f64::consts::{PI, TAU};

use super::{Vec3, across, trig};

/// The angle between `a` and `b` in [0, π] \[rad\], by atan2(|a×b|, a·b): accurate near 0 and π, where an arc
/// cosine keeps only half the digits. The vectors need not be unit. Two zero vectors give 0.
#[must_use]
pub fn angle_between(a: Vec3, b: Vec3) -> f64 {
    trig::atan2(a.cross(&b).norm(), a.dot(&b))
}

/// The rotation vector \[rad\] that turns the unit vector `from` into the unit vector `to` by the shortest way,
/// about the direction across both. Zero if they are parallel or opposite.
#[must_use]
pub fn shortest_turn_rad(from: Vec3, to: Vec3) -> Vec3 {
    let cross = from.cross(&to);
    let sine = cross.norm();
    if sine > 0.0 { cross * (angle_between(from, to) / sine) } else { Vec3::zeros() }
}

/// The angle about the unit vector `axis` that turns the projection of `from` across `axis` onto that of `to`, in
/// (−π, π] \[rad\]. Both are projected before any product is taken. If a projection vanishes, the angle is 0.
#[must_use]
pub fn angle_about(axis: Vec3, from: Vec3, to: Vec3) -> f64 {
    let (from, to) = (across(from, axis), across(to, axis));
    trig::atan2(axis.dot(&from.cross(&to)), from.dot(&to))
}

/// The same direction as `angle_rad`, wrapped into (−π, π].
#[must_use]
pub fn wrap_rad(angle_rad: f64) -> f64 {
    let wrapped = angle_rad - TAU * (angle_rad / TAU).round();
    if wrapped <= -PI { wrapped + TAU } else { wrapped }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_short_turn_turns_one_into_the_other() {
        let from = Vec3::new(1.0, -2.0, 0.5).normalize();
        for to in [Vec3::new(1.0, -2.0, 0.5001), Vec3::new(-1.0, 1.9, 0.3), from] {
            let to = to.normalize();
            let turn_rad = shortest_turn_rad(from, to);
            assert!((crate::geometry::rotation_from_vector(turn_rad) * from - to).norm() < 1e-15);
            assert!(turn_rad.dot(&from).abs() < 1e-15 && turn_rad.dot(&to).abs() < 1e-15);
        }
        assert_eq!(shortest_turn_rad(from, -from), Vec3::zeros());
    }

    #[test]
    fn wrap_keeps_pi_and_moves_minus_pi() {
        assert!((wrap_rad(PI) - PI).abs() < 1e-15);
        assert!((wrap_rad(-PI) - PI).abs() < 1e-15);
        assert!((wrap_rad(7.0) - (7.0 - TAU)).abs() < 1e-15);
    }

    #[test]
    fn small_angles_keep_their_digits() {
        let a = Vec3::new(1.0, 0.0, 0.0);
        let b = Vec3::new(1.0, 1e-12, 0.0);
        assert!((angle_between(a, b) / 1e-12 - 1.0).abs() < 1e-12);
    }
}
