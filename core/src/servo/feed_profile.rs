//! The distance of the command along its path at each sample.

use crate::units::Feedrate;

/// Limits of a jerk-limited start, stop and change of feed, along the path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeedProfile {
    /// Acceleration along the path [mm/s²].
    pub acceleration_mm_per_s2: f64,
    /// Jerk along the path [mm/s³].
    pub jerk_mm_per_s3: f64,
}

impl FeedProfile {
    /// Lengths in samples, at least one, of the two moving averages that keep both limits for changes of speed up
    /// to `speed_mm_per_s`. The first is as long as the acceleration takes, the second as long as its build-up
    /// takes. The averages of a distance travelled at constant speed are the seven-segment profile. The path
    /// itself does not change, because only the distance along it is averaged.
    #[must_use]
    pub fn averages(&self, speed_mm_per_s: f64, period_s: f64) -> [usize; 2] {
        let samples = |time_s: f64| {
            let count = (time_s / period_s).ceil().max(1.0);
            // Saturates; the caller limits the total.
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "at least 1, saturating"
            )]
            let count = count as usize;
            count
        };
        [
            samples(speed_mm_per_s / self.acceleration_mm_per_s2),
            samples(self.acceleration_mm_per_s2 / self.jerk_mm_per_s3),
        ]
    }
}

/// A moving average over a fixed number of samples, of a sequence that has always been at its first value before.
/// The sum is computed again once in every length, so that rounding does not accumulate.
#[derive(Debug, Clone)]
pub struct MovingAverage {
    window: Vec<f64>,
    next: usize,
    sum: f64,
}

impl MovingAverage {
    /// An average over `length` samples (at least one) that is at rest at `start`.
    #[must_use]
    pub fn new(length: usize, start: f64) -> Self {
        let window = vec![start; length.max(1)];
        let sum = window.iter().sum();
        Self { window, next: 0, sum }
    }

    /// Takes the next value and returns the average.
    pub fn push(&mut self, value: f64) -> f64 {
        let Some(oldest) = self.window.get_mut(self.next) else { return value };
        self.sum += value - *oldest;
        *oldest = value;
        self.next += 1;
        if self.next == self.window.len() {
            self.next = 0;
            self.sum = self.window.iter().sum();
        }
        self.sum / self.window.len() as f64
    }
}

/// Distance along the path \[mm\] at each sample, from rest at 0 to `length_mm` at constant feed. With a profile
/// the command accelerates and brakes within its limits, and comes to rest at the points `stops_mm` (ascending).
///
/// Without a profile the last sample is the last one before the end of the path. With a profile it is the end
/// itself.
#[must_use]
pub(super) fn distances_mm(
    length_mm: f64,
    feed: Feedrate,
    period_s: f64,
    profile: Option<FeedProfile>,
    stops_mm: &[f64],
) -> Vec<f64> {
    let step_mm = feed.mm_per_min() / crate::units::S_PER_MIN * period_s;
    let Some(profile) = profile else {
        return (0..samples_of(length_mm, step_mm)).map(|k| k as f64 * step_mm).collect();
    };
    let [first, second] = profile.averages(step_mm / period_s, period_s);
    let mut averages = [MovingAverage::new(first, 0.0), MovingAverage::new(second, 0.0)];
    let mut out = Vec::new();
    let mut push = |at_mm: f64| {
        let [a, b] = &mut averages;
        out.push(b.push(a.push(at_mm)));
    };
    let mut from_mm = 0.0;
    for &stop_mm in stops_mm.iter().chain(std::iter::once(&length_mm)) {
        for k in 0..samples_of(stop_mm - from_mm, step_mm) {
            push(from_mm + k as f64 * step_mm);
        }
        // The averages run out: the command rests here.
        for _ in 0..first + second {
            push(stop_mm);
        }
        from_mm = stop_mm;
    }
    out
}

/// Number of samples of a stretch at constant feed, including its start.
#[must_use]
pub(super) fn samples_of(length_mm: f64, step_mm: f64) -> usize {
    // A lap that ends on a sample must end there whatever its last digit is.
    const ROUNDING: f64 = 1e-9;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative, saturating")]
    let steps = (length_mm / step_mm + ROUNDING).max(0.0) as usize;
    steps.saturating_add(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROFILE: FeedProfile = FeedProfile { acceleration_mm_per_s2: 500.0, jerk_mm_per_s3: 20_000.0 };
    const PERIOD_S: f64 = 0.001;

    #[test]
    fn a_profile_keeps_feed_acceleration_and_jerk_and_arrives() {
        let feed = Feedrate::from_mm_per_min(3000.0);
        let distances = distances_mm(40.0, feed, PERIOD_S, Some(PROFILE), &[15.0]);
        let differences = |values: &[f64]| -> Vec<f64> {
            values.windows(2).map(|pair| (pair[1] - pair[0]) / PERIOD_S).collect()
        };
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |size, value| size.max(value.abs()));
        let speed = differences(&distances);
        let acceleration = differences(&speed);
        let jerk = differences(&acceleration);
        // Rounding of distances, divided by the period once, twice, three times.
        assert!(largest(&speed) <= 50.0 * (1.0 + 1e-9), "{}", largest(&speed));
        assert!(largest(&acceleration) <= 500.0 * (1.0 + 1e-6), "{}", largest(&acceleration));
        assert!(largest(&jerk) <= 20_000.0 * 1.001, "{}", largest(&jerk));
        assert!(speed.iter().all(|speed| *speed > -1e-9));
        assert!((distances[distances.len() - 1] - 40.0).abs() < 1e-12);
        let rests_at_the_stop =
            distances.windows(2).any(|pair| (pair[0] - 15.0).abs() < 1e-12 && (pair[1] - 15.0).abs() < 1e-9);
        assert!(rests_at_the_stop);
        assert!(distances[0].abs() < 1e-12, "it starts from rest");
    }

    #[test]
    fn without_a_profile_every_sample_is_one_step_further() {
        let distances = distances_mm(1.0, Feedrate::from_mm_per_min(6000.0), PERIOD_S, None, &[]);
        assert_eq!(distances.len(), 11);
        assert!((distances[10] - 1.0).abs() < 1e-15);
    }

    #[test]
    fn an_average_forgets_its_rounding() {
        let mut average = MovingAverage::new(7, 0.0);
        for k in 0..100_000_u32 {
            average.push(1e6 + f64::from(k % 13) * 0.1);
        }
        for _ in 0..14 {
            average.push(2.5);
        }
        assert!((average.push(2.5) - 2.5).abs() < 1e-15);
    }
}
