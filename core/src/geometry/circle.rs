//! A circle in space.

use super::{Vec3, angle_about};

/// A circle about an axis, without its radius: every point lies on a circle about the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisCircle {
    centre_mm: Vec3,
    axis: Vec3,
}

/// Shortest vector that is taken as the direction of an axis.
const SHORTEST_AXIS: f64 = 1e-3;

impl AxisCircle {
    /// Centre \[mm\] and axis, of any length; `None` if the axis has no direction.
    #[must_use]
    pub fn new(centre_mm: Vec3, axis: Vec3) -> Option<Self> {
        Some(Self { centre_mm, axis: axis.try_normalize(SHORTEST_AXIS)? })
    }

    /// The unit vector of the axis.
    #[must_use]
    pub fn axis(&self) -> Vec3 {
        self.axis
    }

    /// The centre \[mm\].
    #[must_use]
    pub fn centre_mm(&self) -> Vec3 {
        self.centre_mm
    }

    /// The vector from the axis to the point, and the height of the point above the centre \[mm\].
    #[must_use]
    pub fn arm_mm(&self, point_mm: Vec3) -> (Vec3, f64) {
        let from = point_mm - self.centre_mm;
        let height = from.dot(&self.axis);
        (from - self.axis * height, height)
    }

    /// The angle in [0, 2π) that turns the arm of `from` counter-clockwise onto that of `to`, seen from the tip of the
    /// axis \[rad\].
    #[must_use]
    pub fn turn_rad(&self, from_mm: Vec3, to_mm: Vec3) -> f64 {
        let turn = angle_about(self.axis, self.arm_mm(from_mm).0, self.arm_mm(to_mm).0);
        if turn < 0.0 { turn + std::f64::consts::TAU } else { turn }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_count_counter_clockwise_about_the_axis() {
        let centre = Vec3::new(1.0, 2.0, 3.0);
        let [east, north] = [Vec3::new(3.0, 2.0, 3.0), Vec3::new(1.0, 4.0, 5.0)];
        for (axis, turn) in [(Vec3::z() * 7.0, 0.5), (-Vec3::z(), 1.5)] {
            let circle = AxisCircle::new(centre, axis).unwrap();
            let found = circle.turn_rad(east, north);
            assert!((found - turn * std::f64::consts::PI).abs() < 1e-12, "{found}");
        }
        let circle = AxisCircle::new(centre, Vec3::z()).unwrap();
        assert_eq!(circle.arm_mm(north), (Vec3::new(0.0, 2.0, 0.0), 2.0));
        assert_eq!(AxisCircle::new(centre, Vec3::zeros()), None);
    }
}
