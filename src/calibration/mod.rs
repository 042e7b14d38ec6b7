//! Where a machine's rotary axes really are: location errors with uncertainties from measured runs.

mod absolute;
mod ballbar;
mod blind;
mod decomposition;
mod eccentricity;
mod fault;
mod identify;
mod observations;
mod parameters;
mod prediction;
mod robust;
mod warnings;

pub use absolute::AbsoluteError;
pub use ballbar::{BallBarRun, BallBarTest, BarDirection, Observed, Reading, SetupError, SpindleStep};
pub use blind::{Blind, FurtherRun};
pub use decomposition::RANK_THRESHOLD;
pub use fault::RunFault;
pub use identify::{Eccentricities, Identified, Outlier, Unknown, expected_readings, identify};
pub use parameters::{ErrorParameter, placing_parameters};
pub use warnings::RunWarning;
