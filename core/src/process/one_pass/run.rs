//! The course of a compensation in one pass: move, compensate the contact's path, run through the drives, sum up.

use std::io::{BufReader, BufWriter, Read, Write};

use super::changes::{ChangeSink, ChangeTotals};
use super::error_budget::{NotModelled, Tally};
use super::parameters::{CcStep, CompensationParameters, ServoStep};
use super::record;
use super::report::{CompensationReport, LocationErrorReport};
use super::unmodelled::Unmodelled;
use crate::machine::{LocationError, Machine, Squareness, Tool};
use crate::process::contact_path::{CompensatedPath, Judged, PathStep, compensate_from};
use crate::process::fault::{Fault, LeftOut};
use crate::process::move_ends::{Moved, Moves, move_program};
use crate::process::pipeline::{BlockChange, Upstream};
use crate::process::set_up::ProgramSetup;
use crate::process::simulate::{SimulationParameters, simulate_lines};
use crate::process::singular::{RegionSearch, SingularityReport, treat_from};
use crate::process::text::{
    CHUNK_BYTES, LineCursor, LineMap, Place, ProgramReading, ProgramSource, Resting, Spool, Stop, read_some,
};
use crate::program::Steps;
use crate::wear::SideBySide;

/// Compensates a program for everything its parameters name, in one pass over the upload and one more over each step's
/// text, which rests in `spool`.
///
/// Ends of motions are moved first, for wear and location errors together with one rounding: rotary words of the
/// calibrated machine next to the source's, then X Y Z that put the worn cutter's contact (the tip where no contact is
/// known) where it was meant. Then the cutter-contact path between the ends is compensated, with the worn cutter on the
/// calibrated machine. Every step reads back what it wrote. `changes` gets every motion that anything happened to.
/// Memory does not grow with the program.
///
/// # Errors
/// No step named, or why the program is refused; `output` then holds text that must not be run and has to be thrown
/// away, and so has what `changes` got.
#[expect(clippy::too_many_arguments, reason = "what goes in, what comes out, and who does the work")]
pub fn compensate_program(
    machine: &Machine,
    parameters: &CompensationParameters,
    source: &dyn ProgramSource,
    spool: &dyn Spool,
    output: &mut dyn Write,
    changes: &mut dyn ChangeSink,
    parts: &dyn SideBySide,
    stop: &Stop<'_>,
) -> Result<CompensationReport, Fault> {
    if !parameters.moves() && parameters.cc.is_none() {
        return Err(Fault::NothingAsked);
    }
    let treated = treated(machine, parameters, source, spool, parts, stop)?;
    let resting = Resting { spool, place: Place::Treated };
    let (source, lines) = match &treated {
        Some(Treated { lines, .. }) => (&resting as &dyn ProgramSource, Some(lines)),
        None => (source, None),
    };
    let course =
        Course { machine, parameters, spool, parts, stop, program: parameters.real_program(), lines };
    let report = treated.as_ref().map(|treated| treated.report.clone());
    let mut sum = Sum {
        sink: changes,
        totals: ChangeTotals::default(),
        tally: Tally::default(),
        unmodelled: Unmodelled::default(),
    };
    match &parameters.servo {
        None => course
            .run(source, output, &mut |change| sum.take(change))
            .map(|done| done.report(parameters, report, None, sum)),
        Some(servo) => {
            let mut written = BufWriter::new(spool.create(Place::Written)?);
            let mut resting = BufWriter::new(spool.create(Place::Changes)?);
            let done =
                course.run(source, &mut written, &mut |change| Ok(record::put(change, &mut resting)?))?;
            written.flush()?;
            resting.flush()?;
            drop((written, resting));
            let lags = course.lags(&done, servo)?;
            course.join(lags.is_some(), &mut |change| sum.take(change))?;
            course.hand_on(output)?;
            Ok(done.report(parameters, report, lags, sum))
        }
    }
}

/// Singular regions that were treated.
struct Treated {
    report: SingularityReport,
    /// From the treated program, which rests in the spool, to the upload.
    lines: LineMap,
}

/// Treats singular regions where that is asked for.
fn treated(
    machine: &Machine,
    parameters: &CompensationParameters,
    source: &dyn ProgramSource,
    spool: &dyn Spool,
    parts: &dyn SideBySide,
    stop: &Stop<'_>,
) -> Result<Option<Treated>, Fault> {
    let treatment = parameters.singularity.filter(|_| parameters.regions_to_list().is_none());
    let Some(singularity) = treatment else { return Ok(None) };
    let mut text = BufWriter::new(spool.create(Place::Treated)?);
    let (cc, source) = (parameters.treatment(), Upstream::upload(source));
    let (report, lines) = treat_from(machine, &cc, &singularity, source, &mut text, parts, stop)?;
    text.flush()?;
    Ok(Some(Treated { report, lines }))
}

/// What every step shares.
struct Course<'a> {
    machine: &'a Machine,
    parameters: &'a CompensationParameters,
    spool: &'a dyn Spool,
    parts: &'a dyn SideBySide,
    stop: &'a Stop<'a>,
    /// Of the written program.
    program: ProgramSetup,
    /// From the program that the steps begin with to the upload, where it is not the upload itself.
    lines: Option<&'a LineMap>,
}

/// Takes what became of a motion.
type Note<'n> = &'n mut dyn FnMut(&BlockChange) -> Result<(), Fault>;

/// The steps done.
struct Done {
    moved: Option<Moved>,
    path: Option<CompensatedPath>,
    has_errors: bool,
    /// Of the written program.
    program: ProgramSetup,
}

/// What the drives left out, once they were run through.
type Lags = Option<Vec<LeftOut>>;

impl Course<'_> {
    /// The program that the steps begin with.
    fn upstream<'s>(&'s self, source: &'s dyn ProgramSource) -> Upstream<'s> {
        Upstream { source, lines: self.lines.iter().copied().map(LineCursor::new).collect() }
    }

    /// The steps that write.
    fn run(&self, source: &dyn ProgramSource, output: &mut dyn Write, note: Note<'_>) -> Result<Done, Fault> {
        let has_errors = has_errors(self.machine);
        let Some(step) = &self.parameters.cc else {
            let (moved, program) = self.move_ends(source, output, has_errors, note)?;
            return Ok(Done { moved: Some(moved), path: None, has_errors, program });
        };
        if !self.parameters.moves() {
            let bare =
                &mut |judged: &Judged| note(&with_path(BlockChange::none(judged.line, judged.kind), judged));
            let cc = self.parameters.contact_path(step, self.program.clone());
            let step = PathStep { parameters: &cc, regions: self.parameters.regions_to_list() };
            let source = self.upstream(source);
            let path = compensate_from(self.machine, &step, source, output, bare, self.parts, self.stop)?;
            return Ok(Done { moved: None, path: Some(path), has_errors, program: self.program.clone() });
        }
        let mut text = BufWriter::new(self.spool.create(Place::Moved)?);
        let mut resting = BufWriter::new(self.spool.create(Place::Moves)?);
        let keep = &mut |change: &BlockChange| Ok(record::put(change, &mut resting)?);
        let (moved, program) = self.move_ends(source, &mut text, has_errors, keep)?;
        text.flush()?;
        resting.flush()?;
        drop((text, resting));
        let path = self.contact_path(step, &moved, program.clone(), output, note)?;
        Ok(Done { moved: Some(moved), path: Some(path), has_errors, program })
    }

    /// The step that moves ends, and the set-up of what it writes.
    fn move_ends(
        &self,
        source: &dyn ProgramSource,
        output: &mut dyn Write,
        has_errors: bool,
        note: Note<'_>,
    ) -> Result<(Moved, ProgramSetup), Fault> {
        let parameters = self.parameters;
        let cutter = parameters.cc.as_ref().and_then(|step| step.tool).unwrap_or(Tool::UNIT_BALL);
        let moving = parameters.moving(cutter);
        let posts = parameters.location_errors && has_errors;
        // A machine without errors is the nominal one, to the bit.
        let exact = |program: &ProgramSetup, real: bool| {
            let apply_errors = if parameters.location_errors { posts && real } else { program.apply_errors };
            ProgramSetup { apply_errors, ..program.clone() }
        };
        let cc = parameters.treatment();
        let moves = Moves {
            parameters: &moving,
            regions: parameters.regions_to_list().map(|zone| RegionSearch { cc: &cc, zone }),
            source_program: exact(&moving.program, false),
            written_program: exact(&moving.program, true),
            posts,
            has_wear: parameters.wear.is_some(),
        };
        let source = self.upstream(source);
        let moved = move_program(self.machine, &moves, source, output, note, self.parts, self.stop)?;
        Ok((moved, moves.program_behind()))
    }

    /// The step for the contact's path, from the moved program.
    fn contact_path(
        &self,
        step: &CcStep,
        moved: &Moved,
        program: ProgramSetup,
        output: &mut dyn Write,
        note: Note<'_>,
    ) -> Result<CompensatedPath, Fault> {
        let mut moves = BufReader::new(self.spool.open(Place::Moves)?);
        let join = &mut |judged: &Judged| {
            let change = record::take(&mut moves)?.filter(|change| change.line == judged.line);
            let what = "a motion of the moved program is another one";
            let change = change.ok_or(Fault::VerificationFailed { line: judged.line, what })?;
            note(&with_path(change, judged))
        };
        let cc = self.parameters.contact_path(step, program);
        let text = Resting { spool: self.spool, place: Place::Moved };
        let maps = [Some(&moved.lines), self.lines].into_iter().flatten();
        let source = Upstream { source: &text, lines: maps.map(LineCursor::new).collect() };
        let step = PathStep { parameters: &cc, regions: None };
        compensate_from(self.machine, &step, source, output, join, self.parts, self.stop)
    }

    /// Runs the written program through the drives; `None` where that cannot be done, which refuses nothing.
    fn lags(&self, done: &Done, servo: &ServoStep) -> Result<Lags, Fault> {
        let parameters = SimulationParameters {
            period_s: servo.period_s,
            profile: servo.profile,
            max_samples: servo.max_samples,
            ..SimulationParameters::new(servo.drives, done.program.clone())
        };
        let mut out = BufWriter::new(self.spool.create(Place::Lags)?);
        let mut keep = |line: u64, lag_mm: f64| Ok(record::put_lag(line, lag_mm, &mut out)?);
        let text = Resting { spool: self.spool, place: Place::Written };
        let simulated = simulate_lines(
            self.machine,
            &parameters,
            &text,
            done.to_upload(self.lines),
            Some(&mut keep),
            self.stop,
        );
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

    /// The written program, to where it is wanted.
    fn hand_on(&self, output: &mut dyn Write) -> Result<(), Fault> {
        let mut text = self.spool.open(Place::Written)?;
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

    /// Puts servo lag to what became of the motions.
    fn join(&self, has_lags: bool, note: Note<'_>) -> Result<(), Fault> {
        let mut changes = BufReader::new(self.spool.open(Place::Changes)?);
        let mut lags: Option<BufReader<Box<dyn Read + Send + '_>>> =
            if has_lags { Some(BufReader::new(self.spool.open(Place::Lags)?)) } else { None };
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

/// How many motions are joined between two looks at the stop signal.
const MOTIONS_BETWEEN_STOPS: u64 = 4096;

/// What the step for the contact's path adds.
fn with_path(mut change: BlockChange, judged: &Judged) -> BlockChange {
    let [before_mm, after_mm] = judged.deviation_mm;
    (change.cc_mm, change.blocks_out) = (judged.correction_mm, judged.parts);
    change.error.before.interpolation_mm = before_mm;
    change.error.after.interpolation_mm = after_mm;
    change
}

/// Whether the machine is not the nominal one.
fn has_errors(machine: &Machine) -> bool {
    let axes = machine.rotary_axes();
    axes.iter().any(|axis| axis.location_error != LocationError::default())
        || *machine.squareness() != Squareness::default()
}

/// Sums up what became of the motions.
struct Sum<'a> {
    sink: &'a mut dyn ChangeSink,
    totals: ChangeTotals,
    tally: Tally,
    unmodelled: Unmodelled,
}

impl Sum<'_> {
    fn take(&mut self, change: &BlockChange) -> Result<(), Fault> {
        self.tally.take(change);
        self.unmodelled.see(change);
        self.totals.take(change, self.sink)
    }
}

impl Done {
    /// From lines written to those of the upload.
    fn to_upload<'s>(&'s self, first: Option<&'s LineMap>) -> Vec<LineCursor<'s>> {
        let maps =
            self.path.iter().map(|path| &path.lines).chain(self.moved.iter().map(|moved| &moved.lines));
        maps.chain(first).map(LineCursor::new).collect()
    }

    fn report(
        self,
        parameters: &CompensationParameters,
        singularity: Option<SingularityReport>,
        lags: Lags,
        sum: Sum<'_>,
    ) -> CompensationReport {
        let Self { moved, path, has_errors, .. } = self;
        let (cc, regions) = path.map(|path| (path.cc, path.regions)).unzip();
        let of_moved = moved.as_ref().and_then(|moved| moved.regions.clone());
        let singularity = singularity.or(of_moved).or(regions.flatten());
        let location_errors = moved
            .as_ref()
            .filter(|_| parameters.location_errors)
            .map(|moved| location_report(moved, has_errors));
        let moving = moved.map(|moved| moved.wear);
        let not_modelled: Vec<NotModelled> =
            sum.unmodelled.list(parameters, moving.as_ref(), cc.as_ref(), lags);
        let (dialect, interpolation, blocks_in) = match (&moving, &cc) {
            (Some(moving), _) => (moving.dialect, moving.interpolation, moving.blocks_in),
            (None, Some(cc)) => (cc.dialect, cc.interpolation, cc.blocks_in),
            (None, None) => (crate::program::Dialect::Iso, crate::motion::Interpolation::Machine, 0),
        };
        let blocks_in = singularity.as_ref().map_or(blocks_in, |report| report.blocks_in);
        let blocks_out = match (&moving, &cc) {
            (_, Some(cc)) => cc.blocks_out,
            (Some(moving), None) => moving.blocks_out,
            (None, None) => 0,
        };
        let steps = singularity.as_ref().map_or(Steps::NONE, SingularityReport::steps);
        let steps = steps.and(moving.as_ref().map_or(Steps::NONE, |moving| moving.steps));
        let steps = steps.and(cc.as_ref().map_or(Steps::NONE, |cc| cc.steps));
        let reading = match (&moving, &cc) {
            (Some(moving), _) => moving.reading.clone(),
            (None, Some(cc)) => cc.reading.clone(),
            (None, None) => ProgramReading::default(),
        };
        CompensationReport {
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
        }
    }
}

fn location_report(moved: &Moved, has_errors: bool) -> LocationErrorReport {
    let posting = &moved.posting;
    LocationErrorReport {
        has_errors,
        motions_posted: posting.posted,
        motions_turned: posting.turned,
        max_tip: posting.tip.value,
        max_tip_line: posting.tip.line,
        max_axis: posting.axis.value,
        max_axis_line: posting.axis.line,
        max_turn: posting.turn.value,
        max_turn_line: posting.turn.line,
        max_axis_left: posting.left.value,
        max_axis_left_line: posting.left.line,
        held_at_pole: posting.held,
    }
}
