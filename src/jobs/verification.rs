//! Virtual cutting of a part, kept as a job.

use std::io::{BufReader, BufWriter};

use thiserror::Error;

use super::part_surface::{cost_of_part, read_part};
use super::program_file::FileSource;
use super::program_job::{Finished, Workplace, run_program_job};
use super::refusals::in_words_of_the_wire;
use super::{CompensatorFault, Compute, Cost, JobFault, ProgramJob, Sources, Spool};
use crate::machine::Machine;
use crate::plot::{PlotFault, ResidualFigure, residual_map};
use crate::process;
use crate::store::{BlobFault, Blobs, Draft, JobRow, Store};
use crate::surface::EvenSamples;
use crate::units::Length;
use crate::wire::{AnySurface, ResidualRow, SurfaceReading, VerificationReport, VerificationSources};

/// One program to be cut virtually.
pub struct VerificationRequest {
    /// The machine at the job's revision.
    pub machine: Machine,
    /// What is asked, in the core's terms.
    pub core: process::VerificationParameters,
    /// The surface, where it is none that was uploaded.
    pub surface: Option<AnySurface>,
    /// How an uploaded one is read.
    pub reading: SurfaceReading,
    /// How many points of it are looked at.
    pub samples: usize,
    /// The dearest computation allowed \[s of one core\].
    pub max_cost_s: f64,
}

/// Cuts and stores; on any fault nothing is stored.
///
/// # Errors
/// Why there is no job.
pub async fn verify_part(
    compute: &Compute,
    store: &Store,
    spool: &Spool,
    sources: &Sources,
    job: ProgramJob,
    request: VerificationRequest,
) -> Result<JobRow, JobFault> {
    let cost = Cost::of_verification(job.program.length(), request.samples);
    (cost + cost_of_part(job.surface.as_ref(), 0)?).within(request.max_cost_s)?;
    let machine_revision = job.machine_revision;
    run_program_job(compute, store, spool, sources, job, move |place| {
        let Workplace { program, surface: uploaded, spool, threads, stop } = place;
        let VerificationRequest { machine, core, surface, reading, samples, max_cost_s } = &request;
        let [max_pieces, max_pairs] = Cost::pieces_and_pairs_within(*max_cost_s);
        let core = &process::VerificationParameters { max_pairs, max_pieces, ..core.clone() };
        let part = uploaded.map(|uploaded| read_part(uploaded, &reading.settings(), stop)).transpose()?;
        let samples = match (surface, &part) {
            (Some(surface), _) => surface.samples(*samples),
            (None, Some(part)) => part.samples(*samples),
            (None, None) => EvenSamples { points: Vec::new(), area_mm2: 0.0, spacing_mm: 0.0 },
        };
        let source = FileSource(program.path());
        let verification = process::verify_part(machine, core, &samples.points, &source, threads, stop)
            .map_err(in_words_of_the_wire)?;
        let table = residual_table(&samples, &verification, spool)?;
        let report = VerificationReport::of(
            VerificationSources {
                machine_revision,
                input_sha256: program.sha256(),
                surface_sha256: uploaded.map(Draft::sha256),
                residuals_sha256: table.sha256(),
                sample_spacing_mm: samples.spacing_mm,
                area_mm2: samples.area_mm2,
                mesh: part.as_ref().map(|part| *part.report()),
            },
            core,
            &verification,
        );
        Ok(Finished { report: serde_json::to_string(&report)?, output: Some(table), changes: None })
    })
    .await
}

/// The table of residuals, aligned with the samples.
fn residual_table(
    samples: &EvenSamples,
    verification: &process::Verification,
    spool: &Spool,
) -> Result<Draft, JobFault> {
    let mut table = BufWriter::with_capacity(1 << 18, spool.blobs().draft()?);
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
    ResidualRow::write_all(rows, &mut table).map_err(|fault| CompensatorFault::Io(fault.into()))?;
    table.into_inner().map_err(|fault| CompensatorFault::Io(fault.into_error()).into())
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
    /// The figure could not be drawn.
    #[error(transparent)]
    Plot(#[from] PlotFault),
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
    let table = BufReader::new(blobs.read(residuals_sha256)?);
    let rows = ResidualRow::read_all(table)?;
    let samples: Vec<_> = rows.into_iter().map(Into::into).collect();
    let title = format!(
        "{} samples: {} over {} µm, {} cut deeper, {} uncut",
        report.samples, report.excess_over_limit, report.limit_um, report.gouge_over_limit, report.uncut
    );
    let figure = ResidualFigure { title: &title, samples: &samples, limit_um: report.limit_um };
    Ok(residual_map(&figure)?)
}
