//! Samples along a segment, dense enough to speak for the whole of it.

use super::{Deviation, Segment, SourceBlock};

/// What sampling a segment found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampled {
    /// Largest deviation [mm].
    pub max_mm: f64,
    /// Mean of the squared deviation over the segment's fraction [mm²].
    pub mean_square_mm2: f64,
    /// Largest part of the deviation along the surface normal, out of the part [mm], never negative.
    pub max_excess_mm: f64,
    /// Largest part of it into the part [mm], never negative.
    pub max_gouge_mm: f64,
    /// How many points were evaluated.
    pub evaluations: u64,
}

/// First number of steps.
const FIRST_STEPS: u32 = 8;
/// Steps after which a segment without a usable bound is given up refining.
const MAX_STEPS: u32 = 4096;
/// Without a bound: samples are doubled until the maximum changes by less than this share of the tolerance (§2).
const UNBOUNDED_CHANGE: f64 = 0.01;
/// What may lie between samples, as a share of the maximum found.
const MEASURE_SLACK: f64 = 0.005;
/// … or of this share of the tolerance, whichever is more: smaller maxima need no such care.
const SMALL_SHARE: f64 = 0.1;
/// What may lie between samples when a tolerance is just kept, as a share of the tolerance: below the last digit
/// that any control resolves.
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

    /// The parts of one block joined, each weighted by its share of the block.
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

/// The maximum of a segment measured to half a per cent: steps are doubled until `|c″|/(8N²)` is below that share
/// of it (or, where no bound exists, until the maximum changes by less than 1 % of `tolerance_mm`), then the
/// parabola through the largest sample and its neighbours is followed to its top.
#[must_use]
pub fn sample_until_sure(block: &SourceBlock<'_>, segment: &Segment, tolerance_mm: f64) -> Sampled {
    let bound = block.curvature_bound_mm(segment);
    let mut steps = FIRST_STEPS;
    let mut previous = f64::NEG_INFINITY;
    let mut evaluations = 0;
    loop {
        let (mut found, peak) = sample(block, segment, steps);
        evaluations += found.evaluations;
        let sure = match bound {
            Some(bound) => {
                slack_mm(bound, steps) <= MEASURE_SLACK * found.max_mm.max(SMALL_SHARE * tolerance_mm)
            }
            None => (found.max_mm - previous).abs() < UNBOUNDED_CHANGE * tolerance_mm,
        };
        if sure || steps >= MAX_STEPS {
            if let Some(s) = peak {
                found.see(block.deviation_at(segment, s));
                evaluations += 1;
            }
            found.evaluations = evaluations;
            return found;
        }
        previous = found.max_mm;
        steps *= 2;
    }
}

/// Whether a segment keeps within `tolerance_mm` everywhere: `Ok` with what was found, proven by the curvature
/// bound (or by doubling where there is none); `Err` with the largest deviation seen.
///
/// # Errors
/// The measurement of a segment that exceeds the tolerance, or that cannot be proven within 4096 steps.
pub fn within_tolerance(
    block: &SourceBlock<'_>,
    segment: &Segment,
    tolerance_mm: f64,
) -> Result<Sampled, Sampled> {
    let bound = block.curvature_bound_mm(segment);
    let mut steps = FIRST_STEPS;
    let mut previous = f64::NEG_INFINITY;
    let mut evaluations = 0;
    loop {
        let (mut found, _) = sample(block, segment, steps);
        evaluations += found.evaluations;
        found.evaluations = evaluations;
        if found.max_mm > tolerance_mm {
            return Err(found);
        }
        let proven = match bound {
            Some(bound) => {
                let slack = slack_mm(bound, steps);
                found.max_mm + slack <= tolerance_mm
                    || (slack < VERIFY_SLACK * tolerance_mm && found.max_mm <= tolerance_mm)
            }
            None => (found.max_mm - previous).abs() < UNBOUNDED_CHANGE * tolerance_mm,
        };
        if proven {
            return Ok(found);
        }
        if steps >= MAX_STEPS {
            return Err(found);
        }
        previous = found.max_mm;
        steps *= 2;
    }
}

/// How much larger than the sampled maximum the true one can be [mm].
fn slack_mm(curvature_bound_mm: f64, steps: u32) -> f64 {
    curvature_bound_mm / (8.0 * f64::from(steps).powi(2))
}

/// `steps` equal steps, both ends included; with the place where a parabola through the largest inner sample
/// and its neighbours has its top.
fn sample(block: &SourceBlock<'_>, segment: &Segment, steps: u32) -> (Sampled, Option<f64>) {
    let mut found = Sampled::NOTHING;
    let mut window = [0.0; 3];
    let mut peak: (f64, Option<f64>) = (f64::NEG_INFINITY, None);
    for index in 0..=steps {
        let deviation = block.deviation_at(segment, f64::from(index) / f64::from(steps));
        found.see(deviation);
        let weight = if index == 0 || index == steps { 0.5 } else { 1.0 };
        found.mean_square_mm2 += weight * deviation.distance_mm.powi(2) / f64::from(steps);
        window = [window[1], window[2], deviation.distance_mm];
        let [a, b, c] = window;
        if index >= 2 && b >= a && b >= c && b > peak.0 {
            let bend = a - 2.0 * b + c;
            let shift = if bend < 0.0 { 0.5 * (a - c) / bend } else { 0.0 };
            peak = (b, Some((f64::from(index - 1) + shift) / f64::from(steps)));
        }
    }
    found.evaluations = u64::from(steps) + 1;
    (found, peak.1)
}
