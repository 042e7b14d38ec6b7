//! The compensation of a program in one pass, as work on a program.

use super::cc_compensation::{missing_tool, treats};
use super::cc_compensator::{core_parameters, findings as cc_findings};
use super::flattening::Flattened;
use super::part_surface::part_surface;
use super::refusals::in_words_of_the_wire;
use super::stamping::{Leaving, Stamping};
use super::step_files::StepFiles;
use super::wear_program::{findings as wear_findings, missing_from_table};
use super::workplace::{Finished, Workplace, written};
use super::{CompensatorFault, Cost, MachineUsed, Means, Prepared, ProgramParameters, Sizes};
use crate::meter;
use crate::plot::{DeviationFigure, DeviationPoint, deviation_along_path, plain};
use crate::process::{self, CcStep, ProgramReading, ProgramSetup, ServoStep, WarningKind, WearStep};
use crate::program::{StepName, Steps};
use crate::wire::{
    self, ChangeTable, ChangesDoc, CompensationFindings, CompensationParameters, CompensationReport, Contact,
    Fault, FaultList, JobOperation, SingularityAction, Statements, Warning, WearFindings, fault_of_table,
    looks_at,
};

/// Most samples of the drives for an error budget: ten seconds of one core.
const MAX_LAG_SAMPLES: u64 = 2_500_000;

impl ProgramParameters for CompensationParameters {
    const OPERATION: JobOperation = JobOperation::Compensation;
    const LOOKS_AT_PART: bool = true;

    fn steps(&self) -> Steps {
        let mut steps = Steps::NONE;
        if self.wear.is_some() {
            steps = steps.with(StepName::Wear);
        }
        if self.location_errors {
            steps = steps.with(StepName::LocationErrors);
        }
        if self.cc.is_some() {
            steps = steps.with(StepName::Cc);
        }
        steps.and(treats(self.singularity)).not_done_before(self.allow_repeated)
    }

    fn cutter_id(&self) -> Option<&str> {
        self.wear.as_ref().filter(|step| step.from.is_some()).and_then(|step| step.cutter_id.as_deref())
    }

    fn prepare(self, on: MachineUsed, sizes: Sizes, means: &Means) -> Result<Prepared, Vec<Fault>> {
        let mut missing = FaultList::default();
        if let Some(step) = self.wear_alone() {
            missing_from_table(&step, "/wear", &on, &mut missing);
        }
        if let Some(step) = self.cc_alone() {
            missing_tool(&step, "/cc", &on, &mut missing);
        }
        missing.after(self.check(sizes.has_part()))?;
        let mut core = in_core_terms(&self, sizes.has_part(), &on)?;
        let parameters = serde_json::to_value(&self).unwrap_or_default();
        let mut faults = FaultList::default();
        let drives = on.drives.as_ref().map(|drives| drives.to_core("/drives", &mut faults));
        faults.into_result()?;
        let max_cost_s = means.max_cost_s;
        core.budget = Cost::budget_within(max_cost_s);
        if let Some(step) = &mut core.cc {
            step.budget = core.budget;
        }
        core.servo = drives.filter(|_| self.servo_lag).map(|drives| ServoStep {
            max_samples: MAX_LAG_SAMPLES.min(Cost::servo_samples_within(max_cost_s)),
            ..ServoStep::new(drives)
        });
        let moves_ends = self.wear.is_some() || self.location_errors;
        let treats_regions = self.singularity != SingularityAction::Report;
        let in_turn = [moves_ends, treats_regions, self.cc.is_some()].map(u32::from).iter().sum();
        // Ends are moved, then the path between them is compensated.
        let length = sizes.program_length;
        let steps = Cost::of_program(length, self.tolerance_um()) + Cost::of_moving_ends(length);
        Ok(Prepared::new(steps + sizes.cost_of_part(), move |place| {
            let Workplace { program, spool, stop, .. } = place;
            core.program.dialect = core.program.dialect.or(program.dialect_of_files());
            let flat = Flattened::of(self.flatten, &on.machine, &core.program, program, spool, stop)?;
            core.program.dialect = flat.as_ref().map(Flattened::dialect).or(core.program.dialect);
            let place = place.with(flat.as_ref());
            let Workplace { program, surface, spool, threads, stop, survey } = place;
            core.program.steps_done = program.steps_done;
            core.program.survey = survey;
            core.part = part_surface(surface, &self.surface_reading(), stop)?;
            // Errors of a table do not depend on the tool, so the sections of all tools are posted again.
            let is_posted = self.location_errors && !on.has_head_axis();
            let resolve = |reading: &ProgramReading| {
                let statements = Statements { tool_number: self.tool(), ..self.statements() };
                let resolved = on.resolved(&statements, reading)?;
                let resolved = resolved.with_max_feed(self.max_feed_mm_per_min, &on.statements);
                Ok(if is_posted { resolved.whatever_the_tool() } else { resolved })
            };
            let stamping =
                Stamping { on: &on, operation: Self::OPERATION, parameters: &parameters, form: self.stamp };
            let mut output = stamping.output(&place, self.steps(), &core.program, &resolve)?;
            let mut changes = ChangeTable::new(place.output()?)
                .map_err(|fault| CompensatorFault::Io(fault_of_table(fault)))?;
            let resting = StepFiles::new(spool.blobs().clone(), program);
            let done = process::compensate_program(
                &on.machine,
                &core,
                program,
                &resting,
                &mut output,
                &mut changes,
                threads,
                stop,
            )
            .map_err(|fault| at_its_step(fault, &self))?;
            let changes = written(changes.into_inner().map_err(CompensatorFault::Io)?)?;
            let mut findings = findings(&self, changes.sha256(), &done);
            findings.warnings.extend(flat.iter().flat_map(Flattened::warnings));
            meter::PROGRAM_BLOCKS.add(findings.blocks_in);
            let (dialect, steps) = (done.dialect, done.steps);
            let leaving = Leaving { output, resolved: resolve(&done.reading)?, dialect, steps };
            let motions_checked = Some(motions_checked(&findings));
            let report =
                |provenance, resolved| CompensationReport { provenance, resolved: Some(resolved), findings };
            let finished = stamping.finish(leaving, &place, report)?;
            Ok(Finished { changes: Some(changes), motions_checked, ..finished })
        })
        .with_steps_in_turn(in_turn))
    }
}

/// A fault of the core for the client: a value that a step states is located under the step's name.
fn at_its_step(fault: process::Fault, parameters: &CompensationParameters) -> CompensatorFault {
    // The program is not searched for contacts unless a step asks for them by name.
    let lacks_contact = matches!(fault, process::Fault::NoContactInProgram { .. });
    let is_of_wear = |step: &wire::WearStep| !lacks_contact || step.contact != Contact::Auto;
    let of_contact = if parameters.wear.as_ref().is_some_and(is_of_wear) { "/wear" } else { "/cc" };
    let mut fault = in_words_of_the_wire(fault);
    if let CompensatorFault::Refused(refusal) = &mut fault {
        for error in &mut refusal.errors {
            let step = match error.pointer.as_str() {
                "/contact" => of_contact,
                "/tool_radius_mm" => "/cc",
                "/nominal_tool" => "/wear",
                _ => continue,
            };
            error.pointer.insert_str(0, step);
        }
    }
    fault
}

/// The number of motions checked by the step that checks most of them.
fn motions_checked(findings: &CompensationFindings) -> u64 {
    let cc = findings.cc.as_ref().map_or(0, |cc| cc.motions_checked);
    let wear = findings.wear.as_ref().map_or(0, WearFindings::motions_checked);
    let posted = findings.location_errors.as_ref().map_or(0, |errors| errors.motions_posted);
    cc.max(wear).max(posted)
}

/// The parameters in the core's terms, without part and drives.
fn in_core_terms(
    parameters: &CompensationParameters,
    has_part: bool,
    on: &MachineUsed,
) -> Result<process::CompensationParameters, Vec<Fault>> {
    let statements = Statements { tool_number: parameters.tool(), ..parameters.statements() };
    let program =
        ProgramSetup { allow_repeated: parameters.allow_repeated, ..on.program(&statements, true)? };
    let wear = match parameters.wear_alone() {
        None => None,
        Some(step) => {
            let core = step.to_core(looks_at(step.contact, has_part))?;
            Some(WearStep {
                milling: core.milling,
                shorter_by: core.shorter_by,
                length_in_control: core.length_in_control,
                contact: core.contact,
                pass_break: core.pass_break,
                ..WearStep::new(core.nominal, core.worn)
            })
        }
    };
    let cc = match parameters.cc_alone() {
        None => None,
        Some(step) => {
            let tool = step.check(looks_at(step.contact, has_part))?;
            let process::CcParameters { tolerance, contact, pass_break, correction, output, budget, .. } =
                core_parameters(&step, tool, program.clone());
            Some(CcStep { tool, tolerance, contact, pass_break, correction, output, budget })
        }
    };
    Ok(process::CompensationParameters {
        wear,
        location_errors: parameters.location_errors,
        singularity: Some(parameters.singular_regions.to_core(parameters.singularity)),
        cc,
        max_feed: on.statements.max_feed(parameters.max_feed_mm_per_min),
        block_time_s: on.statements.block_time_s(),
        ..process::CompensationParameters::new(program)
    })
}

/// The core's report as a wire document.
fn findings(
    parameters: &CompensationParameters,
    changes_sha256: String,
    report: &process::CompensationReport,
) -> CompensationFindings {
    let wear = report.wear.as_ref().zip(parameters.wear_alone());
    CompensationFindings {
        dialect: report.dialect.into(),
        interpolation: report.interpolation.into(),
        blocks_in: report.blocks_in,
        blocks_out: report.blocks_out,
        blocks_inserted: report.blocks_out.saturating_sub(report.blocks_in),
        singularity: report.singularity.as_ref().map(Into::into),
        location_errors: report.location_errors.as_ref().map(Into::into),
        wear: wear.map(|(wear, step)| wear_findings(&step, wear)),
        cc: report.cc.as_ref().map(cc_findings),
        changes: ChangesDoc::of(changes_sha256, &report.changes),
        error_budget: (&report.budget).into(),
        warnings: warnings(parameters, report),
    }
}

/// The core's warnings, and a warning if a stated cutter is not used because the table gives both cutters.
fn warnings(parameters: &CompensationParameters, report: &process::CompensationReport) -> Vec<Warning> {
    let mut warnings: Vec<Warning> = report.warnings.iter().map(Into::into).collect();
    let kind = WarningKind::StatedToolUnused.name();
    let is_stated = parameters.cc.as_ref().is_some_and(|step| step.tool_radius_mm.is_some());
    let from_entries = parameters.wear.as_ref().is_some_and(|step| step.from.is_some());
    if is_stated && from_entries && warnings.iter().all(|warning| warning.kind != kind) {
        let detail = "the wear is taken from the entries, so both cutters are those of the machine's tool table, and cc.tool_radius_mm is not used; leave it out, or state nominal_tool and actual_tool";
        warnings.push(Warning::plain(kind, detail));
    }
    warnings
}

/// The figure of a report as SVG text: the sum of each motion's errors, as programmed and as written, over the lines of
/// the upload, with the tolerance of the contact path.
#[must_use]
pub fn one_pass_figure(parameters: &CompensationParameters, report: &CompensationReport) -> String {
    let findings = &report.findings;
    let sum = &findings.error_budget.sum;
    let title = format!(
        "One pass: {} motions changed, {} blocks inserted, largest error {} µm before and {} µm after",
        findings.changes.motions_changed,
        findings.blocks_inserted,
        plain(sum.before_um),
        plain(sum.after_um)
    );
    deviation_along_path(&DeviationFigure {
        title: &title,
        points: &errors(findings),
        tolerance_um: parameters.cc.as_ref().map(|step| step.tolerance_um),
        quantity: "sum of a motion's errors [µm]",
        place: "line of the upload",
    })
}

/// The errors of motions as programmed and as written, over the lines.
fn errors(findings: &CompensationFindings) -> Vec<DeviationPoint> {
    let series = &findings.changes.series;
    let lines: Vec<f64> = series.line.iter().map(|line| *line as f64).collect();
    DeviationPoint::zipped(&lines, &series.line, &series.error_before_um, &series.error_after_um)
}
