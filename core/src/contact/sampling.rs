//! Samples along a segment, dense enough for a statement about the whole segment.

use super::{Deviation, Segment, SourceBlock};

/// The result of sampling a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampled {
    /// Largest deviation \[mm\].
    pub max_mm: f64,
    /// Mean of the squared deviation over the segment's fraction \[mm²\].
    pub mean_square_mm2: f64,
    /// Largest part of the deviation along the surface normal, out of the part \[mm\], never negative.
    pub max_excess_mm: f64,
    /// Largest part of the deviation into the part \[mm\], never negative.
    pub max_gouge_mm: f64,
    /// Number of points evaluated.
    pub evaluations: u64,
}

/// First number of steps.
const FIRST_STEPS: u32 = 4;
/// Number of samples that are evaluated at once: as many as the first halving adds.
const AT_ONCE: usize = FIRST_STEPS as usize;
/// Number of steps at which a segment without a usable bound is no longer refined.
const MAX_STEPS: u32 = 1024;
/// Without a bound: samples are doubled until the maximum changes by less than this share of the tolerance (§2).
const UNBOUNDED_CHANGE: f64 = 0.01;
/// … but at least this number of steps: a contact that turns right round does so in a small part of the block.
const UNBOUNDED_STEPS: u32 = 128;
/// Possible excess between samples, as a share of the maximum found.
const MEASURE_SLACK: f64 = 0.005;
/// … or of this share of the tolerance, whichever is larger: smaller maxima need less care.
const SMALL_SHARE: f64 = 0.1;
/// Possible excess between samples when a tolerance is only just kept, as a share of the tolerance: below the
/// last digit that any control resolves.
const VERIFY_SLACK: f64 = 1e-4;

impl Sampled {
    const NOTHING: Self =
        Self { max_mm: 0.0, mean_square_mm2: 0.0, max_excess_mm: 0.0, max_gouge_mm: 0.0, evaluations: 0 };

    /// Takes one deviation into the maxima.
    fn see(&mut self, deviation: Deviation) {
        self.max_mm = self.max_mm.max(deviation.distance_mm);
        self.max_excess_mm = self.max_excess_mm.max(deviation.along_normal_mm);
        self.max_gouge_mm = self.max_gouge_mm.max(-deviation.along_normal_mm);
    }

    /// Joins the parts of one block, each weighted by its share of the block.
    pub fn join(parts: impl IntoIterator<Item = (f64, Self)>) -> Self {
        parts.into_iter().fold(Self::NOTHING, |mut whole, (share, part)| {
            whole.max_mm = whole.max_mm.max(part.max_mm);
            whole.mean_square_mm2 += share * part.mean_square_mm2;
            whole.max_excess_mm = whole.max_excess_mm.max(part.max_excess_mm);
            whole.max_gouge_mm = whole.max_gouge_mm.max(part.max_gouge_mm);
            whole.evaluations += part.evaluations;
            whole
        })
    }
}

/// Samples of one segment, refined by halving the steps: no point is evaluated twice.
struct Samples<'a, 'b> {
    block: &'a SourceBlock<'b>,
    segment: &'a Segment,
    steps: u32,
    /// Squared distance sums of the ends and of the inner points \[mm²\].
    ends_square_mm2: f64,
    inner_square_mm2: f64,
    found: Sampled,
    /// Position of the largest distance, as a fraction of the segment.
    peak: f64,
}

impl<'a, 'b> Samples<'a, 'b> {
    fn new(block: &'a SourceBlock<'b>, segment: &'a Segment) -> Self {
        let found = Sampled::NOTHING;
        let mut samples = Self {
            block,
            segment,
            steps: FIRST_STEPS,
            ends_square_mm2: 0.0,
            inner_square_mm2: 0.0,
            found,
            peak: 0.0,
        };
        let first: [f64; FIRST_STEPS as usize + 1] =
            std::array::from_fn(|index| index as f64 / f64::from(FIRST_STEPS));
        let found = block.deviations_at(segment, &first);
        for (index, (s, deviation)) in first.into_iter().zip(found).enumerate() {
            let square = samples.see(s, deviation);
            if index == 0 || index == FIRST_STEPS as usize {
                samples.ends_square_mm2 += square;
            } else {
                samples.inner_square_mm2 += square;
            }
        }
        samples
    }

    /// Adds a sample between every two.
    fn halve(&mut self) {
        self.steps *= 2;
        let steps = f64::from(self.steps);
        // There are at least as many new samples as are evaluated at once, and a power of two of them.
        for first in (1..self.steps).step_by(2 * AT_ONCE) {
            let places: [f64; AT_ONCE] =
                std::array::from_fn(|index| (f64::from(first) + 2.0 * index as f64) / steps);
            let found = self.block.deviations_at(self.segment, &places);
            for (s, deviation) in places.into_iter().zip(found) {
                self.inner_square_mm2 += self.see(s, deviation);
            }
        }
    }

    fn evaluate(&mut self, s: f64) -> f64 {
        self.see(s, self.block.deviation_at(self.segment, s))
    }

    /// Takes the deviation at `s`. Returns its square \[mm²\].
    fn see(&mut self, s: f64, deviation: Deviation) -> f64 {
        if deviation.distance_mm > self.found.max_mm {
            self.peak = s;
        }
        self.found.see(deviation);
        self.found.evaluations += 1;
        deviation.distance_mm.powi(2)
    }

    /// Largest excess of the true maximum over the sampled maximum \[mm\].
    fn slack_mm(&self, curvature_bound_mm: f64) -> f64 {
        curvature_bound_mm / (8.0 * f64::from(self.steps).powi(2))
    }

    /// Without a bound: whether halving the steps no longer changes the maximum.
    fn settled(&self, previous_mm: f64, tolerance_mm: f64) -> bool {
        self.steps >= UNBOUNDED_STEPS
            && (self.found.max_mm - previous_mm).abs() < UNBOUNDED_CHANGE * tolerance_mm
    }

    /// The result, with the mean square by the trapezoidal rule.
    fn result(mut self) -> Sampled {
        let sum = 0.5 * self.ends_square_mm2 + self.inner_square_mm2;
        self.found.mean_square_mm2 = sum / f64::from(self.steps);
        self.found
    }

    /// Follows the parabola through the largest inner sample and its neighbours to its vertex.
    fn climb(&mut self) {
        let step = 1.0 / f64::from(self.steps);
        if self.peak <= 0.5 * step || self.peak >= 1.0 - 0.5 * step {
            return;
        }
        let [a, b, c] = [self.peak - step, self.peak, self.peak + step]
            .map(|s| self.block.deviation_at(self.segment, s).distance_mm);
        self.found.evaluations += 3;
        let bend = a - 2.0 * b + c;
        if bend < 0.0 {
            self.evaluate(self.peak + 0.5 * (a - c) / bend * step);
        }
    }
}

/// Measures the maximum of a segment to half a per cent. Steps are halved until `|c″|/(8N²)` is below that share
/// of it (or, if no bound exists, until the maximum changes by less than 1 % of `tolerance_mm`). Then the
/// parabola through the largest sample and its neighbours is followed to its vertex.
#[must_use]
pub fn sample_until_sure(block: &SourceBlock<'_>, segment: &Segment, tolerance_mm: f64) -> Sampled {
    let bound = block.curvature_bound_mm(segment);
    let mut samples = Samples::new(block, segment);
    let mut previous = f64::NEG_INFINITY;
    loop {
        let largest = samples.found.max_mm;
        let sure = match bound {
            Some(bound) => samples.slack_mm(bound) <= MEASURE_SLACK * largest.max(SMALL_SHARE * tolerance_mm),
            None => samples.settled(previous, tolerance_mm),
        };
        if sure || samples.steps >= MAX_STEPS {
            samples.climb();
            return samples.result();
        }
        previous = largest;
        samples.halve();
    }
}

/// Whether a segment keeps within `tolerance_mm` everywhere: `Ok` with the result, proven by the curvature bound
/// (or by halving the steps if no bound is known); `Err` with the largest deviation seen.
///
/// # Errors
/// The measurement of a segment that exceeds the tolerance, or that cannot be proven within 1024 steps.
pub fn within_tolerance(
    block: &SourceBlock<'_>,
    segment: &Segment,
    tolerance_mm: f64,
) -> Result<Sampled, Sampled> {
    let bound = block.curvature_bound_mm(segment);
    let mut samples = Samples::new(block, segment);
    let mut previous = f64::NEG_INFINITY;
    loop {
        let largest = samples.found.max_mm;
        if largest > tolerance_mm {
            return Err(samples.result());
        }
        let proven = match bound {
            Some(bound) => {
                let slack = samples.slack_mm(bound);
                largest + slack <= tolerance_mm || slack < VERIFY_SLACK * tolerance_mm
            }
            None => samples.settled(previous, tolerance_mm),
        };
        if proven {
            return Ok(samples.result());
        }
        if samples.steps >= MAX_STEPS {
            return Err(samples.result());
        }
        previous = largest;
        samples.halve();
    }
}
