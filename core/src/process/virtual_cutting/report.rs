//! The result of a verification.

use crate::geometry::Vec3;
use crate::process::fault::{LeftOut, Warning};
use crate::process::text::ProgramReading;
use crate::program::Dialect;
use crate::surface::SurfacePoint;
use crate::units::Length;
use crate::wear::Residual;

/// Motions that were cut, by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MotionCounts {
    /// Straight motions at feed.
    pub linear: u64,
    /// Arcs and helices.
    pub arcs: u64,
    /// Rapids, taken as straight motions.
    pub rapids: u64,
}

impl MotionCounts {
    /// All motions.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.linear + self.arcs + self.rapids
    }
}

/// The largest residual of one sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extreme {
    /// Index of the sample.
    pub index: usize,
    /// The sample in W \[mm\].
    pub point_mm: Vec3,
    /// The residual at the sample.
    pub residual: Residual,
}

/// Residuals by size: [`Histogram::BINS`] equal bins between −4 and +4 limits, and one open bin on either side.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// Edges of the bins \[mm\], one more than bins. A bin includes its lower edge.
    pub edges_mm: Vec<f64>,
    /// Samples in each bin.
    pub counts: Vec<u64>,
    /// Samples below the first edge.
    pub below: u64,
    /// Samples at or above the last edge.
    pub above: u64,
}

impl Histogram {
    /// Number of equal bins, each a fifth of the limit wide.
    pub const BINS: usize = 40;
    /// The last edge, in limits.
    const REACH: f64 = 4.0;

    fn new(limit_mm: f64) -> Self {
        let half = 0.5 * Self::BINS as f64;
        let edges_mm =
            (0..=Self::BINS).map(|k| (k as f64 - half) * (Self::REACH * limit_mm / half)).collect();
        Self { edges_mm, counts: vec![0; Self::BINS], below: 0, above: 0 }
    }

    fn add(&mut self, residual_mm: f64) {
        let reached = self.edges_mm.partition_point(|edge| *edge <= residual_mm);
        match reached.checked_sub(1).map(|bin| self.counts.get_mut(bin)) {
            None => self.below += 1,
            Some(None) => self.above += 1,
            Some(Some(count)) => *count += 1,
        }
    }
}

/// The residuals of all samples, summed up.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualSummary {
    /// Samples cut by a tool position.
    pub cut: u64,
    /// Samples that no tool position cuts.
    pub uncut: u64,
    /// Samples with more excess than the limit.
    pub over_excess: u64,
    /// Samples gouged deeper than the limit.
    pub over_gouge: u64,
    /// Of these, samples gouged by a rapid.
    pub gouged_by_rapid: u64,
    /// Most material left; `None` if none is left.
    pub max_excess: Option<Extreme>,
    /// Deepest gouge; `None` if no sample is gouged.
    pub max_gouge: Option<Extreme>,
    /// Mean residual of the samples cut \[mm\].
    pub mean_mm: f64,
    /// Their root mean square \[mm\].
    pub rms_mm: f64,
    /// Line with the largest residual in magnitude.
    pub worst_line: Option<u64>,
    /// All residuals by size.
    pub histogram: Histogram,
}

impl ResidualSummary {
    /// Sums up residuals that are aligned with their samples.
    pub(in crate::process) fn of(
        samples: &[SurfacePoint],
        residuals: &[Option<Residual>],
        limit: Length,
    ) -> Self {
        let limit_mm = limit.mm();
        let mut summary = Self {
            cut: 0,
            uncut: 0,
            over_excess: 0,
            over_gouge: 0,
            gouged_by_rapid: 0,
            max_excess: None,
            max_gouge: None,
            mean_mm: 0.0,
            rms_mm: 0.0,
            worst_line: None,
            histogram: Histogram::new(limit_mm),
        };
        let (mut sum, mut square) = (0.0, 0.0);
        for (index, (sample, residual)) in samples.iter().zip(residuals).enumerate() {
            let Some(residual) = *residual else {
                summary.uncut += 1;
                continue;
            };
            let residual_mm = residual.residual_mm;
            summary.cut += 1;
            sum += residual_mm;
            square += residual_mm * residual_mm;
            summary.histogram.add(residual_mm);
            summary.over_excess += u64::from(residual_mm > limit_mm);
            summary.over_gouge += u64::from(residual_mm < -limit_mm);
            summary.gouged_by_rapid += u64::from(residual_mm < -limit_mm && residual.by_rapid);
            let extreme = Extreme { index, point_mm: sample.point_mm, residual };
            let [least_mm, most_mm] = [summary.max_gouge, summary.max_excess]
                .map(|found| found.map_or(0.0, |found| found.residual.residual_mm));
            if residual_mm > most_mm {
                summary.max_excess = Some(extreme);
            } else if residual_mm < least_mm {
                summary.max_gouge = Some(extreme);
            }
        }
        if summary.cut > 0 {
            summary.mean_mm = sum / summary.cut as f64;
            summary.rms_mm = (square / summary.cut as f64).sqrt();
        }
        let extremes = [summary.max_excess, summary.max_gouge];
        let worst = extremes.into_iter().flatten().map(|found| found.residual);
        summary.worst_line = worst
            .reduce(|a, b| if b.residual_mm.abs() > a.residual_mm.abs() { b } else { a })
            .map(|worst| worst.line);
        summary
    }
}

/// Change of the residuals when some samples are cut again eight times finer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Convergence {
    /// Number of samples cut again: those with the largest residuals, and evenly chosen ones.
    pub samples: u64,
    /// The finer resolution.
    pub resolution: Length,
    /// Largest change of a residual.
    pub max_change: Length,
    /// Samples that are cut in only one of the two computations.
    pub cut_once: u64,
}

/// The cost of the computation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Effort {
    /// Straight pieces that the motions were divided into.
    pub pieces: u64,
    /// Pairs of a sample and a piece that were compared one by one.
    pub pairs: u64,
    /// Pairs that lowered a residual.
    pub cuts: u64,
}

/// A program cut virtually, against the nominal surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Verification {
    /// The dialect in which it was read.
    pub dialect: Dialect,
    /// How the program was read.
    pub reading: ProgramReading,
    /// Blocks: non-empty lines that are not only comments.
    pub blocks: u64,
    /// Motions that were cut.
    pub motions: MotionCounts,
    /// Motions whose course is not known, by reason.
    pub left_out: Vec<LeftOut>,
    /// What the caller should know.
    pub warnings: Vec<Warning>,
    /// The residuals, summed up.
    pub summary: ResidualSummary,
    /// How exact the residuals are.
    pub convergence: Convergence,
    /// The cost of the computation.
    pub effort: Effort,
    /// The residual of every sample, in their order; `None` is uncut.
    pub residuals: Vec<Option<Residual>>,
}
