//! A program for a worn cutter, as work on a program.

use super::cutter_contact::{contact, series, summary};
use super::part_surface::part_surface;
use super::program_job::{Finished, Workplace, written};
use super::refusals::in_words_of_the_wire;
use super::{Cost, MachineUsed, Means, Prepared, ProgramParameters, Sizes};
use crate::meter;
use crate::plot::{DeviationFigure, DeviationPoint, deviation_along_path};
use crate::process;
use crate::units::Angle;
use crate::wire::{Fault, Fixed, JobOperation, WearFindings, WearParameters, WearReport};

impl ProgramParameters for WearParameters {
    const OPERATION: JobOperation = JobOperation::WearCompensation;
    const LOOKS_AT_PART: bool = true;

    fn prepare(self, on: MachineUsed, sizes: Sizes, _means: &Means) -> Result<Prepared, Vec<Fault>> {
        let mut core = self.to_core(sizes.has_part())?;
        let cost = Cost::of_moving_ends(sizes.program_length) + sizes.cost_of_part();
        Ok(Prepared::new(cost, move |place| {
            let Workplace { program, surface, threads, stop, .. } = place;
            let mut output = place.output()?;
            core.part = part_surface(surface, &self.surface_reading(), stop)?;
            let moved = process::compensate_wear_side_by_side(
                &on.machine,
                &core,
                program,
                &mut output,
                threads,
                stop,
            );
            let report = moved.map_err(in_words_of_the_wire)?;
            let output = written(output)?;
            let provenance = on.provenance(program, &output);
            let findings = findings(&self, &report);
            meter::PROGRAM_BLOCKS.add(findings.blocks_in);
            let report = serde_json::to_string(&WearReport { provenance, findings })?;
            Ok(Finished { report, output: Some(output), changes: None })
        }))
    }
}

/// The core's report in the words of the wire.
pub(super) fn findings(parameters: &WearParameters, report: &process::WearReport) -> WearFindings {
    WearFindings {
        dialect: report.dialect.into(),
        interpolation: report.interpolation.into(),
        contact: contact(report.contact),
        blocks_in: report.blocks_in,
        blocks_out: report.blocks_out,
        blocks_changed: report.blocks_changed,
        contacts_kept: report.contacts_kept,
        motions_shifted: report.motions_shifted,
        feeds_lowered: report.feeds_lowered,
        feeds_restored: report.feeds_restored,
        max_shift_um: report.max_shift.um(),
        max_shift_line: report.max_shift_line,
        contact_angle_deg: report.contact_angles.map(|angles| Fixed(angles.map(Angle::deg))),
        before: summary(&report.before),
        after: summary(&report.after),
        cc_path_length_mm: report.cc_path_length_mm,
        series: series(&report.series),
        advice: parameters.advice(report.contact_angles, report.curvature.as_ref()),
        curvature: report.curvature.as_ref().map(Into::into),
        warnings: report.warnings.iter().map(Into::into).collect(),
    }
}

/// The figure of a report, as SVG text.
#[must_use]
pub fn wear_figure(report: &WearReport) -> String {
    let findings = &report.findings;
    let points = DeviationPoint::zipped(
        &findings.series.path_mm,
        &findings.series.line,
        &findings.series.before_um,
        &findings.series.after_um,
    );
    let title = format!(
        "Worn cutter: {} contacts kept, {} motions moved by up to {:.1} µm",
        findings.contacts_kept, findings.motions_shifted, findings.max_shift_um
    );
    let quantity = "offset of the worn cutter at the contact [µm]";
    let figure = DeviationFigure { title: &title, points: &points, tolerance_um: None, quantity };
    deviation_along_path(&figure).unwrap_or_else(|fault| {
        tracing::error!(error = %fault, "a figure could not be drawn");
        String::new()
    })
}
