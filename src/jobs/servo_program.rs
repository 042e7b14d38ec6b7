//! The servo simulation of a program, kept as a job.

use super::program_file::FileSource;
use super::program_job::{Finished, Workplace, run_program_job};
use super::refusals::in_words_of_the_wire;
use super::{Compute, Cost, JobFault, ProgramJob, Sources, Spool};
use crate::machine::Machine;
use crate::process::{self, SimulationParameters};
use crate::store::{JobRow, Store};
use crate::wire::ServoReport;

/// One program to be simulated.
#[derive(Debug)]
pub struct ServoProgramRequest {
    /// The machine at the job's revision.
    pub machine: Machine,
    /// The parameters in the core's terms.
    pub parameters: SimulationParameters,
    /// The dearest computation allowed \[s of one core\].
    pub max_cost_s: f64,
}

/// Simulates and stores; on any fault nothing is stored. The cost follows from the running time of the program, which
/// a first reading finds: it bounds the number of samples.
///
/// # Errors
/// Why there is no job.
pub async fn simulate_program(
    compute: &Compute,
    store: &Store,
    spool: &Spool,
    sources: &Sources,
    job: ProgramJob,
    request: ServoProgramRequest,
) -> Result<JobRow, JobFault> {
    Cost::of_program_reading(job.program.length()).within(request.max_cost_s)?;
    let ServoProgramRequest { machine, mut parameters, max_cost_s } = request;
    parameters.max_samples = parameters.max_samples.min(Cost::servo_samples_within(max_cost_s));
    let machine_revision = job.machine_revision;
    run_program_job(compute, store, spool, sources, job, move |Workplace { program, stop, .. }| {
        let source = FileSource(program.path());
        let simulation = match process::simulate(&machine, &parameters, &source, stop) {
            Ok(simulation) => simulation,
            Err(process::Fault::Servo(fault)) => return Err(fault.into()),
            Err(fault) => return Err(in_words_of_the_wire(fault).into()),
        };
        let report = ServoReport::of(machine_revision, program.sha256(), &parameters.drives, &simulation);
        Ok(Finished { report: serde_json::to_string(&report)?, output: None, changes: None })
    })
    .await
}
