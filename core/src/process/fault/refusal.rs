//! Why a program is not compensated. Nothing has then left the core that could be run.

use super::line_fault::LineFaults;
use std::io;

use thiserror::Error;

use super::left_out::LeftOutReason;
use super::tool_unknown::ToolUnknown;
use super::verification_fault::VerificationFault;
use crate::contact::{Effort, EffortEnd};
use crate::program::{Diagnostics, Dialect, Excerpt, ReadFault, Severity, Step, WriteFault};
use crate::servo::ServoFault;

/// The first fault, and how many there are.
fn of_lines(faults: &LineFaults) -> String {
    let total = faults.total;
    match faults.kept.first() {
        Some(first) if total <= first.count => first.to_string(),
        Some(first) => format!("{total} lines of the program have faults, the first: {first}"),
        None => format!("{total} lines of the program have faults"),
    }
}

/// The same of what refuses the program as a whole.
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
    first.map_or_else(String::new, |(reason, line)| format!(", the first in line {line}: {}", reason.text()))
}

/// Whether the work is to go on.
///
/// # Errors
/// Nobody waits for it any more, or it took more than it may.
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
    /// It cannot be read as a program.
    #[error(transparent)]
    Unreadable(#[from] ReadFault),
    /// Blocks that cannot be read or followed, with effects beyond themselves.
    #[error("{}", of_blocks(.0))]
    Program(Box<Diagnostics>),
    /// Blocks that cannot be compensated.
    #[error("{}", of_lines(.0))]
    Lines(LineFaults),
    /// A program that moves nothing.
    #[error("the program has no motion")]
    NoMotion,
    /// It is not known which tool cuts.
    #[error(transparent)]
    Tool(ToolUnknown),
    /// The ends of motions are to be moved, and not one motion can be followed.
    #[error("no motion of the program can be followed, so none was moved{}", first_of(*first))]
    NothingFollowed {
        /// Why the first of them cannot, and its line.
        first: Option<(LeftOutReason, u64)>,
    },
    /// A program without a motion at feed whose course is known.
    #[error("the program has no motion that can be simulated; {left_out} were left out{}", first_of(*first))]
    NothingToSimulate {
        /// Motions left out, rapids not counted.
        left_out: u64,
        /// Why the first of them, and its line.
        first: Option<(LeftOutReason, u64)>,
    },
    /// A program without a motion whose course is known: nothing is cut.
    #[error("the program has no motion that can be followed; {left_out} were left out{}", first_of(*first))]
    NothingToCut {
        /// Motions left out.
        left_out: u64,
        /// Why the first of them, and its line.
        first: Option<(LeftOutReason, u64)>,
    },
    /// A program in another dialect than cutter location data was to be posted.
    #[error("only cutter location data can be posted; this program is {dialect}")]
    NotCutterLocationData {
        /// Its dialect.
        dialect: Dialect,
    },
    /// What a verification is asked to do makes no sense.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))]
    Verification(Vec<VerificationFault>),
    /// The drives cannot run it.
    #[error(transparent)]
    Servo(#[from] ServoFault),
    /// The program bears the stamp of a step that is asked for.
    #[error(
        "the program bears the stamp of the step `{step}`: it was done to it before{}",
        if step.may_be_repeated() { "; allow_repeated=true does it again" } else { ", and a second time would move every end twice; take the program as it was before" }
    )]
    AlreadyCompensated {
        /// The step.
        step: Step,
    },
    /// The program bears a stamp that does not say which steps were done to it.
    #[error(
        "the program bears the stamp `{text}`, whose steps cannot be read completely: every step may have been done to it before, and a second time would move every end twice; post the source program. A comment that is no stamp must not name Trunnion with a version"
    )]
    StampUnreadable {
        /// The beginning of the stamp.
        text: Excerpt,
    },
    /// A contact source was asked for that the program does not have.
    #[error("contact `{contact}` was asked for, but the program has no {missing}")]
    NoContactInProgram {
        /// The source asked for.
        contact: &'static str,
        /// What is missing.
        missing: &'static str,
    },
    /// Nothing says where the worn cutter touches.
    #[error(
        "nothing states where the cutter touches in {milling} milling: state the contact by U V W words, by normals (columns nx ny nz, or nine values in GOTO), or by the part's surface; contact=feed-plane assumes one from the feed"
    )]
    ContactUnknown {
        /// `end` or `side`.
        milling: &'static str,
    },
    /// A contact source that cannot say where a worn cutter touches.
    #[error("contact `{contact}` cannot say where a worn cutter touches in {milling} milling")]
    UnfitContact {
        /// The source.
        contact: &'static str,
        /// `end` or `side`.
        milling: &'static str,
    },
    /// A compensation without a step.
    #[error("no step was asked for: name one of `wear`, `location_errors` and `cc`")]
    NothingAsked,
    /// More work than one request may cause.
    #[error(
        "{what} exceed the limit of {limit}: divide the program, ask for less (fewer facets, fewer samples, a larger tolerance), or raise `max_cost_s`"
    )]
    TooCostly {
        /// Of what there is too much.
        what: &'static str,
        /// How much is allowed.
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
    /// What was written does not read back as what was meant. A defect of this software, never of the program.
    #[error("verification failed at line {line} of the upload: {what}")]
    VerificationFailed {
        /// 1-based line of the upload.
        line: u64,
        /// What differs.
        what: &'static str,
    },
    /// The caller no longer wants the answer.
    #[error("cancelled")]
    Cancelled,
    /// Source or output could not be read or written.
    #[error("program text: {0}")]
    Io(#[from] io::Error),
}
