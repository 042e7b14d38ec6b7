//! A measured wear, and why readings can be too few.

use thiserror::Error;

/// One measured wear of one edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WearReading {
    /// Parts cut since the cutter was new.
    pub parts_cut: u32,
    /// The wear \[mm\].
    pub wear_mm: f64,
    /// Its standard uncertainty \[mm\], if stated.
    pub standard_uncertainty_mm: Option<f64>,
}

/// Different part counts that a course needs: two determine a line, and the third shows how reliable it is.
pub const LEAST_PLACES: usize = 3;

/// Why readings give no course.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum CourseFault {
    /// Too few different numbers of parts.
    #[error(
        "the readings are at {found} different numbers of parts, but at least {LEAST_PLACES} are needed; measure again after more parts"
    )]
    TooFew {
        /// Different numbers of parts among the readings.
        found: usize,
    },
    /// A reading at fewer parts than the one before.
    #[error("reading {reading} is not in the order of the parts; sort the readings by parts")]
    OutOfOrder {
        /// Index of the reading.
        reading: usize,
    },
}
