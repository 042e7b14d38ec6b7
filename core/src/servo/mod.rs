//! The effect of loop gains and feed on the part: cascaded drives, simulated exactly, along circles, paths of the
//! tool and programs; contour error to the commanded path; sweeps; matching gains.
//!
//! Drive constants are coherent SI at the motor shaft; positions are mm, or rad. Letters and facts: `math.md` §3, P2.

mod command;
mod contour_error;
mod discretise;
mod drive_model;
mod fault;
mod feed_profile;
mod matching;
mod path;
mod presets;
mod simulate;
mod stability;
mod state_space;
mod statistics;
mod stepping;
mod sweep;
mod tool_command;
mod tool_run;

pub use command::{CircleCommand, MAX_SAMPLES, PathExtent, Run};
pub use contour_error::{ContourError, FootTracker, LOOK_AHEAD};
pub use discretise::{Step, TooStiff};
pub use drive_model::{AxisLetter, Drive, DriveFault, Feedback, Resonance};
pub use fault::ServoFault;
pub use feed_profile::{FeedProfile, MovingAverage};
pub use matching::{
    FeedLimit, MAX_MATCHING_SAMPLES, MatchedGains, Matching, MatchingOptions, match_gains, matching_samples,
};
pub use path::{Circle, ToolPath};
pub use presets::{DRIVE_PRESETS, DrivePreset};
pub use simulate::{AxisOutcome, Detail, DriveSet, Simulation, simulate_circle, simulate_tool_path};
pub use stability::{
    MAX_SETTLING_S, Stability, UnstableLoop, closed_loop, open_loop, poles, settling_s, stable_poles,
};
pub use state_space::StateSpace;
pub use statistics::{ContourErrorSummary, FollowingErrorSummary, Oval, Trace, TracePoint};
pub use stepping::AxisServo;
pub use sweep::{SampledPath, ServoPath, simulate, sweep_at_feed};
pub use tool_command::{ToolCommand, letters_of};
pub use tool_run::{ToolOutcome, ToolRun};
