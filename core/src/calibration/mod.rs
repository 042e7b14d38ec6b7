//! The real positions of a machine's rotary axes: location errors with uncertainties from measured runs, and their
//! values as text for the control.
//!
//! Cascaded values are entered in the profile (shared notation §1 "Location errors"); ISO 230-7 values are
//! absolute.

mod absolute;
mod angles;
mod ballbar;
mod blind;
mod decomposition;
mod eccentricity;
pub mod export;
mod fault;
mod identify;
mod lines;
mod observations;
mod parameters;
mod prediction;
mod robust;
pub mod rotary_sphere;
mod turned_bars;
mod uncertainty;
mod warnings;

pub use absolute::{AbsoluteError, absolute_errors, iso_230_symbol};
pub use ballbar::{BallBarRun, BallBarTest, BarDirection, Observed, Reading, SetupError, SpindleStep};
pub use blind::{Blind, FurtherRun};
pub use fault::RunFault;
pub use identify::{Eccentricities, Identified, Outlier, Unknown, expected_readings, identify};
pub use lines::{CommonPerpendicular, rotation_vector_rad};
pub use parameters::{COMPONENT_NAMES, ErrorParameter, placing_parameters, told_per_unit};
pub use uncertainty::{
    InputUncertainties, UncertaintyBudget, UncertaintyPart, UncertaintySource, uncertainty_budget,
};
pub use warnings::RunWarning;
