//! Posting of cutter location data, as work on a program.

use super::refusals::{in_words_of_the_wire, of_program};
use super::stamping::stamped_steps;
use super::workplace::{Finished, Workplace, written};
use super::{CompensatorFault, Cost, MachineUsed, Means, Prepared, ProgramParameters, Sizes};
use crate::process;
use crate::wire::{Fault, JobOperation, LocationErrors, PostingFindings, PostingParameters, PostingReport};

/// Largest distance of the tip from the straight line half way between two points \[mm\] that is still posted. Beyond
/// it the points are too far apart for machine coordinates, and the motion between them is no longer finishing.
const MAX_TIP_SWING_MM: f64 = 1.0;

/// Refuses a cut along which the table winds back or the tip leaves its line: posting cannot correct the path between
/// two points.
fn unless_it_leaves_its_path(report: &process::PostReport) -> Result<(), CompensatorFault> {
    let (detail, line) = if let Some(line) = report.cutting_rewind_line {
        let detail = format!(
            "at line {line} a rotary axis must rewind within a cut; retract there, or give the axis more travel"
        );
        (detail, Some(line))
    } else if report.largest_tip_swing_mm > MAX_TIP_SWING_MM {
        let (off_mm, line) = (report.largest_tip_swing_mm, report.tip_swing_line);
        let detail = format!(
            "half way to a point the tip is {off_mm:.3} mm off the straight line, more than {MAX_TIP_SWING_MM} mm: give more \
             points, or use interpolation=tcp"
        );
        (detail, line)
    } else {
        return Ok(());
    };
    Err(CompensatorFault::Refused(Box::new(of_program(line, detail))))
}

impl ProgramParameters for PostingParameters {
    const OPERATION: JobOperation = JobOperation::Posting;
    const LOOKS_AT_PART: bool = false;
    const CALLS_FILES: bool = false;

    fn prepare(self, on: MachineUsed, sizes: Sizes, means: &Means) -> Result<Prepared, Vec<Fault>> {
        let mut core = self.to_core(&on.machine)?;
        let program = on.program(&self.statements(), self.location_errors == LocationErrors::Apply)?;
        core.program = self.with_points(program);
        core.max_feed = on.statements.max_feed(None);
        core.max_blocks_out = core.max_blocks_out.min(Cost::budget_within(means.max_cost_s).max_blocks_out);
        Ok(Prepared::new(Cost::of_posting(sizes.program_length), move |place| {
            let Workplace { program, stop, .. } = place;
            let mut output = place.output()?;
            let report = process::post(&on.machine, &core, program, &mut output, stop)
                .map_err(in_words_of_the_wire)?;
            unless_it_leaves_its_path(&report)?;
            let output = written(output)?;
            let provenance = on.provenance(program, &output);
            let resolved = Some(on.resolved(&self.statements(), &report.reading)?);
            let findings = PostingFindings::of(&self, &report);
            let report = PostingReport { provenance, resolved, findings };
            // The machine program has no stamp of its source, but whatever was done to the source is in it.
            let steps = Some(stamped_steps(program).map_err(CompensatorFault::Io)?);
            Ok(Finished { output: Some(output), steps, ..Finished::of(&report)? })
        }))
    }
}
