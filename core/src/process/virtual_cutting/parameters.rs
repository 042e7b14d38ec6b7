//! The parameters of a verification.

use crate::process::fault::{VerificationFault, VerificationQuantity};

use crate::contact::{CutterBody, CutterBodyFault};
use crate::machine::Tool;
use crate::process::set_up::ProgramSetup;
use crate::surface::SurfacePoint;
use crate::units::Length;

/// The parameters of a verification by virtual cutting.
#[derive(Debug, Clone, PartialEq)]
pub struct VerificationParameters {
    /// The cutter in the spindle; `None` takes each section's cutter from the machine's tool table.
    pub tool: Option<Tool>,
    /// Height above the tip up to which the cutter cuts; `None` is four radii, and at least 30 mm.
    pub cutting_length: Option<Length>,
    /// Height H of the stock over the surface, along the normal: the ends of the needles.
    pub stock: Length,
    /// Largest distance between the motion and its straight pieces.
    pub resolution: Length,
    /// Residuals larger than this are counted.
    pub limit: Length,
    /// The caller's statements that the text does not have.
    pub program: ProgramSetup,
    /// Most comparisons of samples, or groups of samples, with straight pieces.
    pub max_pairs: u64,
    /// Most straight pieces that the program's motions may be divided into.
    pub max_pieces: u64,
}

/// Largest error of a normal's length.
const UNIT: f64 = 1e-6;
/// Samples with coordinates beyond this are refused \[mm\].
const MAX_COORDINATE_MM: f64 = 1e5;

impl VerificationParameters {
    /// Accepted heights of stock \[mm\].
    pub const STOCK_RANGE_MM: [f64; 2] = [1e-3, 100.0];
    /// Accepted resolutions \[mm\].
    pub const RESOLUTION_RANGE_MM: [f64; 2] = [1e-5, 0.1];
    /// Accepted limits \[mm\].
    pub const LIMIT_RANGE_MM: [f64; 2] = [1e-5, 10.0];

    /// The defaults for a cutter: flank of four radii and at least 30 mm, 1 mm of stock, resolution 0.5 µm, limit 30
    /// µm.
    #[must_use]
    pub fn new(tool: impl Into<Option<Tool>>, program: ProgramSetup) -> Self {
        Self {
            tool: tool.into(),
            cutting_length: None,
            stock: Length::from_mm(1.0),
            resolution: Length::from_mm(5e-4),
            limit: Length::from_mm(0.03),
            program,
            max_pairs: 5_000_000_000,
            max_pieces: 50_000_000,
        }
    }

    /// Smallest height of a straight shank above the tip if no cutting length is stated \[mm\].
    const LEAST_LENGTH_MM: f64 = 30.0;

    /// The body of a cutter.
    ///
    /// # Errors
    /// A cutting length that does not reach above the corner.
    pub fn body(&self, tool: &Tool) -> Result<CutterBody, CutterBodyFault> {
        let radii_mm = CutterBody::DEFAULT_LENGTH_IN_RADII * tool.radius().mm();
        let usual = Length::from_mm(radii_mm.max(Self::LEAST_LENGTH_MM));
        CutterBody::new(tool, self.cutting_length.unwrap_or(usual))
    }

    /// Everything wrong with these parameters and samples; empty if nothing is.
    #[must_use]
    pub fn faults(&self, samples: &[SurfacePoint]) -> Vec<VerificationFault> {
        let body = self.tool.map(|tool| self.body(&tool));
        let mut faults: Vec<VerificationFault> =
            body.and_then(Result::err).into_iter().map(Into::into).collect();
        let lengths = [
            (VerificationQuantity::Stock, self.stock, Self::STOCK_RANGE_MM),
            (VerificationQuantity::Resolution, self.resolution, Self::RESOLUTION_RANGE_MM),
            (VerificationQuantity::Limit, self.limit, Self::LIMIT_RANGE_MM),
        ];
        for (quantity, length, [min_mm, max_mm]) in lengths {
            let length_mm = length.mm();
            // NaN is in no range.
            if !(min_mm..=max_mm).contains(&length_mm) {
                faults.push(VerificationFault::OutOfRange { quantity, length_mm, min_mm, max_mm });
            }
        }
        if samples.is_empty() {
            faults.push(VerificationFault::NoSamples);
        }
        let mut odd =
            samples.iter().enumerate().filter(|(_, sample)| !is_sound(sample)).map(|(index, _)| index);
        if let Some(first) = odd.next() {
            faults.push(VerificationFault::Samples { first, count: 1 + odd.count() });
        }
        faults
    }
}

fn is_sound(sample: &SurfacePoint) -> bool {
    sample.point_mm.iter().all(|at_mm| at_mm.abs() <= MAX_COORDINATE_MM)
        && (sample.normal.norm() - 1.0).abs() <= UNIT
}
