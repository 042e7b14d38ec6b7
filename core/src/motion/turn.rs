//! The turn of the programmable frame: in which directions of the work offset its axes point.

use crate::geometry::trig::sin_cos_deg;

/// A turn, as a matrix by rows. It takes coordinates in the frame to directions of the work offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Turn([[f64; 3]; 3]);

impl Turn {
    pub(super) const NONE: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// This turn, and then a turn about an axis (0 X, 1 Y, 2 Z) of the turned frame \[deg\]. Turns are
    /// counter-clockwise against the axis.
    pub(super) fn then_about(self, axis: usize, angle_deg: f64) -> Self {
        let (sine, cosine) = sin_cos_deg(angle_deg);
        let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut turned = self.0;
        for (row, before) in turned.iter_mut().zip(self.0) {
            row[first] = cosine * before[first] + sine * before[second];
            row[second] = cosine * before[second] - sine * before[first];
        }
        Self(turned)
    }

    /// Coordinates in the frame as directions of the work offset.
    pub(super) fn of(self, frame_mm: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = frame_mm;
        self.0.map(|[i, j, k]| i * x + j * y + k * z)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "quarters are exact")]
mod tests {
    use super::*;

    #[test]
    fn turns_are_counter_clockwise_and_each_is_about_the_turned_axes() {
        assert_eq!(Turn::NONE.then_about(2, 90.0).of([1.0, 0.0, 0.0]), [0.0, 1.0, 0.0]);
        assert_eq!(Turn::NONE.then_about(1, 90.0).of([0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
        assert_eq!(Turn::NONE.then_about(0, 90.0).of([0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        // The second turn is about the Z axis that the first one has turned.
        let both = Turn::NONE.then_about(0, -90.0).then_about(2, 90.0);
        assert_eq!(both.of([0.0, 0.0, 1.0]), [0.0, 1.0, 0.0]);
        assert_eq!(both.of([1.0, 0.0, 0.0]), [0.0, 0.0, -1.0]);
        let eighth = Turn::NONE.then_about(2, 45.0).of([1.0, 0.0, 0.0]);
        assert!((eighth[0] - 0.5_f64.sqrt()).abs() < 1e-15 && (eighth[1] - 0.5_f64.sqrt()).abs() < 1e-15);
    }
}
