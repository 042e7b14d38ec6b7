//! Why a verification cannot be made as it was asked for.

use crate::contact::CutterBodyFault;
use thiserror::Error;

/// A length that a verification is asked with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VerificationQuantity {
    /// Height of the stock.
    Stock,
    /// Distance between a motion and what stands for it.
    Resolution,
    /// Residuals beyond it are counted.
    Limit,
}

/// Why a verification cannot be what it is asked to be.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum VerificationFault {
    /// The cutter has no body.
    #[error(transparent)]
    CutterBody(#[from] CutterBodyFault),
    /// A length outside its range.
    #[error("{length_mm:e} mm is not between {min_mm} mm and {max_mm} mm")]
    OutOfRange {
        /// Which length.
        quantity: VerificationQuantity,
        /// What was asked for \[mm\].
        length_mm: f64,
        /// Smallest accepted \[mm\].
        min_mm: f64,
        /// Largest accepted \[mm\].
        max_mm: f64,
    },
    /// No sample of the surface.
    #[error("the surface has no samples")]
    NoSamples,
    /// Samples that are no points with unit normals; the first of them.
    #[error("{count} samples are not finite points with unit normals, the first is number {first}")]
    Samples {
        /// Index of the first.
        first: usize,
        /// How many.
        count: usize,
    },
}
