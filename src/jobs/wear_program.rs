//! A program for a worn cutter, kept as a job.

use std::io::BufWriter;

use super::cutter_contact::{contact, series, summary};
use super::part_surface::{cost_of_part, part_surface};
use super::program_file::FileSource;
use super::program_job::{Finished, Workplace, run_program_job};
use super::refusals::in_words_of_the_wire;
use super::{CompensatorFault, Compute, Cost, JobFault, ProgramJob, Sources, Spool};
use crate::machine::Machine;
use crate::plot::{DeviationFigure, DeviationPoint, deviation_along_path};
use crate::process;
use crate::store::{JobRow, Store};
use crate::units::Angle;
use crate::wire::{Fixed, Provenance, WearFindings, WearParameters, WearReport};

/// One program for a worn cutter.
#[derive(Debug)]
pub struct WearProgramRequest {
    /// The machine at the job's revision.
    pub machine: Machine,
    /// The parameters as they came, for the advice.
    pub parameters: WearParameters,
    /// The same in the core's terms.
    pub core: process::WearParameters,
    /// The dearest computation allowed \[s of one core\].
    pub max_cost_s: f64,
}

/// Compensates and stores; on any fault nothing is stored.
///
/// # Errors
/// Why there is no job.
pub async fn compensate_wear(
    compute: &Compute,
    store: &Store,
    spool: &Spool,
    sources: &Sources,
    job: ProgramJob,
    request: WearProgramRequest,
) -> Result<JobRow, JobFault> {
    let length = job.program.length();
    let cost = Cost::of_moving_ends(length);
    (cost + cost_of_part(job.surface.as_ref(), length)?).within(request.max_cost_s)?;
    let machine_revision = job.machine_revision;
    run_program_job(
        compute,
        store,
        spool,
        sources,
        job,
        move |Workplace { program, surface, spool, stop, .. }| {
            let mut output = BufWriter::with_capacity(1 << 18, spool.blobs().draft()?);
            let WearProgramRequest { machine, parameters, mut core, .. } = request;
            core.part = part_surface(surface, &parameters.surface_reading(), stop)?;
            let source = FileSource(program.path());
            let report = process::compensate_wear(&machine, &core, &source, &mut output, stop)
                .map_err(in_words_of_the_wire)?;
            let output = output.into_inner().map_err(|fault| CompensatorFault::Io(fault.into_error()))?;
            let provenance = Provenance {
                machine_revision,
                software_version: env!("CARGO_PKG_VERSION").to_owned(),
                input_sha256: program.sha256(),
                output_sha256: output.sha256(),
            };
            let findings = findings(&parameters, &report);
            let report = serde_json::to_string(&WearReport { provenance, findings })?;
            Ok(Finished { report, output: Some(output), changes: None })
        },
    )
    .await
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
