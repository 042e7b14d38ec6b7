//! The course of one edge's wear, and the present wear from it.

use nalgebra::{Matrix2, Vector2};

use super::filter::{Fitted, Scaled, Tried};
use super::{CourseFault, LEAST_PLACES, WearReading, normal};

/// Smallest scatter of a reading without a stated uncertainty \[mm\]: rounding to the whole micrometre alone gives
/// 1/√12 of it.
const LEAST_SCATTER_MM: f64 = 0.3e-3;
/// Prior median of the scatter of a reading \[mm\] without a stated uncertainty: tool setters repeat to 1 µm, flank
/// wear under a microscope is read to 2 to 5 µm.
const USUAL_SCATTER_MM: f64 = 1.5e-3;
/// Logarithmic width of that prior (a factor of 3), with the tails of a Cauchy distribution: readings may be far
/// worse.
const SCATTER_WIDTH: f64 = 1.1;
/// Number of scatters tried, from the smallest (or the stated one) up, each 1.45 times the one before: up to 800
/// times as much.
const SCATTERS: u32 = 19;
const SCATTER_RATIO: f64 = 1.45;
/// Correlations of neighbouring readings that are tried, with their prior weights: zero is as likely as the others
/// together. The same person at the same microscope misreads the same wear in the same way.
const CORRELATIONS: [(f64, f64); 3] = [(0.0, 0.5), (0.35, 0.25), (0.7, 0.25)];
/// Squares of the roughnesses tried: the variation of the rate over the span, relative to the scatter of one
/// reading. They range from an invisible variation to one that leaves no scatter, two in each decade.
const LEAST_ROUGHNESS: f64 = 1e-2;
const ROUGHNESSES: u32 = 26;
/// Prior median of the variation of the rate over the span, relative to the mean rate. With the width below, it is
/// a seventh to three times in nineteen of twenty cases: no rate of wear stays constant to a tenth, and few change
/// more than threefold within a stage.
const USUAL_DRIFT: f64 = 0.7;
/// Logarithmic width of that prior (a factor of 2.2).
const DRIFT_WIDTH: f64 = 0.8;
/// Smallest and largest drift tried.
const DRIFTS: [f64; 2] = [0.02, 5.0];
/// Smallest mean rate, relative to the wear divided by the parts since the cutter was new. A rate that is zero now,
/// or readings that began on a plateau, do not make the whole cutter slow.
const OF_LIFE: f64 = 0.5;
/// Wear counts as rising from this probability of a rate above zero on.
const RISING: f64 = 0.9;
/// Combinations below this likelihood, relative to the likeliest, are ignored.
const NEGLIGIBLE: f64 = 1e-4;

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

/// The quality of the readings and the steadiness of the wear, as means over the likely combinations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CourseBasis {
    /// Number of readings.
    pub readings: usize,
    /// Number of different part counts among them.
    pub places: usize,
    /// Standard deviation of a typical reading about the course \[mm\].
    pub scatter_mm: f64,
    /// Correlation of the errors of neighbouring readings.
    pub correlation: f64,
    /// Variation of the rate over the span of the readings (standard deviation), relative to the reference rate.
    pub drift: f64,
    /// Mean rate to which variation and later stages are relative \[mm per part\].
    pub reference_mm_per_part: f64,
}

/// One scatter, correlation and roughness, with its share of the whole.
#[derive(Debug, Clone, Copy)]
pub(super) struct Component {
    pub(super) share: f64,
    /// Wear \[mm\] and rate \[mm per span\] at the last reading.
    pub(super) end: Vector2<f64>,
    pub(super) covariance: Matrix2<f64>,
    /// Variation of the rate over a span, relative to the reference.
    pub(super) drift: f64,
    /// The reference rate \[mm per span\].
    pub(super) reference: f64,
    /// Standard deviation of a reading, relative to the stated or smallest one.
    scatter: f64,
    correlation: f64,
}

impl Component {
    /// Probability that the wear `ahead` spans after the last reading is above `wear_mm`, if the rate continues to
    /// vary as before.
    fn chance_above(&self, ahead: f64, wear_mm: f64) -> f64 {
        let c = &self.covariance;
        let walk = self.drift * self.reference;
        let variance =
            c.m11 + ahead * (2.0 * c.m12 + ahead * c.m22) + walk * walk * ahead * ahead * ahead / 3.0;
        let deviation_mm = variance.max(f64::MIN_POSITIVE).sqrt();
        normal::below((self.end.x + self.end.y * ahead - wear_mm) / deviation_mm)
    }

    fn chance_rising(&self) -> f64 {
        normal::below(self.end.y / self.covariance.m22.max(f64::MIN_POSITIVE).sqrt())
    }
}

/// The wear estimated from the readings of one edge. Its rate varies like a random walk by an unknown amount, and
/// the readings have an unknown scatter, with possibly correlated errors.
///
/// Scatter, correlation and variation are tried on a grid. Each has a prior weight from the constants of this file,
/// with their reasons; the readings then weight them by the restricted likelihood. No estimate counts as known: if
/// few readings leave a value uncertain, the interval becomes wider. The scatter is never below the stated one (0.3
/// µm if none is stated). If every reading states an uncertainty, readings are weighted by it. Valid from
/// [`LEAST_PLACES`] numbers of parts.
#[derive(Debug, Clone)]
pub struct WearCourse {
    components: Vec<Component>,
    readings: usize,
    places: usize,
    first_parts: u32,
    last_parts: u32,
    fitted_mm: Vec<f64>,
    typical_mm: f64,
    neighbours_mm: f64,
}

/// The readings in the scale of the filter, with the values that the grid needs.
struct Prepared {
    places: Vec<f64>,
    /// Wear relative to its mean, so that the numbers are small \[mm\].
    wear_mm: Vec<f64>,
    middle_mm: f64,
    deviations_mm: Vec<f64>,
    typical_mm: f64,
    /// Prior median of the scatter, relative to the typical deviation.
    usual: f64,
    /// Slope of least squares \[mm per span\], and its standard deviation for a unit of scatter.
    slope: f64,
    slope_deviation: f64,
    /// Spans since the cutter was new.
    age: f64,
}

impl Prepared {
    fn of(readings: &[WearReading], first_parts: u32, last_parts: u32) -> Self {
        let span = f64::from(last_parts) - f64::from(first_parts);
        let place = |reading: &WearReading| (f64::from(reading.parts_cut) - f64::from(last_parts)) / span;
        let places: Vec<f64> = readings.iter().map(place).collect();
        let stated: Option<Vec<f64>> =
            readings.iter().map(|reading| reading.standard_uncertainty_mm).collect();
        let usual = if stated.is_some() { 1.0 } else { USUAL_SCATTER_MM / LEAST_SCATTER_MM };
        let deviations_mm = stated.unwrap_or_else(|| vec![LEAST_SCATTER_MM; readings.len()]);
        let count = readings.len() as f64;
        let square = deviations_mm.iter().map(|deviation| deviation * deviation).sum::<f64>() / count;
        let middle_mm = readings.iter().map(|reading| reading.wear_mm).sum::<f64>() / count;
        let wear_mm: Vec<f64> = readings.iter().map(|reading| reading.wear_mm - middle_mm).collect();
        let middle = places.iter().sum::<f64>() / count;
        let about = || places.iter().map(|place| place - middle);
        let squares = about().map(|place| place * place).sum::<f64>();
        let slope = about().zip(&wear_mm).map(|(place, wear)| place * wear).sum::<f64>() / squares;
        let age = f64::from(last_parts) / span;
        Self {
            slope,
            slope_deviation: squares.sqrt().recip(),
            places,
            wear_mm,
            middle_mm,
            deviations_mm,
            typical_mm: square.sqrt(),
            usual,
            age,
        }
    }

    fn scaled(&self) -> Scaled<'_> {
        Scaled { places: &self.places, wear_mm: &self.wear_mm, deviations_mm: &self.deviations_mm }
    }

    /// All scatters for one fit, with the logarithm of their weight and likelihood.
    fn weighed<'a>(
        &'a self,
        fitted: &'a Fitted,
        tried: Tried,
        weight: f64,
    ) -> impl Iterator<Item = (f64, Component)> + 'a {
        let freedom = self.wear_mm.len() as f64 - 2.0;
        let scatters = std::iter::successors(Some(1.0), |scatter| Some(scatter * SCATTER_RATIO));
        scatters.take(SCATTERS as usize).filter_map(move |scatter| {
            let end = Vector2::new(fitted.end.x + self.middle_mm, fitted.end.y);
            // A slope that the readings cannot distinguish from zero may be this large.
            let unseen = scatter * self.typical_mm * self.slope_deviation;
            let reference = self.slope.abs().max(OF_LIFE * end.x / self.age).max(unseen);
            let drift = scatter * tried.walk.sqrt() / reference;
            if !(DRIFTS[0]..=DRIFTS[1]).contains(&drift) {
                return None;
            }
            let strange = (scatter / self.usual).ln() / SCATTER_WIDTH;
            let rough = (drift / USUAL_DRIFT).ln() / DRIFT_WIDTH;
            let beforehand = weight.ln() - (1.0 + strange * strange).ln() - 0.5 * rough * rough;
            let misfit = freedom * scatter.ln() + 0.5 * fitted.square / (scatter * scatter);
            let likelihood = beforehand - misfit - 0.5 * fitted.log_determinant;
            let component = Component {
                share: 0.0,
                end,
                covariance: fitted.covariance * (scatter * scatter),
                drift,
                reference,
                scatter,
                correlation: tried.correlation,
            };
            Some((likelihood, component))
        })
    }
}

impl WearCourse {
    /// The course of these readings.
    ///
    /// # Errors
    /// Readings at fewer than [`LEAST_PLACES`] numbers of parts, or readings out of order.
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
        let prepared = Prepared::of(readings, first_parts, last_parts);
        let mut found: Vec<(f64, Component)> = Vec::new();
        let mut best: Option<(f64, Tried, Vector2<f64>)> = None;
        for (tried, weight) in grid(prepared.typical_mm) {
            let Some(fitted) = prepared.scaled().fit(tried) else { continue };
            for (likelihood, component) in prepared.weighed(&fitted, tried, weight) {
                if best.is_none_or(|(most, ..)| likelihood > most) {
                    best = Some((likelihood, tried, fitted.start));
                }
                found.push((likelihood, component));
            }
        }
        let (most, likeliest, start) = best.ok_or(few)?;
        found.retain(|(likelihood, _)| (likelihood - most).exp() > NEGLIGIBLE);
        let whole: f64 = found.iter().map(|(likelihood, _)| (likelihood - most).exp()).sum();
        let components = found
            .into_iter()
            .map(|(likelihood, component)| Component {
                share: (likelihood - most).exp() / whole,
                ..component
            })
            .collect();
        let smoothed_mm = prepared.scaled().smooth(likeliest, start);
        let fitted_mm = smoothed_mm.into_iter().map(|wear_mm| wear_mm + prepared.middle_mm).collect();
        Ok(Self {
            components,
            readings: readings.len(),
            places: parts.len(),
            first_parts,
            last_parts,
            fitted_mm,
            typical_mm: prepared.typical_mm,
            neighbours_mm: neighbours(&prepared.wear_mm).max(prepared.typical_mm),
        })
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

    /// Parts between the first reading and the last.
    pub(super) fn span(&self) -> f64 {
        f64::from(self.last_parts) - f64::from(self.first_parts)
    }

    pub(super) fn components(&self) -> &[Component] {
        &self.components
    }

    /// The likeliest wear at every reading \[mm\].
    #[must_use]
    pub fn fitted_mm(&self) -> &[f64] {
        &self.fitted_mm
    }

    fn mean(&self, of: impl Fn(&Component) -> f64) -> f64 {
        self.components.iter().map(|component| component.share * of(component)).sum()
    }

    /// Standard deviation of a typical reading about the course \[mm\].
    #[must_use]
    pub fn scatter_mm(&self) -> f64 {
        self.mean(|component| component.scatter) * self.typical_mm
    }

    /// Standard deviation of a reading from the differences of its neighbours \[mm\], at least the stated one. A
    /// few wrong readings or a changed cutter do not make it larger, as they do the scatter. With correlated errors
    /// it is too small, by half at most.
    #[must_use]
    pub fn neighbour_scatter_mm(&self) -> f64 {
        self.neighbours_mm
    }

    /// The quality of the readings and the steadiness of the wear.
    #[must_use]
    pub fn basis(&self) -> CourseBasis {
        CourseBasis {
            readings: self.readings,
            places: self.places,
            scatter_mm: self.scatter_mm(),
            correlation: self.mean(|component| component.correlation),
            drift: self.mean(|component| component.drift),
            reference_mm_per_part: self.mean(|component| component.reference) / self.span(),
        }
    }

    /// Wear and rate at the last reading.
    #[must_use]
    pub fn now(&self) -> WearRate {
        WearRate {
            wear_mm: self.mean(|component| component.end.x),
            rate_mm_per_part: self.mean(|component| component.end.y) / self.span(),
            // The shares add up to one except for rounding.
            chance_rising: self.mean(Component::chance_rising).min(1.0),
        }
    }

    /// Whether the wear still grows at the last reading with a probability of at least 90 %.
    #[must_use]
    pub fn is_rising(&self) -> bool {
        self.now().chance_rising >= RISING
    }

    /// Probability that the wear after `parts` parts is above `wear_mm` \[mm\], if the rate continues to vary as
    /// before and no new stage of wear begins. For parts before the last reading, that of the last reading.
    #[must_use]
    pub fn chance_above(&self, parts: f64, wear_mm: f64) -> f64 {
        let ahead = ((parts - f64::from(self.last_parts)) / self.span()).max(0.0);
        self.mean(|component| component.chance_above(ahead, wear_mm))
    }

    /// The median wear after `parts` parts \[mm\], if no new stage begins, between `least_mm` and `most_mm`.
    #[must_use]
    pub fn middle_mm(&self, parts: f64, [least_mm, most_mm]: [f64; 2]) -> f64 {
        let (mut low_mm, mut high_mm) = (least_mm, most_mm);
        // A thousand millionth of the interval is left.
        for _ in 0..30 {
            let middle_mm = 0.5 * (low_mm + high_mm);
            if self.chance_above(parts, middle_mm) > 0.5 {
                low_mm = middle_mm;
            } else {
                high_mm = middle_mm;
            }
        }
        0.5 * (low_mm + high_mm)
    }
}

/// Standard deviation of a reading, from the median distance of the steps between neighbours from their median:
/// 1.4826 times it for normal steps, each of two readings.
fn neighbours(wear_mm: &[f64]) -> f64 {
    let mut steps: Vec<f64> =
        wear_mm.windows(2).filter_map(|pair| Some(pair.get(1)? - pair.first()?)).collect();
    let middle = median(&mut steps);
    for step in &mut steps {
        *step = (*step - middle).abs();
    }
    1.4826 * median(&mut steps) / std::f64::consts::SQRT_2
}

/// The upper median of the values. It sorts them.
fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

/// The walks and correlations tried, each with its prior weight.
fn grid(typical_mm: f64) -> impl Iterator<Item = (Tried, f64)> {
    let roughnesses =
        move || std::iter::successors(Some(LEAST_ROUGHNESS), |roughness| Some(roughness * 10.0_f64.sqrt()));
    CORRELATIONS.into_iter().flat_map(move |(correlation, weight)| {
        roughnesses()
            .take(ROUGHNESSES as usize)
            .map(move |roughness| (Tried { walk: roughness * typical_mm * typical_mm, correlation }, weight))
    })
}
