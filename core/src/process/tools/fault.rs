//! Why it is not known which tool cuts.

use thiserror::Error;

/// Why it is not known which tool cuts.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ToolUnknown {
    /// The request states one tool, and several are at work.
    #[error(
        "{count} tools cut in this program ({tools}), and the request states one: say by `tool_number` which one it is, or put the tools into the machine's tool table{}",
        if *.is_for_one { "" } else { " and leave the radii out" }
    )]
    Several {
        /// How many.
        count: usize,
        /// What they are called.
        tools: String,
        /// The request states something that holds for one tool only, whatever the table has.
        is_for_one: bool,
    },
    /// The request states no tool, and the table has none of those at work.
    #[error(
        "the machine's tool table has no cutter for {tools}, and the request states none: put it into the table with its radii, or give {stated}"
    )]
    NotListed {
        /// What they are called.
        tools: String,
        /// How the request states one.
        stated: &'static str,
    },
    /// The request states no tool, and the program calls none.
    #[error(
        "missing: the program calls no tool. Give {stated}, or the `tool_number` of a tool in the machine's tool table"
    )]
    Missing {
        /// How the request states one.
        stated: &'static str,
    },
    /// The program has no section of the tool asked for.
    #[error("the program has no cut with tool {number}; it cuts with {tools}")]
    NoSuchTool {
        /// Its number.
        number: u32,
        /// What the tools at work are called.
        tools: String,
    },
    /// Nobody measured the wear of the tools at work.
    #[error(
        "there is no wear entry for {tools}: give the `cutter_id` under which it was measured, or state the worn cutter"
    )]
    NoWear {
        /// What they are called.
        tools: String,
    },
    /// `CUTTER/` states another cutter than the table.
    #[error(transparent)]
    CutterDiffers(Box<CutterDifference>),
}

/// Two statements of one tool's cutter that differ.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "line {line}: CUTTER/ states {tool} with {stated}, the machine's tool table with {listed}: correct one of them, or state the cutter in the request"
)]
pub struct CutterDifference {
    /// Line of its first motion.
    pub line: u64,
    /// What the tool is called.
    pub tool: String,
    /// Its diameter, and where it is stated its corner radius, in the program.
    pub stated: String,
    /// The same in the table.
    pub listed: String,
}
