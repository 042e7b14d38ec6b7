//! The set-up in which a program runs: unit, work offsets, tools, and the machine set up with them.

mod contact_source;
mod cost_budget;
mod program_setup;
mod set_ups;
mod spindle_lengths;
mod tool_calls;
mod tool_table;
mod tool_vectors;
mod tooling;
mod tools_at_work;
mod travel;

pub use contact_source::ContactSource;
pub use cost_budget::{Budget, Stop};
pub use program_setup::{ProgramSetup, StartPosition, SurveyExtent};
pub use tool_table::{ListedTool, ToolTable};
pub use tooling::Tools;

pub(in crate::process) use set_ups::{SetUps, turn_between, turns};
pub(in crate::process) use tool_calls::ToolCalls;
pub(in crate::process) use tool_vectors::ToolVectors;
pub(in crate::process) use tooling::{Need, ToolUsed, Tooling};
pub(in crate::process) use tools_at_work::ToolsAtWork;
pub(in crate::process) use travel::{TravelCheck, Travels, may_roll_over};
