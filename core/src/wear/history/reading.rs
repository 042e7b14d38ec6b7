//! A measured wear, and why some are too few.

use thiserror::Error;

/// One measured wear of one edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WearReading {
    /// Parts cut since the cutter was new.
    pub parts_cut: u32,
    /// The wear \[mm\].
    pub wear_mm: f64,
    /// Its standard uncertainty \[mm\], where it is stated.
    pub standard_uncertainty_mm: Option<f64>,
}

/// Places along the parts that a course needs: two fix a line, the third says how far to trust it.
pub const LEAST_PLACES: usize = 3;

/// Why readings have no course.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum CourseFault {
    /// Too few different numbers of parts.
    #[error("{found} numbers of parts were measured at, and {LEAST_PLACES} are needed")]
    TooFew {
        /// Different numbers of parts among the readings.
        found: usize,
    },
    /// A reading at fewer parts than the one before.
    #[error("reading {reading} is not in the order of the parts")]
    OutOfOrder {
        /// Index of the reading.
        reading: usize,
    },
}
