//! The servo simulation of a program, as work on a program.

use super::refusals::in_words_of_the_wire;
use super::workplace::{Finished, Workplace};
use super::{Cost, MachineUsed, Means, Prepared, ProgramParameters, Sizes};
use crate::process;
use crate::wire::{Fault, FaultList, JobOperation, LocationErrors, ServoProgramParameters, ServoReport};

/// The cost follows from the running time of the program, which a first reading finds: it bounds the number of samples.
impl ProgramParameters for ServoProgramParameters {
    const OPERATION: JobOperation = JobOperation::ServoSimulation;
    const LOOKS_AT_PART: bool = false;

    fn prepare(self, on: MachineUsed, sizes: Sizes, means: &Means) -> Result<Prepared, Vec<Fault>> {
        let mut faults = FaultList::default();
        let mut core = self.to_core(on.drives.as_ref(), &mut faults);
        faults.into_result()?;
        core.program = on.program(&self.statements(), self.location_errors == LocationErrors::Apply)?;
        core.max_samples = core.max_samples.min(Cost::servo_samples_within(means.max_cost_s));
        let cost = Cost::of_program_reading(sizes.program_length);
        Ok(Prepared::new(cost, move |Workplace { program, stop, .. }| {
            core.program.dialect = core.program.dialect.or(program.dialect_of_files());
            let simulation = match process::simulate(&on.machine, &core, program, stop) {
                Ok(simulation) => simulation,
                Err(process::Fault::Servo(fault)) => return Err(fault.into()),
                Err(fault) => return Err(in_words_of_the_wire(fault).into()),
            };
            let resolved = on.resolved(&self.statements(), &simulation.reading)?;
            let report =
                ServoReport::of(on.revision, program.sha256.clone(), resolved, &core.drives, &simulation);
            Finished::of(&report)
        }))
    }
}
