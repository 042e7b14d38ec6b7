//! The course of one edge's wear and what it says of wear to come.

use nalgebra::{Matrix2, Vector2};

use super::filter::{Fitted, Scaled};
use super::{CourseFault, LEAST_PLACES, WearReading, student};

/// Least scatter of a reading that states no uncertainty \[mm\]: one read to the whole micrometre strays by 1/√12 of it.
const LEAST_SCATTER_MM: f64 = 0.3e-3;
/// Squares of the roughnesses tried: how far the rate strays over the span of the readings, against the scatter of one.
/// From what nobody sees to what leaves the scatter nothing, two in each decade.
const LEAST_ROUGHNESS: f64 = 0.1;
const ROUGHNESSES: u32 = 27;
/// Weight beforehand of a rate that never strays.
const STRAIGHT: f64 = 0.3;
/// From this probability of a rate above zero on, wear is taken to rise.
const RISING: f64 = 0.9;
/// Likelihood, over that of the likeliest, below which a roughness no longer counts.
const NEGLIGIBLE: f64 = 1e-6;

/// Wear and rate at the last reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WearRate {
    /// The wear \[mm\].
    pub wear_mm: f64,
    /// The rate \[mm per part\].
    pub rate_mm_per_part: f64,
    /// Probability that the rate is above zero.
    pub chance_rising: f64,
}

/// One roughness with its share of the whole.
#[derive(Debug, Clone, Copy)]
struct Component {
    share: f64,
    /// Wear \[mm\] and rate \[mm per span\] at the last reading.
    end: Vector2<f64>,
    covariance: Matrix2<f64>,
    /// Variance of the rate gained over a span.
    walk: f64,
    /// Standard deviation of a reading, over what was stated or the least.
    scatter: f64,
}

impl Component {
    /// Probability that the wear `ahead` spans behind the last reading is above `wear_mm`, of those courses alone that do
    /// not fall on the way.
    fn chance_above(&self, ahead: f64, wear_mm: f64, freedom: usize) -> f64 {
        let c = &self.covariance;
        let walked = self.walk * ahead * ahead * ahead / 3.0;
        let turned = ahead * ahead * c.m22;
        let mean_mm = self.end.x + self.end.y * ahead;
        let deviation_mm = (c.m11 + 2.0 * ahead * c.m12 + turned + walked).max(0.0).sqrt();
        let above = student::below((mean_mm - wear_mm) / deviation_mm, freedom);
        if ahead <= 0.0 {
            return above;
        }
        let rising = student::below(self.end.y * ahead / (turned + walked).sqrt(), freedom);
        (above / rising.max(f64::MIN_POSITIVE)).min(1.0)
    }

    fn chance_rising(&self, freedom: usize) -> f64 {
        student::below(self.end.y / self.covariance.m22.sqrt(), freedom)
    }
}

/// What the readings of one edge say: wear whose rate strays like a random walk by an unknown amount, seen through
/// readings of an unknown scatter.
///
/// A rate that never strays (a straight line) has three tenths of the weight beforehand, 27 roughnesses share the rest; the
/// readings then weigh them by the restricted likelihood. The scatter is that of the readings, at least what they state
/// (0.3 µm where they do not); Student's distribution of n − 2 degrees stands for what n readings leave open of it. Where
/// every reading states an uncertainty they weigh by it. Valid from [`LEAST_PLACES`] numbers of parts; how far ahead
/// anything can be said, the straying itself tells.
#[derive(Debug, Clone)]
pub struct WearCourse {
    components: Vec<Component>,
    freedom: usize,
    first_parts: u32,
    last_parts: u32,
    fitted_mm: Vec<f64>,
    scatter_mm: f64,
}

impl WearCourse {
    /// The course of these readings.
    ///
    /// # Errors
    /// Readings at fewer than [`LEAST_PLACES`] numbers of parts, or not in their order.
    pub fn of(readings: &[WearReading]) -> Result<Self, CourseFault> {
        if let Some(before) =
            readings.windows(2).position(|pair| matches!(pair, [one, next] if one.parts_cut > next.parts_cut))
        {
            return Err(CourseFault::OutOfOrder { reading: before + 1 });
        }
        let mut parts: Vec<u32> = readings.iter().map(|reading| reading.parts_cut).collect();
        parts.dedup();
        let few = CourseFault::TooFew { found: parts.len() };
        let (Some(first_parts), Some(last_parts)) = (parts.first().copied(), parts.last().copied()) else {
            return Err(few);
        };
        if parts.len() < LEAST_PLACES {
            return Err(few);
        }
        let span = f64::from(last_parts) - f64::from(first_parts);
        let place = |reading: &WearReading| (f64::from(reading.parts_cut) - f64::from(last_parts)) / span;
        let places: Vec<f64> = readings.iter().map(place).collect();
        let stated: Option<Vec<f64>> =
            readings.iter().map(|reading| reading.standard_uncertainty_mm).collect();
        let deviations_mm = stated.unwrap_or_else(|| vec![LEAST_SCATTER_MM; readings.len()]);
        let variance_mm2: Vec<f64> = deviations_mm.iter().map(|deviation| deviation * deviation).collect();
        let count = readings.len() as f64;
        let typical_mm2 = variance_mm2.iter().sum::<f64>() / count;
        // About their mean the readings are small numbers.
        let middle_mm = readings.iter().map(|reading| reading.wear_mm).sum::<f64>() / count;
        let wear_mm: Vec<f64> = readings.iter().map(|reading| reading.wear_mm - middle_mm).collect();
        let scaled = Scaled { places: &places, wear_mm: &wear_mm, variance_mm2: &variance_mm2 };

        let freedom = readings.len() - 2;
        let fits: Vec<(Fitted, f64, f64)> = walks(typical_mm2)
            .filter_map(|(walk, prior)| {
                let fitted = scaled.fit(walk)?;
                let factor = (fitted.square / freedom as f64).max(1.0);
                let misfit = freedom as f64 * factor.ln() + fitted.square / factor;
                Some((fitted, walk, prior.ln() - 0.5 * (fitted.log_determinant + misfit)))
            })
            .collect();
        let best = fits.iter().max_by(|one, other| one.2.total_cmp(&other.2)).ok_or(few)?;
        let factor = |fitted: &Fitted| (fitted.square / freedom as f64).max(1.0);
        let counts = |likelihood: f64| (likelihood - best.2).exp() > NEGLIGIBLE;
        let kept = || fits.iter().filter(|(.., likelihood)| counts(*likelihood));
        let whole: f64 = kept().map(|(.., likelihood)| (likelihood - best.2).exp()).sum();
        let components: Vec<Component> = kept()
            .map(|(fitted, walk, likelihood)| Component {
                share: (likelihood - best.2).exp() / whole,
                end: Vector2::new(fitted.end.x + middle_mm, fitted.end.y),
                covariance: fitted.covariance * factor(fitted),
                walk: walk * factor(fitted),
                scatter: factor(fitted).sqrt(),
            })
            .collect();
        let smoothed_mm = scaled.smooth(best.1, best.0.start);
        let fitted_mm = smoothed_mm.into_iter().map(|wear_mm| wear_mm + middle_mm).collect();
        let scatter: f64 = components.iter().map(|component| component.share * component.scatter).sum();
        let scatter_mm = scatter * typical_mm2.sqrt();
        Ok(Self { components, freedom, first_parts, last_parts, fitted_mm, scatter_mm })
    }

    /// Parts at the first reading.
    #[must_use]
    pub fn first_parts(&self) -> u32 {
        self.first_parts
    }

    /// Parts at the last reading.
    #[must_use]
    pub fn last_parts(&self) -> u32 {
        self.last_parts
    }

    /// The likeliest wear at every reading \[mm\].
    #[must_use]
    pub fn fitted_mm(&self) -> &[f64] {
        &self.fitted_mm
    }

    /// Standard deviation of a typical reading about the course \[mm\].
    #[must_use]
    pub fn scatter_mm(&self) -> f64 {
        self.scatter_mm
    }

    /// Wear and rate at the last reading.
    #[must_use]
    pub fn now(&self) -> WearRate {
        let mean = |of: &dyn Fn(&Component) -> f64| -> f64 {
            self.components.iter().map(|component| component.share * of(component)).sum()
        };
        let span = f64::from(self.last_parts) - f64::from(self.first_parts);
        WearRate {
            wear_mm: mean(&|component| component.end.x),
            rate_mm_per_part: mean(&|component| component.end.y) / span,
            chance_rising: mean(&|component| component.chance_rising(self.freedom)),
        }
    }

    /// Whether it is at least 90 % sure that the wear still grows at the last reading.
    #[must_use]
    pub fn is_rising(&self) -> bool {
        self.now().chance_rising >= RISING
    }

    /// Probability that the wear once `parts` are cut is above `wear_mm` \[mm\]; for parts before the last reading that of
    /// the last reading. Wear does not fall: only courses count that end no lower than they are now.
    #[must_use]
    pub fn chance_above(&self, parts: f64, wear_mm: f64) -> f64 {
        let span = f64::from(self.last_parts) - f64::from(self.first_parts);
        let ahead = ((parts - f64::from(self.last_parts)) / span).max(0.0);
        let above = |component: &Component| component.chance_above(ahead, wear_mm, self.freedom);
        self.components.iter().map(|component| component.share * above(component)).sum()
    }

    /// The wear that is exceeded with `probability` once `parts` are cut \[mm\], between `least_mm` and `most_mm`.
    #[must_use]
    pub fn exceeded_mm(&self, parts: f64, probability: f64, [least_mm, most_mm]: [f64; 2]) -> f64 {
        let (mut low_mm, mut high_mm) = (least_mm, most_mm);
        // A thousand millionth of the stretch is left.
        for _ in 0..30 {
            let middle_mm = 0.5 * (low_mm + high_mm);
            if self.chance_above(parts, middle_mm) > probability {
                low_mm = middle_mm;
            } else {
                high_mm = middle_mm;
            }
        }
        0.5 * (low_mm + high_mm)
    }
}

/// The walks tried \[mm² per span\], each with its weight beforehand.
fn walks(typical_mm2: f64) -> impl Iterator<Item = (f64, f64)> {
    let rough = std::iter::successors(Some(LEAST_ROUGHNESS), |roughness| Some(roughness * 10.0_f64.sqrt()));
    let each = (1.0 - STRAIGHT) / f64::from(ROUGHNESSES);
    let rough = rough.take(ROUGHNESSES as usize).map(move |roughness| (roughness * typical_mm2, each));
    std::iter::once((0.0, STRAIGHT)).chain(rough)
}
