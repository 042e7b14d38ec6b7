//! The step that moves the ends of motions, for a worn cutter and for location errors.

use std::io::Write;

use super::check::EndsCheck;
use super::moved::Moved;
use super::moves::Moves;
use super::parameters::WearParameters;
use super::report::WearReport;
use super::work::EndsWork;
use crate::machine::Machine;
use crate::process::fault::Fault;
use crate::process::pipeline::{
    Asked, Hands, Look, MotionChange, Note, Resources, Step, StepDone, StepRun, Surveyed, Upstream, reported,
};
use crate::process::set_up::Stop;
use crate::process::text::{Inventory, ProgramSource};
use crate::side_by_side::{OneAfterAnother, SideBySide};

/// Moves a program's points so that a worn cutter touches where the nominal one would (§4; P3 eq. (5), (6)), in the
/// caller's thread.
///
/// # Errors
/// Those of [`compensate_wear_side_by_side`].
pub fn compensate_wear(
    machine: &Machine,
    parameters: &WearParameters,
    source: &dyn ProgramSource,
    output: &mut (dyn Write + Send),
    stop: &Stop<'_>,
) -> Result<WearReport, Fault> {
    compensate_wear_side_by_side(machine, parameters, source, output, &OneAfterAnother, stop)
}

/// Moves a program's points so that a worn cutter touches where the nominal one would (§4; P3 eq. (5), (6)).
///
/// Tool axis and rotary words never change, and blocks are never divided. A block whose words stay the same is copied
/// byte for byte. Before it returns, it reads the written text back with its own decimals. It then compares the worn
/// cutter's contact with the nominal one's at every point. The report's `after` comes from that reading.
///
/// # Errors
/// The reason why the program is refused. `output` then holds text that must not be run and must be discarded.
pub fn compensate_wear_side_by_side(
    machine: &Machine,
    parameters: &WearParameters,
    source: &dyn ProgramSource,
    output: &mut (dyn Write + Send),
    parts: &dyn SideBySide,
    stop: &Stop<'_>,
) -> Result<WearReport, Fault> {
    let moves = Moves::of_wear(parameters);
    let mut step = MoveStep::new(&moves);
    let with = Resources { machine, parts, stop };
    step.run(Upstream::upload(source), None, output, &mut |_| Ok(()), &with)?;
    Ok(step.report()?.wear)
}

/// The step that moves the ends of motions.
pub(in crate::process) struct MoveStep<'p> {
    moves: &'p Moves<'p>,
    report: Option<Moved>,
}

impl<'p> MoveStep<'p> {
    pub(in crate::process) fn new(moves: &'p Moves<'p>) -> Self {
        Self { moves, report: None }
    }

    /// The report, available after a program has gone through.
    ///
    /// # Errors
    /// No program has gone through.
    pub(in crate::process) fn report(self) -> Result<Moved, Fault> {
        reported(self.report)
    }
}

impl Step for MoveStep<'_> {
    fn run(
        &mut self,
        upstream: Upstream<'_>,
        look: Option<&mut dyn Look>,
        output: &mut (dyn Write + Send),
        note: Note<'_, MotionChange>,
        with: &Resources<'_>,
    ) -> Result<StepDone, Fault> {
        let Resources { machine, parts, stop } = *with;
        let parameters = self.moves.parameters;
        let asked = Asked {
            program: &parameters.program,
            steps: self.moves.steps(),
            contact: parameters.contact,
            has_part: parameters.part.is_some(),
        };
        let surveyed = Surveyed::of(upstream.source, &asked, with)?;
        let before_the_end = |fault| surveyed.before_the_end(fault);
        let moves = &self.moves.with_tools(&surveyed, machine, stop).map_err(before_the_end)?;
        moves.refuse_contact(surveyed.contact).map_err(before_the_end)?;
        let mut inventory = Inventory::default();
        let mut run = StepRun::begin(upstream, &surveyed, machine, &moves.source_program, &inventory, stop)?;
        let mut work = EndsWork::new(machine, moves, &surveyed, stop);
        let mut check = EndsCheck::new(machine, moves, run.dialect(), stop);
        let hands = Hands { prepare: &mut inventory, work: &mut work, check: &mut check, look };
        run.run(hands, &surveyed, output, note, parts)?;
        let (moved, lines) = work.moved(check, &run.passages);
        let report = &moved.wear;
        let interpolation = Some(report.interpolation);
        let told = StepDone::new(&run.passages, lines, interpolation, report.steps, report.blocks_out);
        self.report = Some(moved);
        Ok(told)
    }

    fn notes_motions(&self) -> bool {
        true
    }
}
