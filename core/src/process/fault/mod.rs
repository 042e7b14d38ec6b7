//! Why a program is refused, and what the caller should know if it is not.

mod left_out;
mod line_fault;
mod not_posted;
mod refusal;
mod tool_unknown;
mod unfit_wear;
mod unknown_axes;
mod verification_fault;
mod warning;
mod warnings;

pub use left_out::{LeftOut, LeftOutReason};
pub use line_fault::{LineFault, LineFaultKind, LineFaults, Unstated};
pub use not_posted::NotPosted;
pub use refusal::Fault;
pub use tool_unknown::{CutterDifference, ToolUnknown};
pub use unfit_wear::{EnteredWear, UnfitWear};
pub use unknown_axes::UnknownAxes;
pub use verification_fault::{VerificationFault, VerificationQuantity};
pub use warning::{Warning, WarningKind};

pub(in crate::process) use left_out::LeftOuts;
pub(in crate::process) use refusal::go_on;
pub(in crate::process) use warnings::Warnings;
