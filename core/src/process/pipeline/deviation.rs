//! Deviations summed up for the report of a compensated program.

use crate::contact::Sampled;

/// Deviation over a whole program.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DeviationSummary {
    /// Largest deviation \[mm\].
    pub max_mm: f64,
    /// Root mean square over the contact path \[mm\].
    pub rms_mm: f64,
    /// Largest part along the normal, out of the part \[mm\].
    pub max_excess_mm: f64,
    /// Largest part along the normal, into the part \[mm\], as a magnitude.
    pub max_gouge_mm: f64,
    /// Line of the upload with the largest deviation.
    pub worst_line: Option<u64>,
}

/// Sums up deviations motion by motion.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::process) struct DeviationTotals {
    summary: DeviationSummary,
    weighted_square: f64,
    path_mm: f64,
    plain_square: f64,
    motions: f64,
}

impl DeviationTotals {
    pub(in crate::process) fn add(&mut self, line: u64, path_mm: f64, found: &Sampled) {
        let summary = &mut self.summary;
        if found.max_mm > summary.max_mm || summary.worst_line.is_none() {
            summary.max_mm = found.max_mm;
            summary.worst_line = Some(line);
        }
        summary.max_excess_mm = summary.max_excess_mm.max(found.max_excess_mm);
        summary.max_gouge_mm = summary.max_gouge_mm.max(found.max_gouge_mm);
        self.weighted_square += path_mm * found.mean_square_mm2;
        self.path_mm += path_mm;
        self.plain_square += found.mean_square_mm2;
        self.motions += 1.0;
    }

    pub(in crate::process) fn max_mm(&self) -> f64 {
        self.summary.max_mm
    }

    pub(in crate::process) fn path_mm(&self) -> f64 {
        self.path_mm
    }

    /// The summary. If the path has no length, every motion has the same weight.
    pub(in crate::process) fn summary(&self) -> DeviationSummary {
        let mean = if self.path_mm > 0.0 {
            self.weighted_square / self.path_mm
        } else if self.motions > 0.0 {
            self.plain_square / self.motions
        } else {
            0.0
        };
        DeviationSummary { rms_mm: mean.sqrt(), ..self.summary }
    }
}
