//! Tool poses to axis positions and back, for any two rotary axes.

mod chain;

pub use chain::{Joints, Kinematics, Setup, ToolPose};
