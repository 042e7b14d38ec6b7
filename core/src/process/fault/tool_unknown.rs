//! Why it is not known which tool cuts.

use thiserror::Error;

use super::unfit_wear::UnfitWear;

/// Why it is not known which tool cuts.
#[derive(Debug, Clone, PartialEq, Error)]
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
    /// The program calls a tool, and its text does not tell which.
    #[error(
        "missing: the program calls a tool, and its text does not tell which one it is, as where T is an expression, an edge other than D1 counts, or a code or a subprogram may have changed it. Give {stated}, or say by `tool_number` which tool of the machine's tool table it is"
    )]
    NotTold {
        /// How the request states one.
        stated: &'static str,
    },
    /// T words call tools, and nothing puts them in.
    #[error(
        "which tool cuts is not known: T alone does not put {tools} in, because {}. Write {} where each of them comes in",
        if *.by_m6 { "the program changes tools by M6" } else { "the program calls subprograms, and the change may be in one of them" },
        if *.by_m6 { "M6" } else { "T and M6" }
    )]
    NotPutIn {
        /// What they are called.
        tools: String,
        /// M6 changes tools elsewhere in the program; else it calls subprograms.
        by_m6: bool,
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
        "under this `cutter_id` there is no wear entry for {tools}: give the one under which it was measured, or state the worn cutter"
    )]
    NoWear {
        /// What they are called.
        tools: String,
    },
    /// The wear entries of a tool do not tell its worn cutter.
    #[error("{tool}: {why}")]
    UnfitWear {
        /// What it is called.
        tool: String,
        /// Why they do not.
        why: Box<UnfitWear>,
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
