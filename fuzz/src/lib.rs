//! The core of Trunnion, from the service's own sources, and what has to hold of it for every input.
//!
//! The core names no web framework, store or clock, so that it can be built here by itself: a fuzz target takes
//! seconds to build and not minutes.

#[path = "../../src/calibration/mod.rs"]
pub mod calibration;
#[path = "../../src/contact/mod.rs"]
pub mod contact;
#[path = "../../src/geometry/mod.rs"]
pub mod geometry;
#[path = "../../src/kinematics/mod.rs"]
pub mod kinematics;
#[path = "../../src/machine/mod.rs"]
pub mod machine;
#[path = "../../src/motion/mod.rs"]
pub mod motion;
#[path = "../../src/process/mod.rs"]
pub mod process;
#[path = "../../src/program/mod.rs"]
pub mod program;
#[path = "../../src/servo/mod.rs"]
pub mod servo;
#[path = "../../src/surface/mod.rs"]
pub mod surface;
#[path = "../../src/units.rs"]
pub mod units;
#[path = "../../src/wear/mod.rs"]
pub mod wear;

pub mod checks;
