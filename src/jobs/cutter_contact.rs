//! The core's compensation of the CC path behind the seam: wire documents in and out, files as sources.

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use super::{Compensator, CompensatorFault, Refusal, RefusalClass};
use crate::contact;
use crate::kinematics::Setup;
use crate::machine::{Machine, Tool};
use crate::motion;
use crate::plot::{DeviationFigure, DeviationPoint, deviation_along_path};
use crate::process::{self, ContactSource, LineFault, LineFaultKind, LineFaults, OutputForm, ProgramSource};
use crate::program::{self, Diagnostics};
use crate::units::{Feedrate, Length};
use crate::wire::{
    CcFindings, CcParameters, CcReport, Contact, Correction, Dialect, Fault, Interpolation, Output,
};

/// Compensates by the core.
#[derive(Debug)]
pub struct CutterContact;

impl Compensator for CutterContact {
    fn compensate(
        &self,
        machine: &Machine,
        parameters: &CcParameters,
        tool: Option<Tool>,
        source: &Path,
        output: &mut dyn Write,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<CcFindings, CompensatorFault> {
        let asked = to_core(parameters, tool)?;
        let source = ProgramFile(source.to_owned());
        let report = process::compensate(machine, &asked, &source, output, stop).map_err(refused)?;
        Ok(CcFindings::from(&report))
    }

    fn figure(&self, parameters: &CcParameters, report: &CcReport) -> Option<String> {
        let series = &report.findings.series;
        let points: Vec<_> = series
            .path_mm
            .iter()
            .zip(&series.line)
            .zip(series.before_um.iter().zip(&series.after_um))
            .map(|((&path_mm, &line), (&before_um, &after_um))| DeviationPoint {
                path_mm,
                line,
                before_um,
                after_um,
            })
            .collect();
        let digest = report.provenance.input_sha256.get(..8).unwrap_or_default();
        let revision = report.provenance.machine_revision;
        let title = format!("Deviation of the cutter contact, program {digest}, machine revision {revision}");
        let tolerance_um = parameters.tolerance_um;
        deviation_along_path(&DeviationFigure { title: &title, points: &points, tolerance_um }).ok()
    }
}

/// A program on the disk, opened as often as it is read.
struct ProgramFile(PathBuf);

impl ProgramSource for ProgramFile {
    fn open(&self) -> io::Result<Box<dyn Read>> {
        Ok(Box::new(BufReader::with_capacity(1 << 18, File::open(&self.0)?)))
    }
}

fn to_core(parameters: &CcParameters, tool: Option<Tool>) -> Result<process::CcParameters, CompensatorFault> {
    let contact = match parameters.contact {
        Contact::Auto => ContactSource::Auto,
        Contact::Program => ContactSource::Program,
        Contact::Normals => ContactSource::Normals,
        Contact::FeedPlane => ContactSource::FeedPlane,
        Contact::Tip => ContactSource::Tip,
        Contact::Surface => return Err(unavailable("/contact", "contact surface is not computed yet")),
    };
    let dialect = match parameters.dialect {
        Dialect::Auto => None,
        Dialect::Iso => Some(program::Dialect::Iso),
        Dialect::Csv => Some(program::Dialect::Csv),
        Dialect::Siemens | Dialect::Heidenhain | Dialect::Apt => {
            return Err(unavailable("/dialect", "this dialect is not read yet"));
        }
    };
    // The tip is its own contact point: no tool is needed, and none matters.
    let stand_in = || Tool::new(Length::from_mm(1.0), Length::from_mm(1.0)).ok();
    let Some(tool) = tool.or_else(stand_in) else {
        return Err(unavailable("/tool_radius_mm", "missing"));
    };
    let [x, y, z] = parameters.work_offset_mm.0;
    let setup = Setup {
        work_offset_mm: [x, y, z].into(),
        tool_length_mm: parameters.tool_length_mm,
        ..Setup::default()
    };
    Ok(process::CcParameters {
        tolerance: Length::from_um(parameters.tolerance_um),
        contact,
        interpolation: parameters.interpolation.map(|who| match who {
            Interpolation::Machine => motion::Interpolation::Machine,
            Interpolation::Tcp => motion::Interpolation::Tcp,
        }),
        correction: match parameters.correction {
            Correction::Even => contact::Correction::Even,
            Correction::Foot => contact::Correction::Foot,
            Correction::Seed => contact::Correction::Seed,
        },
        output: match parameters.output {
            Output::Minimal => OutputForm::Minimal,
            Output::Interpolated => OutputForm::Interpolated,
        },
        setup,
        feed: parameters.feed_mm_per_min.map(Feedrate::from_mm_per_min),
        dialect,
        ..process::CcParameters::new(tool)
    })
}

fn unavailable(pointer: &str, detail: &str) -> CompensatorFault {
    let fault = Fault::new(pointer, detail);
    refusal(RefusalClass::Parameter, detail.to_owned(), None, None, vec![fault])
}

fn refusal(
    class: RefusalClass,
    detail: String,
    line: Option<u64>,
    block: Option<String>,
    errors: Vec<Fault>,
) -> CompensatorFault {
    CompensatorFault::Refused(Box::new(Refusal { class, detail, line, block, errors }))
}

fn refused(fault: process::Fault) -> CompensatorFault {
    use process::Fault as F;
    let detail = fault.to_string();
    let program = |line| refusal(RefusalClass::Program, detail.clone(), line, None, Vec::new());
    match fault {
        F::Unreadable(read) => program(Some(read.line())),
        F::Program(diagnostics) => undiagnosed(&diagnostics, detail),
        F::Lines(lines) => faulty_lines(&lines, detail),
        F::NoMotion => program(None),
        F::NoContactInProgram { .. } => {
            let fault = Fault::new("/contact", &*detail);
            refusal(RefusalClass::Parameter, detail, None, None, vec![fault])
        }
        F::TooCostly { .. } => refusal(RefusalClass::TooCostly, detail, None, None, Vec::new()),
        F::Unwritable { line, .. } => program(Some(line)),
        F::VerificationFailed { line, what } => CompensatorFault::VerificationFailed { line, what },
        F::Cancelled => CompensatorFault::Cancelled,
        F::Io(fault) => CompensatorFault::Io(fault),
    }
}

fn undiagnosed(diagnostics: &Diagnostics, detail: String) -> CompensatorFault {
    let errors: Vec<_> =
        diagnostics.refusals().map(|fault| Fault::new("/program", fault.to_string())).collect();
    let line = diagnostics.refusals().next().map(|fault| fault.line);
    let detail = match errors.as_slice() {
        [only] => only.detail.clone(),
        _ => detail,
    };
    refusal(RefusalClass::Program, detail, line, None, errors)
}

fn faulty_lines(lines: &LineFaults, detail: String) -> CompensatorFault {
    let errors = lines.kept.iter().map(|fault| Fault::new("/program", fault.to_string())).collect();
    let Some(first) = lines.kept.first() else {
        return refusal(RefusalClass::Program, detail, None, None, errors);
    };
    let detail = if lines.total == 1 { first.to_string() } else { format!("{detail}; the first: {first}") };
    let detail = match reachable_um(&lines.kept) {
        Some(reachable_um) => format!("{detail}; the tolerance within reach is {reachable_um:.3} µm"),
        None => detail,
    };
    let class = match first.kind {
        LineFaultKind::OutOfTravel { .. } => RefusalClass::OutOfTravel,
        LineFaultKind::ToleranceOutOfReach { .. } => RefusalClass::ToleranceOutOfReach,
        LineFaultKind::TooManyParts { .. } => RefusalClass::TooCostly,
        _ => RefusalClass::Program,
    };
    refusal(class, detail, Some(first.line), Some(first.block.clone()), errors)
}

/// The smallest tolerance that every kept line can keep [µm].
fn reachable_um(faults: &[LineFault]) -> Option<f64> {
    let reachable = faults.iter().filter_map(|fault| match fault.kind {
        LineFaultKind::ToleranceOutOfReach { reachable_um, .. } => Some(reachable_um),
        _ => None,
    });
    reachable.reduce(f64::max)
}
