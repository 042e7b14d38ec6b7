//! Readings that do not agree with the others.

use crate::geometry::trig;

/// A reading that does not agree with the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outlier {
    /// Index of the reading.
    pub reading: usize,
    /// Its distance from the fit of the others, without this reading and without outliers listed before it \[mm\].
    pub distance_mm: f64,
    /// Upper bound on the probability that chance alone moves the worst of these readings that far.
    pub probability: f64,
}

/// Most outliers searched for. Readings with more are not a measurement of one axis.
pub(super) const MOST: usize = 20;
/// Below this probability the worst reading is an outlier.
const SIGNIFICANT: f64 = 0.01;
/// Scatter below this is rounding, not measurement \[mm\].
const ROUNDING_MM: f64 = 1e-9;
/// Largest number of degrees of freedom that is distinguished from infinity.
const MAX_FREEDOM: usize = 2000;
/// Intervals of the numerical integral.
const INTERVALS: u32 = 4000;

/// The effect of leaving one reading out on a sum of squares.
#[derive(Debug, Clone, Copy)]
pub(super) struct Deletion {
    /// Index of the reading.
    pub(super) reading: usize,
    /// Decrease of the sum of squares \[mm²\].
    pub(super) drop_mm2: f64,
    /// Distance of the reading from the fit of the others \[mm\].
    pub(super) distance_mm: f64,
}

/// The reading with the largest drop, if so large a drop is too unlikely among `tried` readings. `sum_mm2` is the
/// sum of squares of `freedom` degrees, and a reading has `components`. F test of the mean-shift model (Cook and
/// Weisberg, *Residuals and Influence in Regression*, 1982, §2.2), with Bonferroni's bound for the worst of many.
pub(super) fn worst(
    deletions: impl Iterator<Item = Deletion>,
    sum_mm2: f64,
    freedom: usize,
    components: usize,
    tried: usize,
) -> Option<Outlier> {
    if freedom <= components || sum_mm2 <= ROUNDING_MM * ROUNDING_MM * freedom as f64 {
        return None;
    }
    let worst = deletions.max_by(|a, b| a.drop_mm2.total_cmp(&b.drop_mm2).then(b.reading.cmp(&a.reading)))?;
    let left = (1.0 - worst.drop_mm2 / sum_mm2).clamp(0.0, 1.0);
    let single = lower_tail(left, freedom - components, components);
    let probability = (single * tried as f64).min(1.0);
    (probability < SIGNIFICANT).then_some(Outlier {
        reading: worst.reading,
        distance_mm: worst.distance_mm,
        probability,
    })
}

/// Probability that a beta variable of parameters `a2`/2, `b2`/2 (at least 1 each) is below `x`. With x = sin²φ it
/// is the integral of sin^(a2−1) cos^(b2−1) from 0 to φ, divided by that to π/2, by Simpson's rule.
fn lower_tail(x: f64, a2: usize, b2: usize) -> f64 {
    // Beyond that the distribution of the F ratio does not change visibly; the ratio itself is kept.
    let (x, a2) = if a2 > MAX_FREEDOM && x > 0.0 {
        (1.0 / (1.0 + (1.0 - x) / x * a2 as f64 / MAX_FREEDOM as f64), MAX_FREEDOM)
    } else {
        (x, a2)
    };
    let integral = |to: f64| {
        let step = to / f64::from(INTERVALS);
        let sum: f64 = (0..=INTERVALS)
            .map(|k| {
                let (sin, cos) = trig::sin_cos(step * f64::from(k));
                let weight = match k {
                    0 | INTERVALS => 1.0,
                    k if k % 2 == 1 => 4.0,
                    _ => 2.0,
                };
                weight * power(sin, a2 - 1) * power(cos.max(0.0), b2 - 1)
            })
            .sum();
        sum * step / 3.0
    };
    let phi = trig::atan2(x.sqrt(), (1.0 - x).sqrt());
    integral(phi) / integral(std::f64::consts::FRAC_PI_2)
}

/// `base` to a whole power, by squaring.
fn power(mut base: f64, mut exponent: usize) -> f64 {
    let mut product = 1.0;
    while exponent > 0 {
        if exponent % 2 == 1 {
            product *= base;
        }
        base *= base;
        exponent /= 2;
    }
    product
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tail_is_that_of_students_and_fishers_tables() {
        // Two-sided t of 10 degrees: 3.169 leaves 1 %; F of 3 and 20 degrees: 4.938 leaves 1 %.
        for (statistic, a2, b2) in [(3.169_f64.powi(2), 10, 1), (4.938, 20, 3)] {
            let x = 1.0 / (1.0 + statistic * b2 as f64 / a2 as f64);
            let tail = lower_tail(x, a2, b2);
            assert!((tail - 0.01).abs() < 1e-5, "{tail}");
        }
        // Two components: (1 + 2 F / ν)^(−ν/2), in closed form.
        let closed = (1.0_f64 + 2.0 * 7.0 / 30.0).powi(-15);
        assert!((lower_tail(1.0 / (1.0 + 2.0 * 7.0 / 30.0), 30, 2) - closed).abs() < 1e-9);
        assert!((lower_tail(1.0, 7, 3) - 1.0).abs() < 1e-15);
        // With very many degrees: chi-square of one, 6.635 leaves 1 %.
        let many = lower_tail(1.0 / (1.0 + 6.635 / 90_000.0), 90_000, 1);
        assert!((many - 0.01).abs() < 1e-4, "{many}");
    }
}
