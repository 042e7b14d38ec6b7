//! Student's distribution for whole degrees of freedom.

use crate::geometry::trig;

/// Degrees of freedom beyond which the distribution is not followed: its 97.5 % quantile is 1.972 there and 1.960 at
/// infinity, so that intervals stay a little wide.
const MOST_FREEDOM: usize = 200;

/// Probability that a Student variable of `freedom` degrees (at least 1) is below `t`. With θ = atan(t/√ν) the finite
/// sums in sin θ and cos θ of Abramowitz and Stegun 26.7.3 and 26.7.4. Not a number where `t` is none.
pub(super) fn below(t: f64, freedom: usize) -> f64 {
    let freedom = freedom.clamp(1, MOST_FREEDOM);
    let angle_rad = trig::atan2(t, (freedom as f64).sqrt());
    let (sin, cos) = trig::sin_cos(angle_rad);
    // Two-sided: the probability between −t and t, with the sign of t.
    let between = if freedom == 1 {
        angle_rad * std::f64::consts::FRAC_2_PI
    } else {
        let is_odd = freedom % 2 == 1;
        let first = if is_odd { cos } else { 1.0 };
        let start = if is_odd { 3 } else { 2 };
        let (mut term, mut sum) = (first, first);
        for step in (start..freedom - 1).step_by(2) {
            term *= cos * cos * (step - 1) as f64 / step as f64;
            sum += term;
        }
        if is_odd { (angle_rad + sin * sum) * std::f64::consts::FRAC_2_PI } else { sin * sum }
    };
    (0.5 + 0.5 * between).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        // 97.5 % and 99.5 %, to the digits printed in every table.
        for (freedom, quantile, probability) in [
            (1, 12.706_205, 0.975),
            (2, 4.302_653, 0.975),
            (3, 3.182_446, 0.975),
            (4, 2.776_445, 0.975),
            (5, 4.032_143, 0.995),
            (10, 2.228_139, 0.975),
            (11, 3.105_807, 0.995),
            (30, 2.042_272, 0.975),
            (101, 1.983_731, 0.975),
        ] {
            let found = below(quantile, freedom);
            assert!((found - probability).abs() < 1e-7, "{freedom}: {found}");
            assert!((below(-quantile, freedom) - (1.0 - probability)).abs() < 1e-7, "{freedom}");
        }
        assert!((below(1.959_964, 100_000) - 0.975).abs() < 1e-3);
        assert!((below(0.0, 7) - 0.5).abs() < f64::EPSILON);
        assert!((below(f64::INFINITY, 6) - 1.0).abs() < 1e-15 && below(f64::NEG_INFINITY, 5) < 1e-15);
    }
}
