//! Two lines in space, and the vector of a rotation.

use crate::geometry::{Mat3, Screw, Vec3, trig};

/// The common perpendicular of two lines that are not parallel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommonPerpendicular {
    /// Unit direction `a × b` of the perpendicular.
    pub direction: Vec3,
    /// Its intersections with the first and the second line \[mm\].
    pub feet_mm: [Vec3; 2],
    /// Distance from the first line to the second along `direction`, signed \[mm\].
    pub distance_mm: f64,
    /// Angle from the first direction to the second about `direction`, in (0, π) \[rad\].
    pub angle_rad: f64,
}

/// Sine of the angle below which lines count as parallel: rounding of a direction then moves the feet by
/// metres.
const PARALLEL: f64 = 1e-9;

impl CommonPerpendicular {
    /// The common perpendicular of two lines; `None` if their directions are parallel.
    #[must_use]
    pub fn of(first: &Screw, second: &Screw) -> Option<Self> {
        let cross = first.direction.cross(&second.direction);
        let sine = cross.norm();
        // NaN is not above it either.
        if !sine.gt(&PARALLEL) {
            return None;
        }
        let direction = cross / sine;
        let between = second.point_mm - first.point_mm;
        let along = |other: Vec3| between.cross(&other).dot(&direction) / sine;
        let feet_mm = [
            first.point_mm + first.direction * along(second.direction),
            second.point_mm + second.direction * along(first.direction),
        ];
        Some(Self {
            direction,
            feet_mm,
            distance_mm: between.dot(&direction),
            angle_rad: trig::atan2(sine, first.direction.dot(&second.direction)),
        })
    }
}

/// The rotation vector (direction times angle \[rad\]) of a rotation by less than half a turn; the inverse of
/// Rodrigues' formula, without loss of digits for small angles.
#[must_use]
pub fn rotation_vector_rad(rotation: &Mat3) -> Vec3 {
    let skew = Vec3::new(
        rotation[(2, 1)] - rotation[(1, 2)],
        rotation[(0, 2)] - rotation[(2, 0)],
        rotation[(1, 0)] - rotation[(0, 1)],
    ) * 0.5;
    let sine = skew.norm();
    if sine > 0.0 { skew * (trig::atan2(sine, 0.5 * (rotation.trace() - 1.0)) / sine) } else { Vec3::zeros() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rotation_from_vector;

    #[test]
    fn the_feet_stand_across_both_lines() {
        let first =
            Screw { direction: Vec3::new(1.0, 2.0, -0.5).normalize(), point_mm: Vec3::new(3.0, -8.0, 40.0) };
        let second =
            Screw { direction: Vec3::new(0.1, 0.3, 1.0).normalize(), point_mm: Vec3::new(-70.0, 12.0, 5.0) };
        let between = CommonPerpendicular::of(&first, &second).unwrap();
        let [a, b] = between.feet_mm;
        for line in [&first, &second] {
            assert!((b - a).dot(&line.direction).abs() < 1e-12);
        }
        assert!((a - first.point_mm).cross(&first.direction).norm() < 1e-12);
        assert!((b - second.point_mm).cross(&second.direction).norm() < 1e-12);
        assert!((b - a - between.direction * between.distance_mm).norm() < 1e-12);
        assert_eq!(CommonPerpendicular::of(&first, &first), None);
    }

    #[test]
    fn the_vector_of_a_rotation_comes_back() {
        for scale in [0.0, 1e-12, 1e-5, 0.3, 2.0] {
            let vector = Vec3::new(0.4, -0.7, 0.2) * scale;
            let back = rotation_vector_rad(&rotation_from_vector(vector));
            assert!((back - vector).norm() <= 1e-15 + 1e-14 * scale, "{scale}");
        }
    }
}
