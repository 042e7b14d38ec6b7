//! Why it is not known which tool cuts.

use thiserror::Error;

use super::unfit_wear::UnfitWear;

/// Why it is not known which tool cuts.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ToolUnknown {
    /// The request states one tool, but several tools cut.
    #[error(
        "{count} tools cut in this program ({tools}), but the request states only one: name it by `tool_number`, or put all tools into the machine's tool table{}",
        if *.is_for_one { "" } else { " and leave the radii out of the request" }
    )]
    Several {
        /// Number of tools.
        count: usize,
        /// Their names.
        tools: String,
        /// The request states something that holds for one tool only, even if the table has the
        /// others.
        is_for_one: bool,
    },
    /// The request states no tool, and the table has none of the tools that cut.
    #[error(
        "the machine's tool table has no cutter for {tools}, and the request states none: put it into the table with its radii, or give {stated}"
    )]
    NotListed {
        /// Their names.
        tools: String,
        /// The request members that state a tool.
        stated: &'static str,
    },
    /// The request states no tool, and the program calls no tool.
    #[error(
        "missing: the program calls no tool. Give {stated}, or the `tool_number` of a tool in the machine's tool table"
    )]
    Missing {
        /// The request members that state a tool.
        stated: &'static str,
    },
    /// The program calls a tool, but its text does not tell which.
    #[error(
        "missing: the program calls a tool, but its text does not show which tool. T may be an expression, a cutting edge other than D1 may be active, or a code or a subprogram may have changed the tool. Give {stated}, or name the tool in the machine's tool table by `tool_number`"
    )]
    NotTold {
        /// The request members that state a tool.
        stated: &'static str,
    },
    /// T words call tools, but no block puts them into the spindle.
    #[error(
        "the tool that cuts is not known: T alone does not put {tools} into the spindle, because {}. Write {} at each tool change",
        if *.by_m6 { "the program changes tools by M6" } else { "the program calls subprograms, and one of them may contain the tool change" },
        if *.by_m6 { "M6" } else { "T and M6" }
    )]
    NotPutIn {
        /// Their names.
        tools: String,
        /// True if M6 changes tools elsewhere in the program. False if the program calls
        /// subprograms.
        by_m6: bool,
    },
    /// The program has no section with the tool asked for.
    #[error("the program has no cut with tool {number}; it cuts with {tools}")]
    NoSuchTool {
        /// Its number.
        number: u32,
        /// The names of the tools that cut.
        tools: String,
    },
    /// The wear of the tools that cut was never measured.
    #[error(
        "this `cutter_id` has no wear entry for {tools}: give the `cutter_id` under which the wear was measured, or state the worn cutter"
    )]
    NoWear {
        /// Their names.
        tools: String,
    },
    /// The wear entries of a tool do not give its worn cutter.
    #[error("{tool}: {why}")]
    UnfitWear {
        /// Its name.
        tool: String,
        /// The reason.
        why: Box<UnfitWear>,
    },
    /// `CUTTER/` states another cutter than the table.
    #[error(transparent)]
    CutterDiffers(Box<CutterDifference>),
}

/// Two different statements of one tool's cutter.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "line {line}: CUTTER/ states {tool} with {stated}, the machine's tool table with {listed}: correct one of them, or state the cutter in the request"
)]
pub struct CutterDifference {
    /// Line of the first motion with this cutter.
    pub line: u64,
    /// Name of the tool.
    pub tool: String,
    /// Diameter in the program, and corner radius if it is stated.
    pub stated: String,
    /// The same values in the table.
    pub listed: String,
}
