//! Refusals of programs as wire documents.

use thiserror::Error;

use crate::process::{self, LineFault, LineFaultKind, LineFaults, ToolUnknown};
use crate::program::{Diagnostic, DiagnosticCode, Diagnostics};
use crate::wire::{Fault, verification_fault};

/// Class of a refusal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RefusalClass {
    /// Lines that cannot be read, followed or compensated.
    Program,
    /// The tolerance cannot be met with the program's decimals.
    ToleranceOutOfReach,
    /// An axis is commanded outside its travel.
    OutOfTravel,
    /// A parameter does not fit this program.
    Parameter,
    /// More work than one request may cause.
    TooCostly,
    /// The unit of the program is not known.
    UnitUnknown,
    /// A step that was already applied to the program.
    AlreadyCompensated,
}

/// Why a program is refused.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// What for.
    pub class: RefusalClass,
    /// In a sentence.
    pub detail: String,
    /// First line of the upload that it concerns, 1-based.
    pub line: Option<u64>,
    /// Text of that line.
    pub block: Option<String>,
    /// Every fault kept.
    pub errors: Vec<Fault>,
}

/// Why a compensator returns no program.
#[derive(Debug, Error)]
pub enum CompensatorFault {
    /// The program or its parameters are at fault.
    #[error("{}", .0.detail)]
    Refused(Box<Refusal>),
    /// The caller does not need the answer any more.
    #[error("cancelled")]
    Cancelled,
    /// The rest of the program shows what its head did not: it has to be surveyed whole.
    #[error("the beginning of the program does not show all that its rest shows")]
    HeadMisled,
    /// A file could not be read or written.
    #[error("program text: {0}")]
    Io(#[from] std::io::Error),
    /// The written program is not the intended one: a fault of the service.
    #[error("verification failed at line {line}: {what}")]
    VerificationFailed {
        /// Line of the upload.
        line: u64,
        /// What differs.
        what: &'static str,
    },
}

/// A fault of the core for the client.
pub(super) fn in_words_of_the_wire(fault: process::Fault) -> CompensatorFault {
    match refused(&fault) {
        Some(refusal) => CompensatorFault::Refused(Box::new(refusal)),
        None => other(fault),
    }
}

/// Faults of the program or the parameters; `None` for a fault of the service.
fn refused(fault: &process::Fault) -> Option<Refusal> {
    let detail = fault.to_string();
    let plain = |class, line, errors| Refusal { class, detail: detail.clone(), line, block: None, errors };
    let program = |line| of_program(line, detail.clone());
    Some(match fault {
        process::Fault::Unreadable(read) => program(Some(read.line())),
        process::Fault::Program(diagnostics) => by_diagnostics(diagnostics, detail),
        process::Fault::Lines(faults) => by_lines(faults, detail),
        process::Fault::NothingToSimulate { first, .. }
        | process::Fault::NothingToCut { first, .. }
        | process::Fault::NothingFollowed { first } => program(first.map(|(_, line)| line)),
        // faults of the drives only come from a simulation, which has already checked them
        process::Fault::NoMotion
        | process::Fault::UnreadableFile { .. }
        | process::Fault::Servo(_)
        | process::Fault::NotCutterLocationData { .. } => program(None),
        process::Fault::NoContactInProgram { .. }
        | process::Fault::UnfitContact { .. }
        | process::Fault::ContactUnknown { .. } => {
            plain(RefusalClass::Parameter, None, vec![Fault::new("/contact", detail.clone())])
        }
        process::Fault::AlreadyCompensated { .. } | process::Fault::StampUnreadable { .. } => {
            plain(RefusalClass::AlreadyCompensated, None, Vec::new())
        }
        process::Fault::Tool(unknown) => {
            let line = match unknown {
                ToolUnknown::CutterDiffers(differing) => Some(differing.line),
                _ => None,
            };
            let errors = vec![Fault::new(pointer_of(unknown), detail.clone())];
            plain(RefusalClass::Parameter, line, errors)
        }
        process::Fault::NothingAsked => plain(RefusalClass::Parameter, None, Vec::new()),
        process::Fault::Verification(faults) => {
            plain(RefusalClass::Parameter, None, faults.iter().map(verification_fault).collect())
        }
        process::Fault::TooCostly { .. } => plain(RefusalClass::TooCostly, None, Vec::new()),
        process::Fault::Unwritable { line, .. } => program(Some(*line)),
        process::Fault::VerificationFailed { .. }
        | process::Fault::HeadMisled
        | process::Fault::Cancelled
        | process::Fault::Io(_) => return None,
    })
}

fn other(fault: process::Fault) -> CompensatorFault {
    match fault {
        process::Fault::VerificationFailed { line, what } => {
            CompensatorFault::VerificationFailed { line, what }
        }
        process::Fault::Io(fault) => CompensatorFault::Io(fault),
        process::Fault::HeadMisled => CompensatorFault::HeadMisled,
        _ => CompensatorFault::Cancelled,
    }
}

fn by_diagnostics(diagnostics: &Diagnostics, detail: String) -> Refusal {
    let errors: Vec<Fault> =
        diagnostics.refusals().map(|diagnostic| at_line(diagnostic.line, diagnostic.to_string())).collect();
    let first = diagnostics.refusals().next();
    let line = first.map(|first| first.line);
    let is_unit = |diagnostic: &Diagnostic| {
        matches!(diagnostic.code, DiagnosticCode::UnitUnknown { .. } | DiagnosticCode::TwoUnits { .. })
    };
    if let Some(unknown) = first.filter(|first| is_unit(first)) {
        let detail = unknown.to_string();
        return Refusal { class: RefusalClass::UnitUnknown, detail, line, block: None, errors };
    }
    Refusal { class: RefusalClass::Program, detail, line, block: None, errors }
}

/// The member of the request that would fix it.
fn pointer_of(unknown: &ToolUnknown) -> &'static str {
    match unknown {
        ToolUnknown::Several { .. } | ToolUnknown::NoSuchTool { .. } => "/tool_number",
        ToolUnknown::NotListed { stated, .. }
        | ToolUnknown::Missing { stated }
        | ToolUnknown::NotTold { stated } => match *stated {
            "`nominal_tool`" => "/nominal_tool",
            "`tool`" => "/tool",
            "`tool_length_mm`" => "/tool_length_mm",
            _ => "/tool_radius_mm",
        },
        ToolUnknown::NoWear { .. } => "/wear/cutter_id",
        ToolUnknown::UnfitWear { .. } => "/wear",
        ToolUnknown::CutterDiffers(_) | ToolUnknown::NotPutIn { .. } => "/program",
    }
}

fn by_lines(faults: &LineFaults, detail: String) -> Refusal {
    let first = faults.kept.first();
    let class = match first.map(|fault| &fault.kind) {
        Some(LineFaultKind::OutOfTravel { .. }) => RefusalClass::OutOfTravel,
        Some(LineFaultKind::ToleranceOutOfReach { .. }) => RefusalClass::ToleranceOutOfReach,
        Some(LineFaultKind::Unstated(_)) => RefusalClass::Parameter,
        _ => RefusalClass::Program,
    };
    let at = |fault: &LineFault| match fault.kind {
        LineFaultKind::Unstated(unstated) => Fault::new(format!("/{}", unstated.member()), fault.to_string()),
        _ => at_line(fault.line, fault.to_string()),
    };
    let detail = match first {
        Some(fault) if matches!(fault.kind, LineFaultKind::Unstated(_)) => fault.to_string(),
        _ => detail,
    };
    let errors = one_for_each_member(&faults.kept);
    let reachable_um = faults.kept.iter().filter_map(reachable_um).fold(0.0, f64::max);
    let detail = if reachable_um > 0.0 {
        format!("{detail}; the program's decimals allow {reachable_um:.3} µm")
    } else {
        detail
    };
    Refusal {
        class,
        detail,
        line: first.map(|fault| fault.line),
        block: first.map(|fault| fault.block.clone()).filter(|block| !block.is_empty()),
        errors: errors.into_iter().map(|fault| at(&fault)).collect(),
    }
}

/// The faults; for each member that must be stated, one fault represents all lines that need it.
fn one_for_each_member(faults: &[LineFault]) -> Vec<LineFault> {
    let member = |fault: &LineFault| match fault.kind {
        LineFaultKind::Unstated(unstated) => Some(unstated.member()),
        _ => None,
    };
    let mut each: Vec<LineFault> = Vec::new();
    for fault in faults {
        let known = each.iter_mut().find(|known| member(fault).is_some() && member(known) == member(fault));
        match known {
            Some(known) => known.count += fault.count,
            None => each.push(fault.clone()),
        }
    }
    each
}

fn reachable_um(fault: &LineFault) -> Option<f64> {
    match fault.kind {
        LineFaultKind::ToleranceOutOfReach { reachable_um, .. } => Some(reachable_um),
        _ => None,
    }
}

/// The refusal of a parameter that does not fit the program.
pub(super) fn of_parameter(fault: Fault) -> Refusal {
    let detail = fault.detail.clone();
    Refusal { class: RefusalClass::Parameter, detail, line: None, block: None, errors: vec![fault] }
}

/// The refusal of a program for one reason, at a line or as a whole.
pub(super) fn of_program(line: Option<u64>, detail: String) -> Refusal {
    let fault = match line {
        Some(line) => at_line(line, detail.clone()),
        None => Fault::new("/program", detail.clone()),
    };
    Refusal { class: RefusalClass::Program, detail, line, block: None, errors: vec![fault] }
}

/// A fault of the program, located at a line of the upload.
fn at_line(line: u64, detail: String) -> Fault {
    Fault::new(format!("/program/{line}"), detail)
}
