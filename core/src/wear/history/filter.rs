//! The filter of a course: wear whose rate varies like a random walk, seen through readings with correlated errors.

use nalgebra::{Matrix2, Vector2};

/// Readings in the filter's form, in the order of the parts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scaled<'a> {
    /// Positions: −1 at the first reading, 0 at the last.
    pub(super) places: &'a [f64],
    /// Wear \[mm\].
    pub(super) wear_mm: &'a [f64],
    /// Standard deviation of each reading \[mm\], up to a common factor.
    pub(super) deviations_mm: &'a [f64],
}

/// One combination tried on the readings.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tried {
    /// Variance that the rate gains over the span \[mm² per span³\], in the scale of the deviations.
    pub(super) walk: f64,
    /// Correlation of the errors of neighbouring readings, from 0 to below 1.
    pub(super) correlation: f64,
}

/// The result of a walk and a correlation for the readings.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fitted {
    /// Sum of the squares of the innovations over their variances, with the fitted start.
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

/// Covariance of wear, rate, and the error of the reading over its deviation.
#[derive(Debug, Clone, Copy, Default)]
struct Spread {
    wear: f64,
    wear_rate: f64,
    wear_error: f64,
    rate: f64,
    rate_error: f64,
    error: f64,
}

/// The weight of a reading on each state, and the variance of its innovation.
#[derive(Debug, Clone, Copy)]
struct Gain {
    wear: f64,
    rate: f64,
    error: f64,
    total: f64,
}

impl Spread {
    /// At the start, with wear and rate given: the error of the first reading is as unknown as any other.
    const START: Self =
        Self { wear: 0.0, wear_rate: 0.0, wear_error: 0.0, rate: 0.0, rate_error: 0.0, error: 1.0 };

    /// The spread one step later.
    fn ahead(&self, step: f64, Tried { walk, correlation }: Tried) -> Self {
        Self {
            wear: self.wear
                + step * (2.0 * self.wear_rate + step * self.rate)
                + walk * step * step * step / 3.0,
            wear_rate: self.wear_rate + step * self.rate + walk * step * step / 2.0,
            wear_error: correlation * (self.wear_error + step * self.rate_error),
            rate: self.rate + walk * step,
            rate_error: correlation * self.rate_error,
            error: correlation * correlation * self.error + 1.0 - correlation * correlation,
        }
    }

    fn gain(&self, deviation: f64) -> Gain {
        let wear = self.wear + deviation * self.wear_error;
        let error = self.wear_error + deviation * self.error;
        Gain {
            wear,
            rate: self.wear_rate + deviation * self.rate_error,
            error,
            total: wear + deviation * error,
        }
    }

    /// The spread after the reading. The reading is wear plus error and nothing else, so both keep the same
    /// remaining variance. Nothing cancels, even if the reading determines almost all of the wear.
    fn seen(&self, deviation: f64, gain: &Gain) -> Self {
        let error = self.error - gain.error * gain.error / gain.total;
        let rate_error = self.rate_error - gain.rate * gain.error / gain.total;
        Self {
            wear: deviation * deviation * error,
            wear_rate: -deviation * rate_error,
            wear_error: -deviation * error,
            rate: self.rate - gain.rate * gain.rate / gain.total,
            rate_error,
            error,
        }
    }
}

/// Wear, rate and error of the reading, for one column.
type State = [f64; 3];

/// The state one step later.
fn forward([wear, rate, error]: State, step: f64, correlation: f64) -> State {
    [wear + step * rate, rate, correlation * error]
}

/// The state after a reading that gives `reading` for this column.
fn informed(state: State, reading: f64, deviation: f64, gain: &Gain) -> (State, f64) {
    let [wear, rate, error] = state;
    let innovation = reading - wear - deviation * error;
    let share = innovation / gain.total;
    let error = error + gain.error * share;
    ([reading - deviation * error, rate + gain.rate * share, error], innovation)
}

impl Scaled<'_> {
    /// Step from the previous reading, wear and deviation of every reading.
    fn steps(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        let before = self.places.iter().take(1).chain(self.places);
        let steps = self.places.iter().zip(before).map(|(here, before)| here - before);
        steps
            .zip(self.wear_mm.iter().zip(self.deviations_mm))
            .map(|(step, (wear, deviation))| (step, *wear, *deviation))
    }

    /// The Kalman filter of the twice integrated walk, with errors that follow a first-order autoregression from
    /// reading to reading. Wear and rate at the first reading are free: the filter runs over the readings and over
    /// the two columns of the start together, and least squares of the innovations give the start (de Jong, 1988:
    /// the augmented filter; its likelihood is the restricted one). With a walk and a correlation of 0 it is the
    /// straight line of weighted least squares. `None` if the readings do not determine the start.
    pub(super) fn fit(&self, tried: Tried) -> Option<Fitted> {
        // The filter's states for the readings, and for unit wear and unit rate at the start.
        let mut states: [State; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let mut spread = Spread::START;
        let mut normal = Matrix2::zeros();
        let mut right = Vector2::zeros();
        let (mut square, mut log_determinant) = (0.0, 0.0);
        for (step, wear_mm, deviation) in self.steps() {
            spread = spread.ahead(step, tried);
            let gain = spread.gain(deviation);
            let mut innovations = [0.0; 3];
            for ((state, reading), innovation) in
                states.iter_mut().zip([wear_mm, 0.0, 0.0]).zip(&mut innovations)
            {
                (*state, *innovation) =
                    informed(forward(*state, step, tried.correlation), reading, deviation, &gain);
            }
            // The innovation of the readings is that of the columns times the start, plus noise.
            let [innovation, of_wear, of_rate] = innovations;
            let column = -Vector2::new(of_wear, of_rate);
            normal += column * column.transpose() / gain.total;
            right += column * (innovation / gain.total);
            square += innovation * innovation / gain.total;
            log_determinant += gain.total.ln();
            spread = spread.seen(deviation, &gain);
        }
        let inverse = normal.try_inverse()?;
        let start = inverse * right;
        let [given, of_wear, of_rate] = states;
        let columns = Matrix2::new(of_wear[0], of_rate[0], of_wear[1], of_rate[1]);
        let covariance = Matrix2::new(spread.wear, spread.wear_rate, spread.wear_rate, spread.rate);
        let fitted = Fitted {
            square: (square - right.dot(&start)).max(0.0),
            log_determinant: log_determinant + normal.determinant().ln(),
            start,
            end: Vector2::new(given[0], given[1]) + columns * start,
            covariance: covariance + columns * inverse * columns.transpose(),
        };
        let is_sound = fitted.log_determinant.is_finite()
            && fitted.square.is_finite()
            && fitted.end.iter().chain(fitted.covariance.iter()).all(|value| value.is_finite());
        is_sound.then_some(fitted)
    }

    /// The likeliest wear at every reading given all readings, from the start that [`fit`](Self::fit) found. The
    /// filter runs forward, then the disturbances backward (de Jong, 1989), which needs no inverse of a covariance.
    pub(super) fn smooth(&self, tried: Tried, start: Vector2<f64>) -> Vec<f64> {
        struct Seen {
            step: f64,
            deviation: f64,
            wear: f64,
            spread: Spread,
            gain: Gain,
            innovation: f64,
        }
        let mut seen = Vec::with_capacity(self.places.len());
        let (mut state, mut spread) = ([start.x, start.y, 0.0], Spread::START);
        for (step, wear_mm, deviation) in self.steps() {
            spread = spread.ahead(step, tried);
            state = forward(state, step, tried.correlation);
            let gain = spread.gain(deviation);
            let wear = state[0];
            let innovation;
            (state, innovation) = informed(state, wear_mm, deviation, &gain);
            seen.push(Seen { step, deviation, wear, spread, gain, innovation });
            spread = spread.seen(deviation, &gain);
        }
        let mut back: State = [0.0; 3];
        let mut wear_mm: Vec<f64> = seen
            .iter()
            .rev()
            .map(|Seen { step, deviation, wear, spread, gain, innovation }| {
                let said = gain.wear * back[0] + gain.rate * back[1] + gain.error * back[2];
                let share = (innovation - said) / gain.total;
                back[0] += share;
                back[2] += deviation * share;
                let smoothed =
                    wear + spread.wear * back[0] + spread.wear_rate * back[1] + spread.wear_error * back[2];
                back = [back[0], back[1] + step * back[0], tried.correlation * back[2]];
                smoothed
            })
            .collect();
        wear_mm.reverse();
        wear_mm
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::*;

    const PLACES: [f64; 6] = [-1.0, -0.8, -0.8, -0.5, -0.1, 0.0];
    const WEAR_MM: [f64; 6] = [0.010, 0.021, 0.019, 0.034, 0.051, 0.062];
    const DEVIATIONS_MM: [f64; 6] = [1e-3, 2e-3, 1e-3, 1.5e-3, 1e-3, 1.7e-3];

    fn readings() -> Scaled<'static> {
        Scaled { places: &PLACES, wear_mm: &WEAR_MM, deviations_mm: &DEVIATIONS_MM }
    }

    /// The same from dense matrices: generalised least squares with the covariance of a twice integrated walk that
    /// starts at the first reading, min(s, t)²·(3·max(s, t) − min(s, t))/6, and errors with ρ to the distance.
    #[test]
    fn the_filter_is_generalised_least_squares() {
        for (walk, correlation) in
            [(0.0, 0.0), (1e-7, 0.0), (1e-5, 0.35), (1e-2, 0.0), (0.0, 0.7), (1e-4, 0.7), (1e-2, 0.5)]
        {
            let tried = Tried { walk, correlation };
            let since: Vec<f64> = PLACES.iter().map(|place| place + 1.0).collect();
            let k = DMatrix::from_fn(6, 6, |i, j| {
                let (s, t) = (since[i].min(since[j]), since[i].max(since[j]));
                walk * s * s * (3.0 * t - s) / 6.0
            });
            let errors = DMatrix::from_fn(6, 6, |i, j| {
                let distance = i32::try_from(i.abs_diff(j)).unwrap();
                DEVIATIONS_MM[i] * DEVIATIONS_MM[j] * correlation.powi(distance)
            });
            let v = &k + errors;
            let x = DMatrix::from_fn(6, 2, |i, j| if j == 0 { 1.0 } else { since[i] });
            let y = DVector::from_row_slice(&WEAR_MM);
            let w = v.clone().try_inverse().unwrap();
            let normal = x.transpose() * &w * &x;
            let inverse = normal.clone().try_inverse().unwrap();
            let start = &inverse * x.transpose() * &w * &y;
            let left = &y - &x * &start;
            let square = left.dot(&(&w * &left));
            let found = readings().fit(tried).unwrap();
            // Rounding of six readings.
            assert!((found.square - square).abs() < 1e-9 * square, "{tried:?}: {} {square}", found.square);
            let log_determinant = v.determinant().ln() + normal.determinant().ln();
            assert!((found.log_determinant - log_determinant).abs() < 1e-9, "{tried:?}");
            assert!((found.start.x - start[0]).abs() < 1e-12 && (found.start.y - start[1]).abs() < 1e-11);
            // Best linear prediction of the wear at each reading.
            let smoothed = &x * &start + &k * &w * &left;
            for (one, other) in readings().smooth(tried, found.start).iter().zip(smoothed.iter()) {
                assert!((one - other).abs() < 1e-12, "{tried:?}: {one} {other}");
            }
            assert!((found.end.x - smoothed[5]).abs() < 1e-12);
            // Variance of the wear at the end: of the walk given the readings, and of the start.
            let kn = k.column(5).clone_owned();
            let xn = DVector::from_row_slice(&[1.0, since[5]]) - x.transpose() * &w * &kn;
            let variance = k[(5, 5)] - kn.dot(&(&w * &kn)) + xn.dot(&(&inverse * &xn));
            assert!((found.covariance.m11 - variance).abs() < 1e-9 * variance, "{tried:?}");
            // The same for the rate, and for both: the covariance of the walk's rate and the wear at s is s²/2.
            let rate_k = DVector::from_fn(6, |i, _| walk * since[i] * since[i] / 2.0);
            let rate_x = DVector::from_row_slice(&[0.0, 1.0]) - x.transpose() * &w * &rate_k;
            let rate = start[1] + rate_k.dot(&(&w * &left));
            assert!((found.end.y - rate).abs() < 1e-9 * rate, "{tried:?}");
            let of_rate = walk * since[5] - rate_k.dot(&(&w * &rate_k)) + rate_x.dot(&(&inverse * &rate_x));
            assert!((found.covariance.m22 - of_rate).abs() < 1e-9 * of_rate, "{tried:?}");
            let of_both = rate_k[5] - kn.dot(&(&w * &rate_k)) + xn.dot(&(&inverse * &rate_x));
            assert!((found.covariance.m12 - of_both).abs() < 1e-9 * of_both.abs(), "{tried:?}");
        }
    }

    /// If the rate varies by far more than the readings scatter, the wear equals the readings, to the scatter of
    /// one.
    #[test]
    fn nothing_cancels_where_the_walk_is_wild() {
        let tried = Tried { walk: 1e5, correlation: 0.0 };
        let found = readings().fit(tried).unwrap();
        assert!((found.end.x - WEAR_MM[5]).abs() < 1e-8, "{found:?}");
        let scatter = found.covariance.m11.sqrt() / DEVIATIONS_MM[5];
        assert!((scatter - 1.0).abs() < 1e-6, "{scatter}");
        assert!(found.covariance.determinant() > 0.0);
    }

    #[test]
    fn readings_at_one_place_fix_no_start() {
        let tried = Tried { walk: 0.0, correlation: 0.35 };
        let readings =
            Scaled { places: &[0.0, 0.0, 0.0], wear_mm: &[1.0, 2.0, 3.0], deviations_mm: &[1.0, 1.0, 1.0] };
        assert!(readings.fit(tried).is_none());
        let none = Scaled { places: &[], wear_mm: &[], deviations_mm: &[] };
        assert!(none.fit(tried).is_none() && none.smooth(tried, Vector2::zeros()).is_empty());
    }
}
