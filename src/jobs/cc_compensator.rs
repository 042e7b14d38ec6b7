//! The service's compensator: the core's compensation, and its report as a wire document.

use std::io::Write;

use super::program_figure::points_of;
use super::refusals::in_words_of_the_wire;
use super::{Compensated, Compensator, CompensatorFault};
use crate::contact::Correction as CoreCorrection;
use crate::machine::{Machine, Tool};
use crate::plot::{ALONG_CONTACT_PATH, DeviationFigure, deviation_along_path};
use crate::process::{self, ProgramSetup, SingularityParameters, SingularityReport, Stop};
use crate::program::Steps;
use crate::side_by_side::SideBySide;
use crate::units::{Angle, Length};
use crate::wire::{CcFindings, CcParameters, CcReport, Contact, Correction, Output};

/// Compensates programs with the core.
#[derive(Debug, Clone, Copy, Default)]
pub struct CutterContactCompensator {
    /// The largest cost of one program, checked while it runs.
    pub budget: process::Budget,
}

impl Compensator for CutterContactCompensator {
    fn compensate(
        &self,
        machine: &Machine,
        asked: &process::CcParameters,
        singularity: &SingularityParameters,
        source: &dyn process::ProgramSource,
        output: &mut (dyn Write + Send),
        spool: &dyn process::StepStore,
        parts: &dyn SideBySide,
        stop: &Stop<'_>,
    ) -> Result<Compensated, CompensatorFault> {
        let core = process::CcParameters { budget: self.budget, ..asked.clone() };
        let both =
            process::treat_and_compensate(machine, &core, singularity, source, spool, output, parts, stop);
        let (regions, report) = both.map_err(in_words_of_the_wire)?;
        let steps = regions.as_ref().map_or(Steps::NONE, SingularityReport::steps).and(report.steps);
        let findings = CcFindings { singularity: regions.as_ref().map(Into::into), ..findings(&report) };
        Ok(Compensated { findings, steps, dialect: report.dialect, reading: report.reading })
    }

    fn figure(&self, parameters: &CcParameters, report: &CcReport) -> String {
        let findings = &report.findings;
        let points = points_of(&findings.series);
        let title = format!(
            "Cutter contact: {} of {} motions over tolerance, {} blocks inserted",
            findings.motions_over_tolerance, findings.motions_checked, findings.blocks_inserted
        );
        deviation_along_path(&DeviationFigure {
            title: &title,
            points: &points,
            tolerance_um: Some(parameters.tolerance_um),
            quantity: "deviation from the contact line [µm]",
            place: ALONG_CONTACT_PATH,
        })
    }
}

/// The parameters in the core's terms.
pub(super) fn core_parameters(
    wire: &CcParameters,
    tool: Option<Tool>,
    program: ProgramSetup,
) -> process::CcParameters {
    let contact = match wire.contact {
        Contact::Auto => process::ContactSource::Auto,
        Contact::Program => process::ContactSource::Program,
        Contact::Normals => process::ContactSource::Normals,
        Contact::FeedPlane => process::ContactSource::FeedPlane,
        Contact::Tip => process::ContactSource::Tip,
        Contact::Surface => process::ContactSource::Surface,
    };
    process::CcParameters {
        tolerance: Length::from_um(wire.tolerance_um),
        contact,
        pass_break: Angle::from_deg(wire.pass_break_deg),
        correction: match wire.correction {
            Correction::Even => CoreCorrection::Even,
            Correction::Foot => CoreCorrection::Foot,
            Correction::Seed => CoreCorrection::Seed,
        },
        output: match wire.output {
            Output::Minimal => process::OutputForm::Minimal,
            Output::Interpolated => process::OutputForm::Interpolated,
        },
        ..process::CcParameters::new(tool, program)
    }
}

/// The core's report as a wire document.
pub(super) fn findings(report: &process::CcReport) -> CcFindings {
    CcFindings {
        dialect: report.dialect.into(),
        interpolation: report.interpolation.into(),
        contact: report.contact.into(),
        blocks_in: report.blocks_in,
        blocks_out: report.blocks_out,
        blocks_inserted: report.blocks_out.saturating_sub(report.blocks_in),
        feeds_restored: report.feeds_restored,
        motions_checked: report.motions_checked,
        motions_over_tolerance: report.motions_over_tolerance,
        motions_left_over: report.motions_left_over,
        before: (&report.before).into(),
        after: (&report.after).into(),
        cc_path_length_mm: report.cc_path_length_mm,
        singularity: None,
        series: (&report.series).into(),
        warnings: report.warnings.iter().map(Into::into).collect(),
    }
}
