//! The step that moves the ends of motions, for a worn cutter and for location errors.

use std::io::Write;

use super::check::EndsCheck;
use super::moved::Moved;
use super::moves::Moves;
use super::parameters::{Milling, WearParameters};
use super::report::WearReport;
use super::work::EndsWork;
use super::worn_tool::WornTool;
use crate::machine::Machine;
use crate::process::fault::Fault;
use crate::process::pipeline::{
    Hands, Look, MotionChange, Note, Resources, Step, StepRun, StepWork, Surveyed, Upstream, reported,
};
use crate::process::set_up::{ContactSource, Stop};
use crate::process::text::{Inventory, LineMap, ProgramSource, Survey, naming_unknown_axes};
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
    output: &mut dyn Write,
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
    output: &mut dyn Write,
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
        mut look: Option<&mut dyn Look>,
        output: &mut dyn Write,
        note: Note<'_, MotionChange>,
        &Resources { machine, parts, stop }: &Resources<'_>,
    ) -> Result<LineMap, Fault> {
        let (source, from_upload) = (upstream.source, upstream.lines.clone());
        let parameters = self.moves.parameters;
        let survey = Survey::of(machine, parameters.program.dialect, source, stop)?;
        survey.refuse_repeated(self.moves.steps(), parameters.program.allow_repeated)?;
        let contact = survey.contact(parameters.contact, parameters.part.is_some())?;
        let side_by_feed = contact == ContactSource::FeedPlane && parameters.milling == Milling::Side;
        let moves = &self.moves.with_tools(&survey.tools, machine, source, stop)?;
        let worn_tools = moves.worn_tools();
        let has_nominal_shape = worn_tools.iter().all(WornTool::has_nominal_shape);
        // A cutter of nominal shape moves only by its length, wherever it touches.
        let needs_contact = moves.has_wear && !has_nominal_shape;
        if needs_contact && contact == ContactSource::Tip && parameters.contact == ContactSource::Auto {
            return Err(Fault::ContactUnknown { milling: parameters.milling.name() });
        }
        if needs_contact && (contact == ContactSource::Tip || side_by_feed) {
            return Err(Fault::UnfitContact { contact: contact.name(), milling: parameters.milling.name() });
        }
        let mut inventory = Inventory::default();
        let mut run = StepRun::begin(upstream, machine, &moves.source_program, &inventory, stop)?;
        if let Some(look) = &mut look {
            look.begin(&Surveyed { source, survey, program: None }, run.dialect())?;
        }
        let mut work = EndsWork::new(machine, moves, survey, contact, stop);
        let mut check = EndsCheck::new(machine, moves, run.dialect(), stop);
        let mut hands = Hands {
            prepare: &mut inventory,
            work: &mut work,
            check: &mut check,
            look: look.map(|look| look as &mut dyn Look),
        };
        run.run(&mut hands, output, note, parts)?;
        if hands.work.has_faults() {
            let faults = std::mem::take(&mut hands.work.faults);
            let program = &moves.source_program;
            let faults = naming_unknown_axes(faults, machine, program, source, from_upload, stop)?;
            return Err(Fault::Lines(faults));
        }
        let asks_for_nothing = has_nominal_shape && !hands.work.pilot.moves_everything && !moves.recalibrates;
        if hands.work.motions_followed == 0 && !asks_for_nothing {
            // The dialect may be wrong, for example. The caller would take an unchanged program for a compensated
            // one.
            return Err(Fault::NothingFollowed { first: hands.work.pilot.warnings.first_left() });
        }
        hands.finish(&run.passages, output, note)?;
        let passages = &run.passages;
        passages.warn(&mut work.pilot.warnings);
        let (moved, lines) = work.moved(check, passages.dialect(), passages.blocks, passages.reading());
        self.report = Some(moved);
        Ok(lines)
    }

    fn notes_motions(&self) -> bool {
        true
    }
}
