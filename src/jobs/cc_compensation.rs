//! The compensation of the CC path, as work on a program.

use std::sync::Arc;

use super::cc_compensator::core_parameters;
use super::flattening::Flattened;
use super::part_surface::part_surface;
use super::stamping::{Leaving, Stamping};
use super::step_files::StepFiles;
use super::workplace::{Finished, Workplace};
use super::{Compensated, Cost, MachineUsed, Means, Prepared, ProgramParameters, Sizes};
use crate::meter;
use crate::process::{ProgramReading, ProgramSetup};
use crate::program::{StepName, Steps};
use crate::wire::{CcParameters, CcReport, Contact, Fault, FaultList, JobOperation, SingularityAction};

impl ProgramParameters for CcParameters {
    const OPERATION: JobOperation = JobOperation::CcCompensation;
    const LOOKS_AT_PART: bool = true;

    fn steps(&self) -> Steps {
        treats(self.singularity).with(StepName::Cc).not_done_before(self.allow_repeated)
    }

    fn prepare(self, on: MachineUsed, sizes: Sizes, means: &Means) -> Result<Prepared, Vec<Fault>> {
        let mut missing = FaultList::default();
        missing_tool(&self, "", &on, &mut missing);
        let tool = missing.after(self.check(sizes.has_part()))?;
        let parameters = serde_json::to_value(&self).unwrap_or_default();
        let program =
            ProgramSetup { allow_repeated: self.allow_repeated, ..on.program(&self.statements(), true)? };
        let mut asked = core_parameters(&self, tool, program);
        asked.max_feed = on.statements.max_feed(self.max_feed_mm_per_min);
        asked.block_time_s = on.statements.block_time_s();
        let singularity = self.singular_regions.to_core(self.singularity);
        let cost = Cost::of_program(sizes.program_length, self.tolerance_um) + sizes.cost_of_part();
        let compensator = Arc::clone(&means.compensator);
        let in_turn = 1 + u32::from(self.singularity != SingularityAction::Report);
        Ok(Prepared::new(cost, move |place| {
            let Workplace { program, spool, stop, .. } = place;
            asked.program.dialect = asked.program.dialect.or(program.dialect_of_files());
            let flat = Flattened::of(self.flatten, &on.machine, &asked.program, program, spool, stop)?;
            asked.program.dialect = flat.as_ref().map(Flattened::dialect).or(asked.program.dialect);
            let place = place.with(flat.as_ref());
            let Workplace { program, surface, spool, threads, stop, survey } = place;
            asked.program.steps_done = program.steps_done;
            asked.program.survey = survey;
            asked.part = part_surface(surface, &self.surface_reading(), stop)?;
            let resolve = |reading: &ProgramReading| {
                let resolved = on.resolved(&self.statements(), reading)?;
                Ok(resolved.with_max_feed(self.max_feed_mm_per_min, &on.statements))
            };
            let stamping =
                Stamping { on: &on, operation: Self::OPERATION, parameters: &parameters, form: self.stamp };
            let mut output = stamping.output(&place, self.steps(), &asked.program, &resolve)?;
            let resting = StepFiles::new(spool.blobs().clone(), program);
            let Compensated { mut findings, dialect, steps, reading } = compensator.compensate(
                &on.machine,
                &asked,
                &singularity,
                program,
                &mut output,
                &resting,
                threads,
                stop,
            )?;
            findings.warnings.extend(flat.iter().flat_map(Flattened::warnings));
            meter::PROGRAM_BLOCKS.add(findings.blocks_in);
            let leaving = Leaving { output, resolved: resolve(&reading)?, dialect, steps };
            let motions_checked = Some(findings.motions_checked);
            let report = |provenance, resolved| CcReport { provenance, resolved: Some(resolved), findings };
            Ok(Finished { motions_checked, ..stamping.finish(leaving, &place, report)? })
        })
        .with_steps_in_turn(in_turn))
    }
}

/// The cutter is not stated, so the machine's tool table must give it. A corner radius alone was reported as a fault
/// before.
pub(super) fn missing_tool(
    parameters: &CcParameters,
    pointer: &str,
    on: &MachineUsed,
    faults: &mut FaultList,
) {
    let is_stated = parameters.tool_radius_mm.is_some() || parameters.corner_radius_mm.is_some();
    if !is_stated && parameters.contact != Contact::Tip && on.shelf.is_empty() {
        let detail = "missing: only contact=tip works without a tool, and the machine's tool table is empty; give the tool radius";
        faults.push(|| Fault::new(format!("{pointer}/tool_radius_mm"), detail));
    }
}

/// The step that treats singular regions, if they are not only reported.
pub(super) fn treats(action: SingularityAction) -> Steps {
    if action == SingularityAction::Report { Steps::NONE } else { Steps::of(&[StepName::Singularity]) }
}
