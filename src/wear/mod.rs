//! What a worn or reground cutter does to the part, and what can be mended: scallop height between passes, the shift of
//! the tip that keeps the contact, and what remains.

mod effective_radius;
mod pass;
mod scallop;
mod scallop_fault;
mod surface;

pub use effective_radius::{LEAD_RANGE_DEG, LeadFault, cutter_radius, effective_radius};
pub use pass::{CutterPass, PassFault};
pub use scallop::{largest_stepover, scallop_height, smallest_tool_radius};
pub use scallop_fault::{ScallopFault, ScallopQuantity};
pub use surface::Surface;
