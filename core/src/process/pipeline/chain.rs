//! The steps of a program, one after the other. Each step reads the program that the previous step wrote.

use std::io::{BufReader, BufWriter, Read, Write};

use super::drive::{Look, Note, Upstream};
use super::motion_change::MotionChange;
use super::read_back::failed;
use super::record;
use super::resources::Resources;
use crate::motion::Interpolation;
use crate::process::fault::Fault;
use crate::process::text::{
    LineCursor, LineMap, Passages, Place, ProgramReading, ProgramSource, StepStore, StoredText,
};
use crate::program::{Dialect, Steps};

/// A step of a chain. It keeps its own report.
pub(in crate::process) trait Step {
    /// Takes the program of `upstream` through the step. `note` gets the changes of every motion, in program order,
    /// after the written motion was read back.
    ///
    /// # Errors
    /// Why the program is refused; `output` then holds text that must not be run.
    fn run(
        &mut self,
        upstream: Upstream<'_>,
        look: Option<&mut dyn Look>,
        output: &mut (dyn Write + Send),
        note: Note<'_, MotionChange>,
        with: &Resources<'_>,
    ) -> Result<StepDone, Fault>;

    /// Whether `note` gets every motion, with or without changes.
    fn notes_motions(&self) -> bool;
}

/// The result that every step returns.
#[derive(Debug)]
pub(in crate::process) struct StepDone {
    /// The lines that the step inserted.
    pub(in crate::process) lines: LineMap,
    /// The dialect read and written.
    pub(in crate::process) dialect: Dialect,
    /// The interpolation mode of the motions at feed; `None` if the step does not know it.
    pub(in crate::process) interpolation: Option<Interpolation>,
    /// The steps that changed something.
    pub(in crate::process) steps: Steps,
    /// How the program was read.
    pub(in crate::process) reading: ProgramReading,
    /// Blocks read.
    pub(in crate::process) blocks_in: u64,
    /// Blocks written.
    pub(in crate::process) blocks_out: u64,
}

impl StepDone {
    /// The result of a step that read `passages` to their end and whose written text has `blocks_out` blocks.
    pub(in crate::process) fn new(
        passages: &Passages<'_>,
        lines: LineMap,
        interpolation: Option<Interpolation>,
        steps: Steps,
        blocks_out: u64,
    ) -> Self {
        Self {
            lines,
            dialect: passages.dialect(),
            interpolation,
            steps,
            reading: passages.reading(),
            blocks_in: passages.blocks,
            blocks_out,
        }
    }
}

/// The report of a step, available after a program has gone through.
///
/// # Errors
/// No program has gone through.
pub(in crate::process) fn reported<R>(report: Option<R>) -> Result<R, Fault> {
    report.ok_or_else(|| failed(0, "a step did not run"))
}

/// Takes a program through these steps to `output`. Between two steps it is stored in `store`. `look` watches the
/// first reading. `note` gets every motion with the changes of all steps that note motions. Returns the
/// results of the steps, in their order.
///
/// # Errors
/// Why a step refuses the program; `output` then holds text that must not be run.
pub(in crate::process) fn run_chain(
    steps: &mut [&mut dyn Step],
    mut look: Option<&mut dyn Look>,
    upload: &dyn ProgramSource,
    store: &dyn StepStore,
    output: &mut (dyn Write + Send),
    note: Note<'_, MotionChange>,
    with: &Resources<'_>,
) -> Result<Vec<StepDone>, Fault> {
    let mut done: Vec<StepDone> = Vec::new();
    let mut resting: Option<StoredText<'_>> = None;
    let mut noted: Option<Place> = None;
    let count = steps.len();
    for (index, step) in steps.iter_mut().enumerate() {
        let source = resting.as_ref().map_or(upload, |text| text as &dyn ProgramSource);
        let upstream = Upstream { source, lines: to_upload(&done) };
        let look = look.take();
        let mut earlier = noted.map(|place| store.open(place).map(BufReader::new)).transpose()?;
        let told = if index + 1 == count && earlier.is_none() {
            // Nothing to join: a motion's changes are handed on without a copy.
            step.run(upstream, look, output, &mut *note, with)?
        } else if index + 1 == count {
            let note = &mut |change: &MotionChange| note(&joined(earlier.as_mut(), change)?);
            let told = step.run(upstream, look, output, note, with)?;
            is_used_up(earlier.as_mut().filter(|_| step.notes_motions()))?;
            told
        } else {
            // A step never writes to the place from which it reads.
            let text_in = match &resting {
                Some(text) if text.place == Place::OneText => Place::OtherText,
                _ => Place::OneText,
            };
            let notes_in = match noted {
                Some(Place::OneChanges) => Place::OtherChanges,
                _ => Place::OneChanges,
            };
            let notes_in = step.notes_motions().then_some(notes_in);
            let mut text = BufWriter::new(store.create(text_in)?);
            let mut notes = notes_in.map(|place| store.create(place).map(BufWriter::new)).transpose()?;
            let note = &mut |change: &MotionChange| match &mut notes {
                Some(notes) => Ok(record::put(&joined(earlier.as_mut(), change)?, notes)?),
                None => Ok(()),
            };
            let told = step.run(upstream, look, &mut text, note, with)?;
            is_used_up(earlier.as_mut().filter(|_| notes_in.is_some()))?;
            text.flush()?;
            if let Some(notes) = &mut notes {
                notes.flush()?;
            }
            drop(text);
            noted = notes_in.or(noted);
            resting = Some(StoredText { store, place: text_in });
            told
        };
        done.push(told);
    }
    Ok(done)
}

/// The way from the lines that these steps wrote back to those of the upload: the last step first.
pub(in crate::process) fn to_upload(done: &[StepDone]) -> Vec<LineCursor<'_>> {
    done.iter().rev().map(|step| LineCursor::new(&step.lines)).collect()
}

/// The changes of a motion together with those of earlier steps.
fn joined(earlier: Option<&mut impl Read>, change: &MotionChange) -> Result<MotionChange, Fault> {
    let Some(earlier) = earlier else { return Ok(*change) };
    let before = record::take(earlier)?.filter(|before| before.line == change.line);
    let what = "a motion does not match its record of the steps before";
    before.map(|before| before.and(change)).ok_or_else(|| failed(change.line, what))
}

/// Checks that every motion of the earlier steps was joined.
fn is_used_up(earlier: Option<&mut impl Read>) -> Result<(), Fault> {
    match earlier.map(|earlier| record::take(earlier)).transpose()?.flatten() {
        Some(left) => Err(failed(left.line, "a motion of an earlier step is missing")),
        None => Ok(()),
    }
}
