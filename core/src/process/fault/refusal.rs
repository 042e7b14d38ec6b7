//! Why a program is not compensated. After a refusal the core has given out nothing that could be run.

use super::line_fault::LineFaults;
use std::io;

use thiserror::Error;

use super::left_out::LeftOutReason;
use super::tool_unknown::ToolUnknown;
use super::verification_fault::VerificationFault;
use crate::contact::{Effort, EffortEnd};
use crate::program::{
    Diagnostics, Dialect, Excerpt, ReadFault, Severity, StepName, WriteFault, without_folders,
};
use crate::servo::ServoFault;

/// The first fault, and the number of faults.
fn of_lines(faults: &LineFaults) -> String {
    let total = faults.total;
    match faults.kept.first() {
        Some(first) if total <= first.count => first.to_string(),
        Some(first) => format!("{total} lines of the program have faults, the first: {first}"),
        None => format!("{total} lines of the program have faults"),
    }
}

/// The same for diagnostics that refuse the program as a whole.
fn of_blocks(diagnostics: &Diagnostics) -> String {
    let total = diagnostics.count(Severity::Refusal);
    match diagnostics.refusals().next() {
        Some(first) if total <= 1 => first.to_string(),
        Some(first) => {
            format!("{total} blocks of the program cannot be read or followed, the first: {first}")
        }
        None => format!("{total} blocks of the program cannot be read or followed"),
    }
}

fn first_of(first: Option<(LeftOutReason, u64)>) -> String {
    let Some((reason, line)) = first else { return String::new() };
    let cure = reason.cure().map_or_else(String::new, |cure| format!(". {cure}"));
    format!(", the first in line {line}: {}{cure}", reason.text())
}

/// Whether the work should continue.
///
/// # Errors
/// The caller no longer waits, or the work exceeds its budget.
pub(in crate::process) fn go_on(effort: &Effort<'_>) -> Result<(), Fault> {
    match effort.end() {
        None => Ok(()),
        Some(EffortEnd::Unwanted) => Err(Fault::Cancelled),
        Some(EffortEnd::Spent { most }) => {
            Err(Fault::TooCostly { what: "evaluations of the deviation", limit: most })
        }
        Some(EffortEnd::Searched { most }) => {
            Err(Fault::TooCostly { what: "steps of the search for contacts on the surface", limit: most })
        }
    }
}

/// Why a program is refused as a whole.
#[derive(Debug, Error)]
pub enum Fault {
    /// The text cannot be read as a program.
    #[error(transparent)]
    Unreadable(#[from] ReadFault),
    /// The text of a file that the program may call cannot be read.
    #[error("in the called file `{}`: {fault}", Excerpt::new(without_folders(file).as_bytes()))]
    UnreadableFile {
        /// The name with which it was sent.
        file: String,
        /// The reason. Its line counts in this file.
        fault: ReadFault,
    },
    /// Blocks that cannot be read or followed, and that affect other blocks.
    #[error("{}", of_blocks(.0))]
    Program(Box<Diagnostics>),
    /// Blocks that cannot be compensated.
    #[error("{}", of_lines(.0))]
    Lines(LineFaults),
    /// The program moves nothing.
    #[error("the program has no motion: send the program itself, with its motion blocks")]
    NoMotion,
    /// It is not known which tool cuts.
    #[error(transparent)]
    Tool(ToolUnknown),
    /// The ends of motions have to move, but no motion can be followed.
    #[error("no motion of the program can be followed, so none was moved{}", first_of(*first))]
    NothingFollowed {
        /// Why the first motion cannot be followed, and its line.
        first: Option<(LeftOutReason, u64)>,
    },
    /// A program without a motion at feed whose course is known.
    #[error("the program has no motion that can be simulated; {left_out} motions were left out{}", first_of(*first))]
    NothingToSimulate {
        /// Number of motions left out, without rapids.
        left_out: u64,
        /// Why the first one was left out, and its line.
        first: Option<(LeftOutReason, u64)>,
    },
    /// A program without a motion whose course is known: nothing is cut.
    #[error("the program has no motion that can be followed; {left_out} motions were left out{}", first_of(*first))]
    NothingToCut {
        /// Number of motions left out.
        left_out: u64,
        /// Why the first one was left out, and its line.
        first: Option<(LeftOutReason, u64)>,
    },
    /// Posting was asked for a program that is not cutter location data.
    #[error("only cutter location data can be posted; this program is {dialect}")]
    NotCutterLocationData {
        /// Its dialect.
        dialect: Dialect,
    },
    /// The verification has invalid settings.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Verification(Vec<VerificationFault>),
    /// The drives cannot run the program.
    #[error(transparent)]
    Servo(#[from] ServoFault),
    /// The step asked for was done to the program before, as its stamp or an earlier job says.
    #[error(
        "the step `{step}` was done to this program before{}",
        if step.may_be_repeated() { "; to do it again, set allow_repeated=true" } else { ". A second time would move every end twice. Send the program from before that step" }
    )]
    AlreadyCompensated {
        /// The step.
        step: StepName,
    },
    /// The program has a stamp that does not say which steps were done.
    #[error(
        "the program has the stamp `{text}`, whose steps cannot all be read. Any step may have been done before, and a second time would move every end twice. Send the source program. If the comment is not a stamp, remove Trunnion's name and version from it"
    )]
    StampUnreadable {
        /// The beginning of the stamp.
        text: Excerpt,
    },
    /// The contact source asked for is missing in the program.
    #[error("contact `{contact}` was asked for, but the program has no {missing}")]
    NoContactInProgram {
        /// The source asked for.
        contact: &'static str,
        /// What the program lacks.
        missing: &'static str,
    },
    /// The position of the contact on the worn cutter is not stated.
    #[error(
        "nothing states where the cutter touches in {milling} milling: state the contact by U V W words, by normals (columns nx ny nz, or nine values in GOTO), or by the part's surface; contact=feed-plane assumes a contact from the feed"
    )]
    ContactUnknown {
        /// `end` or `side`.
        milling: &'static str,
    },
    /// A contact source that does not give the contact of a worn cutter.
    #[error(
        "contact `{contact}` does not show where a worn cutter touches in {milling} milling: choose another contact source"
    )]
    UnfitContact {
        /// The source.
        contact: &'static str,
        /// `end` or `side`.
        milling: &'static str,
    },
    /// A compensation without any step.
    #[error("no step is named: give at least one of `wear`, `location_errors` and `cc`")]
    NothingAsked,
    /// More work than one request may cause.
    #[error(
        "{what} exceed the limit of {limit}: divide the program, ask for less (fewer facets, fewer samples, a larger tolerance), or raise `max_cost_s`"
    )]
    TooCostly {
        /// The kind of work that exceeds its limit.
        what: &'static str,
        /// The limit.
        limit: u64,
    },
    /// A block could not be written.
    #[error("line {line} cannot be written: {fault}")]
    Unwritable {
        /// 1-based line of the upload.
        line: u64,
        /// Why.
        fault: WriteFault,
    },
    /// The written text, read back, differs from the plan. This is a defect of this software, never of the
    /// program.
    #[error("verification failed at line {line} of the upload: {what}")]
    VerificationFailed {
        /// 1-based line of the upload.
        line: u64,
        /// What differs.
        what: &'static str,
    },
    /// The program was followed with what its head shows, and its rest shows more, or was not read to its end. It has
    /// to be surveyed whole.
    #[error("the beginning of the program does not show all that its rest shows")]
    HeadMisled,
    /// The caller no longer waits for the answer.
    #[error("cancelled")]
    Cancelled,
    /// Source or output could not be read or written.
    #[error("program text: {0}")]
    Io(#[from] io::Error),
}
