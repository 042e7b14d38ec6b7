//! The filter behind a course: wear whose rate strays like a random walk, seen through readings that scatter.

use nalgebra::{Matrix2, Matrix2x3, RowVector3, Vector2, Vector3};

/// Readings as the filter takes them, in the order of the parts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scaled<'a> {
    /// Where: −1 at the first reading, 0 at the last.
    pub(super) places: &'a [f64],
    /// Wear \[mm\].
    pub(super) wear_mm: &'a [f64],
    /// Variance of each reading \[mm²\], up to a common factor.
    pub(super) variance_mm2: &'a [f64],
}

/// What one roughness of the rate makes of the readings.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fitted {
    /// Sum of the squares of the innovations over their variances, the start fitted.
    pub(super) square: f64,
    /// Logarithm of the determinants of the innovations and of the start.
    pub(super) log_determinant: f64,
    /// Wear \[mm\] and rate \[mm per span\] at the first reading.
    pub(super) start: Vector2<f64>,
    /// Wear \[mm\] and rate \[mm per span\] at the last reading.
    pub(super) end: Vector2<f64>,
    /// Covariance of the end, up to the common factor.
    pub(super) covariance: Matrix2<f64>,
}

/// Wear and rate a step later.
fn ahead(step: f64) -> Matrix2<f64> {
    Matrix2::new(1.0, step, 0.0, 1.0)
}

/// What the walk of the rate adds on the way (variance per step of the rate: `walk`).
fn strayed(step: f64, walk: f64) -> Matrix2<f64> {
    let (first, second, third) = (step, step * step / 2.0, step * step * step / 3.0);
    Matrix2::new(third, second, second, first) * walk
}

/// The covariance once a reading of variance `variance` is in, `total` being that of the innovation. The products are
/// put so that nothing cancels where the reading says nearly all.
fn updated(before: &Matrix2<f64>, variance: f64, total: f64) -> Matrix2<f64> {
    let left = variance / total;
    let corner = before.m11 * left;
    let side = before.m12 * left;
    Matrix2::new(corner, side, side, before.m22 - before.m12 * before.m12 / total)
}

impl Scaled<'_> {
    /// Where, wear and variance of every reading, with the step from the one before.
    fn steps(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        let before = self.places.iter().take(1).chain(self.places);
        let steps = self.places.iter().zip(before).map(|(here, before)| here - before);
        steps
            .zip(self.wear_mm.iter().zip(self.variance_mm2))
            .map(|(step, (wear, variance))| (step, *wear, *variance))
    }

    /// The Kalman filter of the twice integrated walk with wear and rate at the first reading left free: the filter runs
    /// over the readings and over the two columns of the start at once, and least squares of the innovations give the
    /// start (de Jong, 1988: the augmented filter; its likelihood is the restricted one). With `walk` = 0 it is the
    /// straight line of weighted least squares. `None` where the readings do not fix the start.
    pub(super) fn fit(&self, walk: f64) -> Option<Fitted> {
        // Columns: what the filter makes of the readings, and of unit wear and unit rate at the start.
        let mut state = Matrix2x3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        let mut covariance = Matrix2::zeros();
        let mut normal = Matrix2::zeros();
        let mut right = Vector2::zeros();
        let (mut square, mut log_determinant) = (0.0, 0.0);
        for (step, wear_mm, variance) in self.steps() {
            let forward = ahead(step);
            state = forward * state;
            covariance = forward * covariance * forward.transpose() + strayed(step, walk);
            let total = covariance.m11 + variance;
            let innovation = RowVector3::new(wear_mm, 0.0, 0.0) - state.row(0);
            // The innovation of the readings is that of the columns times the start, and noise.
            let column = -Vector2::new(innovation.y, innovation.z);
            normal += column * column.transpose() / total;
            right += column * (innovation.x / total);
            square += innovation.x * innovation.x / total;
            log_determinant += total.ln();
            state += covariance.column(0) * innovation / total;
            covariance = updated(&covariance, variance, total);
        }
        let inverse = normal.try_inverse()?;
        let start = inverse * right;
        let columns = Matrix2::new(state.m12, state.m13, state.m22, state.m23);
        let fitted = Fitted {
            square: (square - right.dot(&start)).max(0.0),
            log_determinant: log_determinant + normal.determinant().ln(),
            start,
            end: state * Vector3::new(1.0, start.x, start.y),
            covariance: covariance + columns * inverse * columns.transpose(),
        };
        let is_sound = fitted.log_determinant.is_finite()
            && fitted.end.iter().chain(fitted.covariance.iter()).all(|value| value.is_finite());
        is_sound.then_some(fitted)
    }

    /// The likeliest wear at every reading, all readings known, from the start that [`fit`](Self::fit) found: the filter
    /// forward, then the disturbances back (de Jong, 1989), which needs no inverse of a covariance.
    pub(super) fn smooth(&self, walk: f64, start: Vector2<f64>) -> Vec<f64> {
        struct Seen {
            step: f64,
            state: Vector2<f64>,
            covariance: Matrix2<f64>,
            innovation: f64,
            total: f64,
        }
        let mut seen = Vec::with_capacity(self.places.len());
        let (mut state, mut covariance) = (start, Matrix2::zeros());
        for (step, wear_mm, variance) in self.steps() {
            let forward = ahead(step);
            state = forward * state;
            covariance = forward * covariance * forward.transpose() + strayed(step, walk);
            let total = covariance.m11 + variance;
            let innovation = wear_mm - state.x;
            seen.push(Seen { step, state, covariance, innovation, total });
            state += covariance.column(0) * (innovation / total);
            covariance = updated(&covariance, variance, total);
        }
        let mut back = Vector2::zeros();
        let mut wear_mm: Vec<f64> = seen
            .iter()
            .rev()
            .map(|Seen { step, state, covariance, innovation, total }| {
                let gain = covariance.column(0) / *total;
                back.x += innovation / total - gain.dot(&back);
                let smoothed = state + covariance * back;
                back = ahead(*step).transpose() * back;
                smoothed.x
            })
            .collect();
        wear_mm.reverse();
        wear_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACES: [f64; 6] = [-1.0, -0.8, -0.8, -0.5, -0.1, 0.0];
    const WEAR_MM: [f64; 6] = [0.010, 0.021, 0.019, 0.034, 0.051, 0.062];
    const VARIANCE_MM2: [f64; 6] = [1e-6, 4e-6, 1e-6, 2e-6, 1e-6, 3e-6];

    fn readings() -> Scaled<'static> {
        Scaled { places: &PLACES, wear_mm: &WEAR_MM, variance_mm2: &VARIANCE_MM2 }
    }

    /// The same from dense matrices: generalised least squares with the covariance of a twice integrated walk that
    /// starts at the first reading, min(s, t)²·(3·max(s, t) − min(s, t))/6.
    #[test]
    fn the_filter_is_generalised_least_squares() {
        for walk in [0.0, 1e-7, 1e-5, 1e-2] {
            let since: Vec<f64> = PLACES.iter().map(|place| place + 1.0).collect();
            let v = nalgebra::DMatrix::from_fn(6, 6, |i, j| {
                let (s, t) = (since[i].min(since[j]), since[i].max(since[j]));
                walk * s * s * (3.0 * t - s) / 6.0 + if i == j { VARIANCE_MM2[i] } else { 0.0 }
            });
            let x = nalgebra::DMatrix::from_fn(6, 2, |i, j| if j == 0 { 1.0 } else { since[i] });
            let y = nalgebra::DVector::from_row_slice(&WEAR_MM);
            let w = v.clone().try_inverse().unwrap();
            let normal = x.transpose() * &w * &x;
            let inverse = normal.clone().try_inverse().unwrap();
            let start = &inverse * x.transpose() * &w * &y;
            let left = &y - &x * &start;
            let square = left.dot(&(&w * &left));
            let found = readings().fit(walk).unwrap();
            // Rounding of six readings.
            assert!((found.square - square).abs() < 1e-9 * square, "{walk}: {} {square}", found.square);
            let log_determinant = v.determinant().ln() + normal.determinant().ln();
            assert!((found.log_determinant - log_determinant).abs() < 1e-9, "{walk}");
            assert!((found.start.x - start[0]).abs() < 1e-12 && (found.start.y - start[1]).abs() < 1e-11);
            // Best linear prediction of the wear at each reading.
            let k = &v - nalgebra::DMatrix::from_diagonal(&nalgebra::DVector::from_row_slice(&VARIANCE_MM2));
            let smoothed = &x * &start + &k * &w * &left;
            for (one, other) in readings().smooth(walk, found.start).iter().zip(smoothed.iter()) {
                assert!((one - other).abs() < 1e-12, "{walk}: {one} {other}");
            }
            assert!((found.end.x - smoothed[5]).abs() < 1e-12);
            // Variance of the wear at the end: of the walk given the readings, and of the start.
            let kn = k.column(5).clone_owned();
            let xn = nalgebra::DVector::from_row_slice(&[1.0, since[5]]) - x.transpose() * &w * &kn;
            let variance = k[(5, 5)] - kn.dot(&(&w * &kn)) + xn.dot(&(&inverse * &xn));
            assert!((found.covariance.m11 - variance).abs() < 1e-9 * variance, "{walk}");
        }
    }

    #[test]
    fn readings_at_one_place_fix_no_start() {
        let readings =
            Scaled { places: &[0.0, 0.0, 0.0], wear_mm: &[1.0, 2.0, 3.0], variance_mm2: &[1.0, 1.0, 1.0] };
        assert!(readings.fit(0.0).is_none());
        let none = Scaled { places: &[], wear_mm: &[], variance_mm2: &[] };
        assert!(none.fit(1.0).is_none() && none.smooth(1.0, Vector2::zeros()).is_empty());
    }
}
