//! Which tool cuts where: what the request states, what the program calls, what the machine's tool table has.
//!
//! Without a tool number the request's tool holds where one tool is at work. Where several are, each section of the program takes
//! its tool from the table, and sections whose tool is not there are left alone.

mod at_work;
mod calls;
mod fault;
mod table;
mod tooling;
mod unfit_wear;

pub(super) use calls::ToolCalls;
pub use fault::{CutterDifference, ToolUnknown};
pub use table::{ListedTool, ToolTable};
pub use tooling::Tools;
pub(super) use tooling::{Need, ToolUsed, Tooling};
pub use unfit_wear::{EnteredWear, UnfitWear};
