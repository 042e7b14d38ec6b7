//! Posting of cutter location data, as work on a program.

use super::program_job::{Finished, Workplace, written};
use super::refusals::in_words_of_the_wire;
use super::{Cost, MachineUsed, Means, Prepared, ProgramParameters, Sizes};
use crate::process;
use crate::wire::{Fault, JobOperation, PostingFindings, PostingParameters, PostingReport};

impl ProgramParameters for PostingParameters {
    const OPERATION: JobOperation = JobOperation::Posting;
    const LOOKS_AT_PART: bool = false;

    fn prepare(self, on: MachineUsed, sizes: Sizes, means: &Means) -> Result<Prepared, Vec<Fault>> {
        let mut core = self.to_core(&on.machine)?;
        core.max_blocks_out = core.max_blocks_out.min(Cost::budget_within(means.max_cost_s).max_blocks_out);
        Ok(Prepared::new(Cost::of_posting(sizes.program_length), move |place| {
            let Workplace { program, stop, .. } = place;
            let mut output = place.output()?;
            let report = process::post(&on.machine, &core, program, &mut output, stop)
                .map_err(in_words_of_the_wire)?;
            let output = written(output)?;
            let provenance = on.provenance(program, &output);
            let findings = PostingFindings::of(&self, &report);
            let report = serde_json::to_string(&PostingReport { provenance, findings })?;
            Ok(Finished { report, output: Some(output), changes: None })
        }))
    }
}
