//! The course of a compensation in one pass: move ends, compensate the contact path, simulate the drives, sum up.

use std::io::{BufReader, BufWriter, Read, Write};
use std::sync::OnceLock;

use super::changes::{ChangeSink, ChangeTotals};
use super::error_budget::{NotModelled, Tally};
use super::parameters::{CompensationParameters, ServoStep};
use super::report::{CompensationReport, LocationErrorReport};
use super::steps::{StepList, StepReports};
use super::unmodelled::Unmodelled;
use crate::machine::{LocationError, Machine, Squareness};
use crate::motion::Interpolation;
use crate::process::contact_path::PathStep;
use crate::process::fault::{Fault, LeftOut};
use crate::process::move_ends::{MoveStep, Moved, Moves, WearParameters};
use crate::process::pipeline::{MotionChange, Note, Resources, StepDone, record, to_upload};
use crate::process::set_up::{ProgramSetup, Stop};
use crate::process::simulate::{SimulationParameters, simulate_lines};
use crate::process::singular::{RegionSearch, SingularStep};
use crate::process::text::{CHUNK_BYTES, LineCursor, Place, ProgramSource, StepStore, StoredText, read_some};
use crate::program::Steps;
use crate::side_by_side::SideBySide;

/// Compensates a program with all steps its parameters name. Each step surveys its text and then reads
/// it: the upload, or what the step before stored in `store`.
///
/// The ends of motions move first, for wear and location errors together and with one rounding. The rotary words of
/// the calibrated machine are taken next to the source's. X Y Z then put the worn cutter's contact (the tip if no
/// contact is known) at its intended position. Next, the cutter-contact path between the ends is compensated, with
/// the worn cutter on the calibrated machine. Every step reads its own text back. `changes` gets every changed
/// motion. Memory does not grow with the program.
///
/// # Errors
/// No step is named, or the program is refused. `output` and the content of `changes` must then be thrown away and
/// not be run.
#[expect(clippy::too_many_arguments, reason = "what goes in, what comes out, and who does the work")]
pub fn compensate_program(
    machine: &Machine,
    parameters: &CompensationParameters,
    source: &dyn ProgramSource,
    store: &dyn StepStore,
    output: &mut (dyn Write + Send),
    changes: &mut dyn ChangeSink,
    parts: &dyn SideBySide,
    stop: &Stop<'_>,
) -> Result<CompensationReport, Fault> {
    if !parameters.moves() && parameters.cc.is_none() {
        return Err(Fault::NothingAsked);
    }
    let with = Resources { machine, parts, stop };
    let treatment = parameters.treatment();
    let moving = parameters.moving();
    let has_errors = has_errors(machine);
    let moves = parameters.moves().then(|| moves(parameters, &moving, has_errors));
    let program = moves.as_ref().map_or_else(|| parameters.real_program(), Moves::program_after);
    let path = parameters.cc.as_ref().map(|step| parameters.contact_path(step, program.clone()));
    let with_tools = OnceLock::new();
    let lists = parameters.regions_to_list();
    let treats = parameters.singularity.as_ref().filter(|_| lists.is_none());
    let mut steps = StepList {
        search: lists.map(|regions| RegionSearch::new(&treatment, regions, &with_tools, &with)),
        singular: treats.map(|regions| SingularStep::new(&treatment, regions)),
        moves: moves.as_ref().map(MoveStep::new),
        path: path.as_ref().map(PathStep::new),
    };
    let mut sum = Sum {
        sink: changes,
        totals: ChangeTotals::default(),
        tally: Tally::default(),
        unmodelled: Unmodelled::default(),
    };
    let (lags, told) = match &parameters.servo {
        None => (None, steps.run(source, store, output, &mut |change| sum.take(change), &with)?),
        Some(servo) => {
            let mut written = BufWriter::new(store.create(Place::Written)?);
            let mut resting = BufWriter::new(store.create(Place::AllChanges)?);
            let note = &mut |change: &MotionChange| Ok(record::put(change, &mut resting)?);
            let told = steps.run(source, store, &mut written, note, &with)?;
            written.flush()?;
            resting.flush()?;
            drop((written, resting));
            let drives = Drives { machine, store, stop };
            let lags = drives.lags(to_upload(&told), program, servo)?;
            drives.join(lags.is_some(), &mut |change| sum.take(change))?;
            drives.hand_on(output)?;
            (lags, told)
        }
    };
    let done = Done { reports: steps.reports()?, told, has_errors };
    done.report(parameters, lags, sum)
}

/// The step that moves ends.
fn moves<'p>(parameters: &CompensationParameters, moving: &'p WearParameters, has_errors: bool) -> Moves<'p> {
    let recalibrates = parameters.location_errors && has_errors;
    // A machine without errors equals the nominal machine to the bit.
    let exact = |program: &ProgramSetup, real: bool| {
        let apply_errors =
            if parameters.location_errors { recalibrates && real } else { program.apply_errors };
        ProgramSetup { apply_errors, ..program.clone() }
    };
    Moves {
        parameters: moving,
        source_program: exact(&moving.program, false),
        written_program: exact(&moving.program, true),
        recalibrates,
        has_wear: parameters.wear.is_some(),
    }
}

/// The finished steps.
struct Done {
    reports: StepReports,
    /// The results of the steps, in their order.
    told: Vec<StepDone>,
    has_errors: bool,
}

/// Motions left out by the drives, if these were simulated.
type Lags = Option<Vec<LeftOut>>;

/// Runs the written program through the drives of the machine.
struct Drives<'a> {
    machine: &'a Machine,
    store: &'a dyn StepStore,
    stop: &'a Stop<'a>,
}

impl Drives<'_> {
    /// Runs the written program through the drives; `None` if this is not possible, which refuses nothing.
    fn lags(
        &self,
        lines: Vec<LineCursor<'_>>,
        program: ProgramSetup,
        servo: &ServoStep,
    ) -> Result<Lags, Fault> {
        let parameters = SimulationParameters {
            period_s: servo.period_s,
            profile: servo.profile,
            max_samples: servo.max_samples,
            ..SimulationParameters::new(servo.drives, program)
        };
        let mut out = BufWriter::new(self.store.create(Place::Lags)?);
        let mut keep = |line: u64, lag_mm: f64| Ok(record::put_lag(line, lag_mm, &mut out)?);
        let text = StoredText { store: self.store, place: Place::Written };
        let simulated = simulate_lines(self.machine, &parameters, &text, lines, Some(&mut keep), self.stop);
        out.flush()?;
        match simulated {
            Ok(simulation) => Ok(Some(simulation.left_out)),
            Err(fault @ (Fault::Cancelled | Fault::Io(_))) => Err(fault),
            Err(_) => Ok(None),
        }
    }

    fn go_on(&self) -> Result<(), Fault> {
        if (self.stop)().is_break() { Err(Fault::Cancelled) } else { Ok(()) }
    }

    /// Copies the written program to its destination.
    fn hand_on(&self, output: &mut (dyn Write + Send)) -> Result<(), Fault> {
        let mut text = self.store.open(Place::Written)?;
        let mut chunk = vec![0; CHUNK_BYTES];
        loop {
            self.go_on()?;
            let count = read_some(&mut *text, &mut chunk)?;
            if count == 0 {
                return Ok(output.flush()?);
            }
            output.write_all(&chunk[..count])?;
        }
    }

    /// Adds servo lag to the changes of the motions.
    fn join(&self, has_lags: bool, note: Note<'_, MotionChange>) -> Result<(), Fault> {
        let mut changes = BufReader::new(self.store.open(Place::AllChanges)?);
        let mut lags: Option<BufReader<Box<dyn Read + Send + '_>>> =
            if has_lags { Some(BufReader::new(self.store.open(Place::Lags)?)) } else { None };
        let mut lag = lags.as_mut().map_or(Ok(None), |lags| record::take_lag(lags))?;
        let mut motions = 0_u64;
        while let Some(mut change) = record::take(&mut changes)? {
            motions += 1;
            if motions.is_multiple_of(MOTIONS_BETWEEN_STOPS) {
                self.go_on()?;
            }
            while let (Some(lags), Some((line, lag_mm))) = (&mut lags, lag)
                && line <= change.line
            {
                if line == change.line {
                    change.error.before.servo_mm = change.error.before.servo_mm.max(lag_mm);
                    change.error.after.servo_mm = change.error.before.servo_mm;
                }
                lag = record::take_lag(lags)?;
            }
            note(&change)?;
        }
        Ok(())
    }
}

/// Number of motions joined between two checks of the stop signal.
const MOTIONS_BETWEEN_STOPS: u64 = 4096;

/// Whether the machine differs from the nominal one.
fn has_errors(machine: &Machine) -> bool {
    let axes = machine.rotary_axes();
    axes.iter().any(|axis| axis.location_error != LocationError::default())
        || *machine.squareness() != Squareness::default()
}

/// Sums up the changes of the motions.
struct Sum<'a> {
    sink: &'a mut dyn ChangeSink,
    totals: ChangeTotals,
    tally: Tally,
    unmodelled: Unmodelled,
}

impl Sum<'_> {
    fn take(&mut self, change: &MotionChange) -> Result<(), Fault> {
        self.tally.take(change);
        self.unmodelled.see(change);
        self.totals.take(change, self.sink)
    }
}

impl Done {
    fn report(
        self,
        parameters: &CompensationParameters,
        lags: Lags,
        sum: Sum<'_>,
    ) -> Result<CompensationReport, Fault> {
        let Self { reports: StepReports { singular: singularity, moved, path: cc }, told, has_errors } = self;
        let (Some(first), Some(last)) = (told.first(), told.last()) else { return Err(Fault::NothingAsked) };
        let interpolation = told.iter().find_map(|step| step.interpolation).unwrap_or(Interpolation::Machine);
        let (blocks_in, blocks_out) = (first.blocks_in, last.blocks_out);
        let (dialect, reading) = (first.dialect, first.reading.clone());
        let steps = told.iter().fold(Steps::NONE, |steps, step| steps.and(step.steps));
        let location_errors = moved
            .as_ref()
            .filter(|_| parameters.location_errors)
            .map(|moved| location_report(moved, has_errors));
        let moving = moved.map(|moved| moved.wear);
        let not_modelled: Vec<NotModelled> =
            sum.unmodelled.list(parameters, moving.as_ref(), cc.as_ref(), lags);
        Ok(CompensationReport {
            dialect,
            interpolation,
            steps,
            reading,
            blocks_in,
            blocks_out,
            singularity,
            location_errors,
            warnings: moving.as_ref().map_or_else(Vec::new, |moving| moving.warnings.clone()),
            wear: moving.filter(|_| parameters.wear.is_some()),
            cc,
            changes: sum.totals,
            budget: sum.tally.into_budget(not_modelled),
        })
    }
}

fn location_report(moved: &Moved, has_errors: bool) -> LocationErrorReport {
    let found = &moved.recalibration;
    LocationErrorReport {
        has_errors,
        motions_posted: found.recalibrated,
        motions_turned: found.turned,
        max_tip: found.tip.value,
        max_tip_line: found.tip.line,
        max_axis: found.axis.value,
        max_axis_line: found.axis.line,
        max_turn: found.turn.value,
        max_turn_line: found.turn.line,
        max_axis_left: found.left.value,
        max_axis_left_line: found.left.line,
        held_at_pole: found.held,
    }
}
