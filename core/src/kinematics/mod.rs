//! From tool poses to axis positions and back, for any two rotary axes.

mod batch;
mod chain;
mod choice;
mod cost;
mod curvature;
mod error;
mod greedy;
mod grid;
mod instruction_set;
mod inverse;
mod joining;
mod lanes;
mod near;
mod nearest;
mod path;
mod pointing;
mod relaxed;
mod singular_zone;
mod singularity;
mod steady;
mod turning_room;
mod turns;
mod two_way;
mod walk;

pub use batch::{JointLanes, PoseLanes};
pub use chain::{BareKinematics, Joints, Kinematics, Setup, ToolPose};
pub use curvature::TipCurvature;
pub use error::InverseError;
pub use instruction_set::InstructionSet;
pub use inverse::{Branch, COMPUTED_WORD_SLACK, Candidate, MAX_COORDINATE_MM, REACH_SLACK_RAD};
pub use near::NearWords;
pub use path::{Lanes, MAX_CELLS, Path, PathOptions, PathWarning, REWIND_DEG, Selection, WarningKind};
pub use singular_zone::{SingularZone, Singularity, SingularityKind};
pub use singularity::MIN_CONE_DEG;
pub use turning_room::TurningRoom;
