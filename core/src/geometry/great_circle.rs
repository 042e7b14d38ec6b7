//! The shortest arc between two directions.

use super::{Vec3, angle_between, trig};

/// The great circle from one unit vector to another, traversed at constant angular speed.
///
/// Between opposite directions the arc is not defined; [`GreatCircle::between`] then takes the arc about the
/// given fallback axis, so that the result stays finite and repeatable.
#[derive(Debug, Clone, Copy)]
pub struct GreatCircle {
    start: Vec3,
    /// Unit, at right angles to `start`, in the plane of the arc.
    toward: Vec3,
    angle_rad: f64,
}

/// Below this angle \[rad\] rounding hides the plane of the arc. The direction of its chord is then used.
const DEGENERATE_ANGLE_RAD: f64 = 1e-15;

impl GreatCircle {
    /// The arc from `start` to `end`, both unit vectors. `fallback_axis` is used if they are opposite.
    #[must_use]
    pub fn between(start: Vec3, end: Vec3, fallback_axis: Vec3) -> Self {
        let angle_rad = angle_between(start, end);
        let chord = end - start * start.dot(&end);
        let toward = chord.try_normalize(DEGENERATE_ANGLE_RAD).unwrap_or_else(|| {
            fallback_axis.cross(&start).try_normalize(f64::EPSILON).unwrap_or_else(Vec3::zeros)
        });
        Self { start, toward, angle_rad }
    }

    /// The whole angle of the arc \[rad\].
    #[must_use]
    pub fn angle_rad(&self) -> f64 {
        self.angle_rad
    }

    /// The direction at the fraction `u` of the arc: `start` at 0, `end` at 1.
    #[must_use]
    pub fn at(&self, u: f64) -> Vec3 {
        let (sin, cos) = trig::sin_cos(self.angle_rad * u);
        self.start * cos + self.toward * sin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arc_starts_and_ends_where_it_should() {
        let (a, b) = (Vec3::new(1.0, 0.2, -0.3).normalize(), Vec3::new(-0.4, 0.9, 0.1).normalize());
        let arc = GreatCircle::between(a, b, Vec3::z());
        assert!((arc.at(0.0) - a).norm() < 1e-15);
        assert!((arc.at(1.0) - b).norm() < 1e-15);
        assert!((arc.at(0.37).norm() - 1.0).abs() < 1e-15);
        assert!((angle_between(a, arc.at(0.25)) - 0.25 * arc.angle_rad()).abs() < 1e-15);
    }

    #[test]
    fn opposite_and_equal_directions_stay_finite() {
        let a = Vec3::x();
        assert!((GreatCircle::between(a, -a, Vec3::z()).at(0.5) - Vec3::y()).norm() < 1e-15);
        assert!((GreatCircle::between(a, a, Vec3::z()).at(0.5) - a).norm() < 1e-15);
    }
}
