//! Why a verification is refused.

use crate::contact::CutterBodyFault;
use thiserror::Error;

use crate::units::legible;

/// A length given in a verification request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VerificationQuantity {
    /// Height of the stock.
    Stock,
    /// Largest distance between a motion and its approximation.
    Resolution,
    /// Limit above which residuals are counted.
    Limit,
}

/// Why a verification is refused.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum VerificationFault {
    /// The cutter is not a solid body.
    #[error(transparent)]
    CutterBody(#[from] CutterBodyFault),
    /// A length outside its range.
    #[error("{} mm is not between {min_mm} mm and {max_mm} mm", legible(.length_mm))]
    OutOfRange {
        /// The quantity.
        quantity: VerificationQuantity,
        /// The length asked for \[mm\].
        length_mm: f64,
        /// Smallest accepted \[mm\].
        min_mm: f64,
        /// Largest accepted \[mm\].
        max_mm: f64,
    },
    /// The surface has no samples.
    #[error("the surface has no samples")]
    NoSamples,
    /// Samples that are not finite points with unit normals.
    #[error("{count} samples are not finite points with unit normals, the first is number {first}")]
    Samples {
        /// Index of the first.
        first: usize,
        /// How many.
        count: usize,
    },
}
