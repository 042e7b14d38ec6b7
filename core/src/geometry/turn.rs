//! A turn of a frame: in which directions of another frame its axes point.

use super::trig::sin_cos_deg;

/// A turn, as a matrix by rows. It takes coordinates in the turned frame to directions of the other frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn([[f64; 3]; 3]);

impl Turn {
    /// The axes of both frames point in the same directions.
    pub const NONE: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// This turn, and then a turn about an axis (0 X, 1 Y, 2 Z) of the turned frame \[deg\]. Turns are
    /// counter-clockwise against the axis.
    #[must_use]
    pub fn then_about(self, axis: usize, angle_deg: f64) -> Self {
        let (sine, cosine) = sin_cos_deg(angle_deg);
        let (first, second) = ((axis + 1) % 3, (axis + 2) % 3);
        let mut turned = self.0;
        for (row, before) in turned.iter_mut().zip(self.0) {
            row[first] = cosine * before[first] + sine * before[second];
            row[second] = cosine * before[second] - sine * before[first];
        }
        Self(turned)
    }

    /// Coordinates in the turned frame as directions of the other frame.
    #[must_use]
    pub fn of(self, frame_mm: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = frame_mm;
        self.0.map(|[i, j, k]| i * x + j * y + k * z)
    }

    /// The turn with these axes; `None` if they are not directions, or the first is not across the third.
    ///
    /// Both need not have unit length. Programs round their numbers, so `x` is taken if it is across `z` within
    /// [`MAX_SLANT`]. It gets across `z` exactly.
    #[must_use]
    pub fn with_axes(x: [f64; 3], z: [f64; 3]) -> Option<Self> {
        let [x, z] = [unit(x)?, unit(z)?];
        let slant = dot(x, z);
        if slant.abs() > MAX_SLANT {
            return None;
        }
        let x = unit(std::array::from_fn(|k| x[k] - slant * z[k]))?;
        let y = [z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]];
        Some(Self(std::array::from_fn(|k| [x[k], y[k], z[k]])))
    }

    /// Directions of the other frame as coordinates in the turned frame.
    #[must_use]
    pub fn back(self, other_mm: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|k| (0..3).map(|row| self.0[row][k] * other_mm[row]).sum())
    }
}

/// The largest share of the third axis in the first one \[cosine\]. It turns a point at a distance of 1 m by 1 µm, so it
/// does not matter which of the axes gets across the other.
pub const MAX_SLANT: f64 = 1e-6;

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    (length.is_finite() && length > f64::EPSILON).then(|| v.map(|c| c / length))
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
