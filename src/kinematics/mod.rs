//! Tool poses to axis positions and back, for any two rotary axes.

mod batch;
mod chain;
mod instruction_set;

pub use batch::{JointLanes, PoseLanes};
pub use chain::{Joints, Kinematics, Setup, ToolPose};
pub use instruction_set::InstructionSet;
