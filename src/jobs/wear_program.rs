//! The compensation for a worn cutter, as work on a program.

use super::flattening::Flattened;
use super::part_surface::part_surface;
use super::program_figure::points_of;
use super::refusals::in_words_of_the_wire;
use super::stamping::{Leaving, Stamping};
use super::workplace::{Finished, Workplace};
use super::{Cost, MachineUsed, Means, Prepared, ProgramParameters, Sizes};
use crate::meter;
use crate::plot::{ALONG_CONTACT_PATH, DeviationFigure, deviation_along_path};
use crate::process::{self, ProgramReading, ProgramSetup};
use crate::program::{StepName, Steps};
use crate::units::Angle;
use crate::wire::{Fault, FaultList, Fixed, JobOperation, WearFindings, WearParameters, WearReport};

impl ProgramParameters for WearParameters {
    const OPERATION: JobOperation = JobOperation::WearCompensation;
    const LOOKS_AT_PART: bool = true;

    fn steps(&self) -> Steps {
        Steps::of(&[StepName::Wear])
    }

    fn cutter_id(&self) -> Option<&str> {
        self.wear.as_ref().map(|source| source.cutter_id.as_str())
    }

    fn prepare(self, on: MachineUsed, sizes: Sizes, means: &Means) -> Result<Prepared, Vec<Fault>> {
        let mut missing = FaultList::default();
        missing_from_table(&self, "", &on, &mut missing);
        let mut core = missing.after(self.to_core(sizes.has_part()))?;
        let parameters = serde_json::to_value(&self).unwrap_or_default();
        core.program =
            ProgramSetup { allow_repeated: self.allow_repeated, ..on.program(&self.statements(), true)? };
        core.budget = Cost::budget_within(means.max_cost_s);
        let cost = Cost::of_moving_ends(sizes.program_length) + sizes.cost_of_part();
        Ok(Prepared::new(cost, move |place| {
            let Workplace { program, spool, stop, .. } = place;
            core.program.dialect = core.program.dialect.or(program.dialect_of_files());
            let flat = Flattened::of(self.flatten, &on.machine, &core.program, program, spool, stop)?;
            core.program.dialect = flat.as_ref().map(Flattened::dialect).or(core.program.dialect);
            let place = place.with(flat.as_ref());
            let Workplace { program, surface, threads, stop, .. } = place;
            core.program.steps_done = program.steps_done;
            core.program.survey = place.survey;
            core.part = part_surface(surface, &self.surface_reading(), stop)?;
            let resolve = |reading: &ProgramReading| on.resolved(&self.statements(), reading);
            let stamping =
                Stamping { on: &on, operation: Self::OPERATION, parameters: &parameters, form: self.stamp };
            let mut output = stamping.output(&place, self.steps(), &core.program, &resolve)?;
            let moved = process::compensate_wear_side_by_side(
                &on.machine,
                &core,
                program,
                &mut output,
                threads,
                stop,
            );
            let moved = moved.map_err(in_words_of_the_wire)?;
            let mut findings = findings(&self, &moved);
            findings.warnings.extend(flat.iter().flat_map(Flattened::warnings));
            meter::PROGRAM_BLOCKS.add(findings.blocks_in);
            let (dialect, steps) = (moved.dialect, moved.steps);
            let leaving = Leaving { output, resolved: resolve(&moved.reading)?, dialect, steps };
            let motions_checked = Some(findings.motions_checked());
            let report = |provenance, resolved| WearReport { provenance, resolved: Some(resolved), findings };
            Ok(Finished { motions_checked, ..stamping.finish(leaving, &place, report)? })
        })
        .with_steps_in_turn(1))
    }
}

/// The nominal cutter is not stated, so the machine's tool table must give it.
pub(super) fn missing_from_table(
    parameters: &WearParameters,
    pointer: &str,
    on: &MachineUsed,
    faults: &mut FaultList,
) {
    if parameters.nominal_tool.is_some() || !on.shelf.is_empty() {
        return;
    }
    if parameters.wear.is_some() {
        let detail =
            "the machine's tool table is empty: store the tool that has these wear entries, with its radii";
        faults.push(|| Fault::new("/wear/from", detail));
    } else {
        let detail = "missing: give the cutter that the program was made for, because the machine's tool table is empty";
        faults.push(|| Fault::new(format!("{pointer}/nominal_tool"), detail));
    }
}

/// The core's report as a wire document.
pub(super) fn findings(parameters: &WearParameters, report: &process::WearReport) -> WearFindings {
    WearFindings {
        dialect: report.dialect.into(),
        interpolation: report.interpolation.into(),
        contact: report.contact.into(),
        blocks_in: report.blocks_in,
        blocks_out: report.blocks_out,
        blocks_changed: report.blocks_changed,
        contacts_kept: report.contacts_kept,
        contacts_assumed: report.contacts_assumed,
        assumption: report.assumption.as_ref().map(Into::into),
        motions_shifted: report.motions_shifted,
        feeds_lowered: report.feeds_lowered,
        feeds_restored: report.feeds_restored,
        max_shift_um: report.max_shift.um(),
        max_shift_line: report.max_shift_line,
        contact_angle_deg: report.contact_angles.map(|angles| Fixed(angles.map(Angle::deg))),
        before: (&report.before).into(),
        after: (&report.after).into(),
        after_if_assumed: report.after_if_assumed.as_ref().map(Into::into),
        cc_path_length_mm: report.cc_path_length_mm,
        series: (&report.series).into(),
        advice: parameters.advice(report.contact_angles, report.curvature.as_ref()),
        curvature: report.curvature.as_ref().map(Into::into),
        warnings: report.warnings.iter().map(Into::into).collect(),
    }
}

/// The figure of a report, as SVG text.
#[must_use]
pub fn wear_figure(report: &WearReport) -> String {
    let findings = &report.findings;
    let points = points_of(&findings.series);
    let title = format!(
        "Worn cutter: {} contacts kept, {} motions moved by up to {:.1} µm",
        findings.contacts_kept, findings.motions_shifted, findings.max_shift_um
    );
    let quantity = "offset of the worn cutter at the contact [µm]";
    let place = ALONG_CONTACT_PATH;
    deviation_along_path(&DeviationFigure {
        title: &title,
        points: &points,
        tolerance_um: None,
        quantity,
        place,
    })
}
