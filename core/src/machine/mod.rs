//! The description of a machine tool: two rotary axes as screws, travel, errors, tool. Data only: no code asks
//! for the class of a machine.

mod fault;
mod location_error;
mod machine_coordinates;
mod plane_solution;
mod presets;
mod profile;
mod rotary_axis;
mod tool;

pub use fault::{AxisField, MachineFault, Motion, ProfileField};
pub use location_error::{LocationError, Squareness};
pub use machine_coordinates::{MAX_REFERENCE_POSITIONS, MachineCoordinates};
pub use plane_solution::{PlaneRule, PlaneSolution};
pub use presets::{EXAMPLE_ID, PRESETS, Preset};
pub use profile::{Machine, MachineParts};
pub use rotary_axis::{RotaryAxis, RotaryLetter, Side, Travel};
pub use tool::{Tool, ToolFault};
