//! What has to hold for every input.

// Named as the service names them, for the documents of the wire are its own files.
pub use trunnion_core::{
    calibration, contact, geometry, kinematics, machine, motion, plot, process, program, servo, side_by_side, surface,
    units, wear,
};

// Without the web framework and the database beside it: these would be instrumented too.
#[path = "../../src/description.rs"]
#[allow(unused_imports)]
mod description;
#[path = "../../src/wire/mod.rs"]
#[allow(dead_code, unused_imports)]
pub mod wire;

pub mod addresses;
pub mod bodies;
pub mod checks;
#[cfg(feature = "service")]
pub mod forms;
pub mod surfaces;
