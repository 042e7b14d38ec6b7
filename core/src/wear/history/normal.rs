//! The normal distribution, and random numbers from it that are the same everywhere.

use crate::geometry::trig;

/// Standard deviations from the mean. Beyond this, the probability is 0 or 1 within 1e-15, the last digit needed
/// here.
const FARTHEST: f64 = 8.0;

/// Probability that a normal variable of mean 0 and deviation 1 is below `z`. It is the series of odd powers of
/// Abramowitz and Stegun 26.2.11, whose terms all have one sign. NaN gives NaN.
pub(super) fn below(z: f64) -> f64 {
    if z.abs() > FARTHEST {
        return if z > 0.0 { 1.0 } else { 0.0 };
    }
    let (mut term, mut sum, mut divisor) = (z, z, 1.0);
    while term.abs() > 1e-17 * sum.abs() {
        divisor += 2.0;
        term *= z * z / divisor;
        sum += term;
    }
    let density = (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt();
    (0.5 + sum * density).clamp(0.0, 1.0)
}

/// The value below which a normal variable is with this probability, to 5e-4 (Abramowitz and Stegun 26.2.23): exact
/// enough for random numbers. Probabilities nearer to 0 or 1 than 1e-12 count as 1e-12.
pub(super) fn quantile(probability: f64) -> f64 {
    let tail = probability.min(1.0 - probability).max(1e-12);
    let t = (-2.0 * tail.ln()).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    let below = 1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308));
    let z = t - above / below;
    if probability < 0.5 { -z } else { z }
}

/// A fixed sequence of numbers that look random: xorshift of 64 bits (Marsaglia, 2003). The same seed gives the
/// same numbers, so that the same readings give the same result.
#[derive(Debug, Clone)]
pub(super) struct Draws(u64);

impl Draws {
    /// The seed is mixed first, so that the numbers of neighbouring seeds are independent (Steele, Lea and Flood,
    /// 2014).
    pub(super) fn new(seed: u64) -> Self {
        let mut stirred = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
        stirred = (stirred ^ (stirred >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        stirred = (stirred ^ (stirred >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Self((stirred ^ (stirred >> 31)).max(1))
    }

    /// A number between 0 and 1, never equal to either.
    pub(super) fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    }

    /// A waiting time of mean 1 whose elapsed part is unknown.
    pub(super) fn waiting(&mut self) -> f64 {
        -self.uniform().ln()
    }

    /// Two normal numbers of mean 0 and deviation 1 (Box and Muller).
    pub(super) fn normals(&mut self) -> [f64; 2] {
        let length = (2.0 * self.waiting()).sqrt();
        let (sin, cos) = trig::sin_cos(std::f64::consts::TAU * self.uniform());
        [length * cos, length * sin]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probabilities_are_those_of_the_tables() {
        for (z, probability) in [
            (0.0, 0.5),
            (0.5, 0.691_462_461_274_013),
            (1.0, 0.841_344_746_068_543),
            (1.959_963_984_540_054, 0.975),
            (3.0, 0.998_650_101_968_370),
            (5.0, 0.999_999_713_348_428),
        ] {
            assert!((below(z) - probability).abs() < 1e-14, "{z}: {}", below(z));
            assert!((below(-z) - (1.0 - probability)).abs() < 1e-14, "{z}");
            // The stated accuracy of the approximation.
            assert!((quantile(probability) - z).abs() < 4.5e-4, "{z}: {}", quantile(probability));
            assert!((quantile(1.0 - probability) + z).abs() < 4.5e-4, "{z}");
        }
        assert!((below(40.0) - 1.0).abs() < f64::EPSILON && below(f64::NEG_INFINITY) < 1e-15);
        assert!(quantile(0.0).is_finite() && quantile(1.0).is_finite());
    }

    #[test]
    fn what_is_drawn_has_the_moments_it_should_have() {
        let mut draws = Draws::new(0);
        let many: Vec<f64> = (0..20_000).flat_map(|_| draws.normals()).collect();
        let count = many.len() as f64;
        let mean = many.iter().sum::<f64>() / count;
        let square = many.iter().map(|z| z * z).sum::<f64>() / count;
        let fourth = many.iter().map(|z| z.powi(4)).sum::<f64>() / count;
        // Four standard deviations of each: 1, √2 and √96 over √40000.
        assert!(mean.abs() < 0.02 && (square - 1.0).abs() < 0.03 && (fourth - 3.0).abs() < 0.2);
        let waiting = (0..20_000).map(|_| draws.waiting()).sum::<f64>() / 20_000.0;
        assert!((waiting - 1.0).abs() < 0.03, "{waiting}");
        // The same holds for the first numbers of neighbouring seeds.
        let first: Vec<f64> = (0..20_000).map(|seed| Draws::new(seed).uniform()).collect();
        let mean = first.iter().sum::<f64>() / 20_000.0;
        let product = first.windows(2).map(|pair| pair.iter().product::<f64>()).sum::<f64>() / 19_999.0;
        assert!((mean - 0.5).abs() < 0.01 && (product - 0.25).abs() < 0.01, "{mean} {product}");
    }
}
