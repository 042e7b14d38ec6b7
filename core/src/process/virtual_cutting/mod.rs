//! A whole program against the nominal surface of its part: residual material and gouges.

mod cut;
mod parameters;
mod report;
mod verify_part;

pub use parameters::VerificationParameters;
pub use report::{Convergence, Effort, Extreme, Histogram, MotionCounts, ResidualSummary, Verification};
pub use verify_part::verify_part;
