//! A whole program against the nominal surface of its part: what it leaves and what it gouges.

mod course;
mod parameters;
mod report;
mod run;

pub use parameters::{VerificationFault, VerificationParameters, VerificationQuantity};
pub use report::{Convergence, Effort, Extreme, Histogram, MotionCounts, ResidualSummary, Verification};
pub use run::verify_part;
