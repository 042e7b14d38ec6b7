//! Virtual cutting of a part, as work on a program.

use std::io::{BufReader, BufWriter};

use thiserror::Error;

use super::part_surface::read_part;
use super::refusals::in_words_of_the_wire;
use super::workplace::{Finished, Workplace, written};
use super::{
    CompensatorFault, Cost, JobFault, MachineUsed, Means, Prepared, ProgramParameters, Sizes, Spool,
};
use crate::plot::{ResidualFigure, residual_map};
use crate::process;
use crate::store::{BlobFault, Blobs, Draft};
use crate::surface::EvenSamples;
use crate::units::Length;
use crate::wire::{
    Fault, FaultList, JobOperation, LocationErrors, ResidualRow, VerificationParameters, VerificationReport,
    VerificationSources, fault_of_table,
};

impl ProgramParameters for VerificationParameters {
    const OPERATION: JobOperation = JobOperation::Verification;
    const LOOKS_AT_PART: bool = true;

    fn working_bytes(&self) -> u64 {
        /// Memory for each sample: its place, its needle, its residual and its row; measured as 171 for a million
        /// samples.
        const SAMPLE_BYTES: u64 = 180;
        self.samples as u64 * SAMPLE_BYTES
    }

    fn prepare(self, on: MachineUsed, sizes: Sizes, means: &Means) -> Result<Prepared, Vec<Fault>> {
        let mut missing = FaultList::default();
        if self.tool.is_none() && on.shelf.is_empty() {
            let detail = "missing: give the cutter here, because the machine's tool table is empty";
            missing.push(|| Fault::new("/tool", detail));
        }
        let (mut core, surface) = missing.after(self.to_core(sizes.has_part()))?;
        core.program = on.program(&self.statements(), self.location_errors == LocationErrors::Apply)?;
        // No block needs its contact on the part.
        let part = Sizes { program_length: 0, ..sizes }.cost_of_part();
        let cost = Cost::of_verification(sizes.program_length, self.samples) + part;
        let [max_pieces, max_pairs] = Cost::pieces_and_pairs_within(means.max_cost_s);
        Ok(Prepared::new(cost, move |place| {
            let Workplace { program, surface: uploaded, spool, threads, stop, .. } = place;
            let mut core = process::VerificationParameters { max_pairs, max_pieces, ..core.clone() };
            core.program.dialect = core.program.dialect.or(program.dialect_of_files());
            let core = &core;
            let reading = self.surface_reading();
            let part = uploaded.map(|uploaded| read_part(uploaded, &reading.settings(), stop)).transpose()?;
            let samples = match (&surface, &part) {
                (Some(surface), _) => surface.samples_until(self.samples, stop),
                (None, Some(part)) => part.samples_until(self.samples, stop),
                (None, None) => Ok(EvenSamples::none()),
            };
            let samples = samples.map_err(|_only_cancelled| CompensatorFault::Cancelled)?;
            let verification =
                process::verify_part(&on.machine, core, &samples.points, program, threads, stop)
                    .map_err(in_words_of_the_wire)?;
            let table = residual_table(&samples, &verification, spool)?;
            let report = VerificationReport::of(
                VerificationSources {
                    machine_revision: on.revision,
                    input_sha256: program.sha256.clone(),
                    surface_sha256: uploaded.map(|uploaded| uploaded.sha256.clone()),
                    residuals_sha256: table.sha256(),
                    sample_spacing_mm: samples.spacing_mm,
                    area_mm2: samples.area_mm2,
                    mesh: part.as_ref().map(|part| *part.report()),
                    resolved: on.resolved(&self.statements(), &verification.reading)?,
                },
                core,
                &verification,
            );
            Ok(Finished { output: Some(table), ..Finished::of(&report)? })
        }))
    }
}

/// The table of residuals, aligned with the samples.
fn residual_table(
    samples: &EvenSamples,
    verification: &process::Verification,
    spool: &Spool,
) -> Result<Draft, JobFault> {
    let mut table = BufWriter::with_capacity(1 << 18, spool.result()?);
    let rows = samples.points.iter().zip(&verification.residuals).map(|(sample, residual)| ResidualRow {
        x_mm: sample.point_mm.x,
        y_mm: sample.point_mm.y,
        z_mm: sample.point_mm.z,
        nx: sample.normal.x,
        ny: sample.normal.y,
        nz: sample.normal.z,
        residual_um: residual.map(|residual| Length::from_mm(residual.residual_mm).um()),
        line: residual.map(|residual| residual.line),
    });
    ResidualRow::write_all(rows, &mut table).map_err(|fault| CompensatorFault::Io(fault_of_table(fault)))?;
    written(table)
}

/// Why a verification cannot be drawn.
#[derive(Debug, Error)]
pub enum ResidualFault {
    /// Its table cannot be opened.
    #[error(transparent)]
    Blob(#[from] BlobFault),
    /// Its table cannot be read.
    #[error("the table of residuals: {0}")]
    Table(#[from] csv::Error),
}

/// The figure of a verification, from its table of residuals.
///
/// # Errors
/// The table cannot be read: a fault of ours.
pub fn verification_figure(
    report: &VerificationReport,
    blobs: &Blobs,
    residuals_sha256: &str,
) -> Result<String, ResidualFault> {
    let table = BufReader::new(blobs.read_sound(residuals_sha256)?.file);
    let rows = ResidualRow::read_all(table)?;
    let samples: Vec<_> = rows.into_iter().map(Into::into).collect();
    let title = format!(
        "{} samples: {} over {} µm, {} cut deeper, {} uncut",
        report.samples, report.excess_over_limit, report.limit_um, report.gouge_over_limit, report.uncut
    );
    let figure = ResidualFigure { title: &title, samples: &samples, limit_um: report.limit_um };
    Ok(residual_map(&figure))
}
