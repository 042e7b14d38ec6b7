//! The path of a job's program, read again from the kept upload: poses, with the errors of the job before and after.

use std::io::BufWriter;

use super::acceptance::machine_of_job;
use super::flattening::Flattened;
use super::refusals::in_words_of_the_wire;
use super::workplace::written;
use super::{CompensatorFault, Compute, Cost, InputFile, JobFault, Means, Spool};
use crate::process::{self, Interpreted, Stop};
use crate::store::{BlobFault, Draft, JobRow, Store};
use crate::wire::{ErrorsByLine, InterpretationParameters, JobPath, fault_of_table};

/// The path of a job's program as a table with at most `most` poses. Also returns the largest number of motions that
/// one pose stands for.
///
/// # Errors
/// The upload is missing or damaged, cannot be read, or reading it would cost too much.
pub async fn job_path(
    compute: &Compute,
    spool: &Spool,
    store: &Store,
    means: &Means,
    job: &JobRow,
    most: usize,
) -> Result<(Draft, u64), JobFault> {
    let on = machine_of_job(store, job).await?;
    let parameters = InterpretationParameters::of_job(&job.document.parameters)?;
    let mut set_up = on.program(&parameters.statements(), false).map_err(JobFault::Parameters)?;
    // Lines of the report are then those of the written-out program.
    let flattens = job.document.parameters.get("flatten").and_then(serde_json::Value::as_bool) == Some(true);
    let errors = ErrorsByLine::of(job.report.as_deref().unwrap_or_default());
    let (spool, sha256, max_cost_s) = (spool.clone(), job.document.input_sha256.clone(), means.max_cost_s);
    let work = move |stop: &Stop<'_>| -> Result<(Draft, u64), JobFault> {
        let source = InputFile::kept(spool.blobs(), &sha256)?;
        Cost::of_program_reading(source.length).within(max_cost_s)?;
        set_up.dialect = set_up.dialect.or(source.dialect_of_files());
        let flat = Flattened::of(flattens, &on.machine, &set_up, &source, &spool, stop)?;
        set_up.dialect = flat.as_ref().map(Flattened::dialect).or(set_up.dialect);
        let program = flat.as_ref().map_or(&source, |flat| &flat.program);
        let mut path = JobPath::new(errors, most);
        let mut take = |told: &Interpreted| {
            if let Interpreted::Motion(motion) = told {
                path.add(motion);
            }
            Ok(())
        };
        let read = process::interpret_program(&on.machine, &set_up, program, &mut take, stop);
        source.is_unchanged().map_err(|damaged| BlobFault::from(spool.blobs().noted(damaged)))?;
        read.map_err(in_words_of_the_wire)?;
        let (out, together) = path
            .write(BufWriter::new(spool.result()?), &on.machine)
            .map_err(|fault| CompensatorFault::Io(fault_of_table(fault)))?;
        Ok((written(out)?, together))
    };
    compute.run_in_parts(move |_threads, stop| work(stop)).await?
}
