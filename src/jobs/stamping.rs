//! The stamp of a changed program: one comment that states what was done to it.

use std::io::{self, BufWriter, Read, Write};

use super::archive_of_files::archive_with;
use super::program_files::ProgramFilesFault;
use super::workplace::{Finished, Workplace, written};
use super::{CompensatorFault, InputFile, JobFault, MachineUsed};
use crate::process::{Interpretation, ProgramReading, ProgramSetup, ProgramSource, interpret_program};
use crate::program::{Dialect, Stamp, StampPlace, Steps, borne_by, place_stamp};
use crate::store::{Draft, sha256_hex};
use crate::wire::{JobOperation, Provenance, ResolvedInputs, StampForm, StepName};

/// Digits of a digest in a stamp.
const DIGITS: usize = 16;
/// The head of a program, in which the place of its stamp is searched \[bytes\].
const STAMP_HEAD_BYTES: u64 = 64 * 1024;

/// The steps that a program's stamps name, as far as stamps are written: in its head.
///
/// # Errors
/// The program cannot be read.
pub(super) fn stamped_steps(program: &InputFile) -> io::Result<Steps> {
    let mut head = Vec::new();
    program.open()?.take(STAMP_HEAD_BYTES).read_to_end(&mut head)?;
    Ok(borne_by(&head).steps)
}

/// How the programs of one piece of work are stamped.
pub(super) struct Stamping<'a> {
    pub(super) on: &'a MachineUsed,
    pub(super) operation: JobOperation,
    /// Parameters with their defaults filled in.
    pub(super) parameters: &'a serde_json::Value,
    pub(super) form: StampForm,
}

/// The inputs that follow from how a program was read.
pub(super) type Resolve<'r> = &'r dyn Fn(&ProgramReading) -> Result<ResolvedInputs, CompensatorFault>;

/// A program that was written, and that is about to be sent.
pub(super) struct Leaving {
    pub(super) output: StampedOutput,
    pub(super) resolved: ResolvedInputs,
    pub(super) dialect: Dialect,
    /// The steps that changed something.
    pub(super) steps: Steps,
}

impl Stamping<'_> {
    /// A new output. If the text is longer than the head, the stamp is needed before the work ends. The expected stamp
    /// follows from `steps`, the steps asked for, and from the head of the program.
    pub(super) fn output(
        &self,
        place: &Workplace<'_>,
        steps: Steps,
        setup: &ProgramSetup,
        resolve: Resolve<'_>,
    ) -> Result<StampedOutput, JobFault> {
        let is_long = self.form != StampForm::None && place.program.length > STAMP_HEAD_BYTES;
        let expected = if is_long { self.expected(place, steps, setup, resolve)? } else { None };
        Ok(StampedOutput { draft: place.output()?, head: Vec::new(), expected, state: HeadState::Waits })
    }

    /// The stamp that the whole program will probably get, as far as its head can be understood.
    fn expected(
        &self,
        place: &Workplace<'_>,
        steps: Steps,
        setup: &ProgramSetup,
        resolve: Resolve<'_>,
    ) -> Result<Option<(Dialect, Stamp)>, JobFault> {
        let mut head = Vec::new();
        let opened = place.program.open().and_then(|text| text.take(STAMP_HEAD_BYTES).read_to_end(&mut head));
        opened.map_err(CompensatorFault::Io)?;
        head.truncate(memchr::memrchr(b'\n', &head).map_or(0, |end| end + 1));
        let seen = interpret_program(&self.on.machine, setup, &head, &mut |_| Ok(()), place.stop);
        // A head that cannot be interpreted alone is not a fault of the program.
        let Ok(Interpretation { dialect, reading, .. }) = seen else { return Ok(None) };
        let Ok(resolved) = resolve(&reading) else { return Ok(None) };
        Ok(Some((dialect, self.stamp(place.program, steps, &resolved)?)))
    }

    /// The result of the work: the program with its stamp, and the report that `report` makes of the program's origin
    /// and the inputs. A program that nothing changed stays as it came.
    pub(super) fn finish<R: serde::Serialize>(
        &self,
        leaving: Leaving,
        place: &Workplace<'_>,
        report: impl FnOnce(Provenance, ResolvedInputs) -> R,
    ) -> Result<Finished, JobFault> {
        let Leaving { output, resolved, dialect, steps } = leaving;
        let stamp = if steps.is_empty() || self.form == StampForm::None {
            None
        } else {
            Some(self.stamp(place.program, steps, &resolved)?)
        };
        let mut output = output.with_stamp(dialect, stamp.as_ref())?;
        if place.program.is_archive() {
            let archive = archive_with(place.spool, place.program, &output);
            output = archive.map_err(|fault| match fault {
                ProgramFilesFault::Write(fault) => JobFault::from(CompensatorFault::Io(fault)),
                ProgramFilesFault::File(fault) => fault.into(),
                fault => CompensatorFault::Io(io::Error::other(fault)).into(),
            })?;
        }
        let provenance =
            Provenance { steps: Some(StepName::all_of(steps)), ..self.on.provenance(place.program, &output) };
        let report = report(provenance, resolved);
        Ok(Finished { output: Some(output), steps: Some(steps), ..Finished::of(&report)? })
    }

    fn stamp(&self, program: &InputFile, steps: Steps, resolved: &ResolvedInputs) -> Result<Stamp, JobFault> {
        // The digest covers the resolved values, not the lines that use them.
        let said = serde_json::to_string(&(self.operation, self.parameters, resolved.values()))?;
        let digest = |sha256: &str| sha256.chars().take(DIGITS).collect();
        Ok(Stamp {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            operation: self.operation.as_str().to_owned(),
            steps,
            machine: self.on.machine_id.clone(),
            revision: self.on.revision,
            tool: resolved.only_tool(),
            source: digest(&program.sha256),
            parameters: digest(&sha256_hex(said.as_bytes())),
        })
    }
}

/// The output of a program that gets a stamp. Its head waits in memory until it is complete. It then leaves with the
/// expected stamp. If the end of the work shows another stamp, the rest of the text moves within the file.
pub(super) struct StampedOutput {
    draft: BufWriter<Draft>,
    /// The first bytes of the program, without a stamp: 64 KiB, or all of them.
    head: Vec<u8>,
    expected: Option<(Dialect, Stamp)>,
    state: HeadState,
}

/// Whether the head of a program has left.
enum HeadState {
    /// It waits to be complete.
    Waits,
    /// It has left with this stamp, or without one.
    HasLeft(Option<StampPlace>),
}

impl StampedOutput {
    /// Writes the head with its stamp.
    fn write_head(&mut self, placed: Option<StampPlace>) -> io::Result<()> {
        write_with_stamp(&self.head, placed.as_ref(), &mut self.draft)?;
        self.state = HeadState::HasLeft(placed);
        Ok(())
    }

    /// The whole text with this stamp, or without one.
    fn with_stamp(mut self, dialect: Dialect, stamp: Option<&Stamp>) -> Result<Draft, JobFault> {
        let placed = stamp.and_then(|stamp| place_stamp(&self.head, dialect, stamp));
        match std::mem::replace(&mut self.state, HeadState::Waits) {
            HeadState::Waits => {
                self.write_head(placed).map_err(CompensatorFault::Io)?;
                written(self.draft)
            }
            HeadState::HasLeft(expected) if expected == placed => written(self.draft),
            HeadState::HasLeft(other) => {
                let before = self.head.len() + other.map_or(0, |placed| placed.line.len());
                let mut head = Vec::new();
                let replaced = written(self.draft)?;
                let with_head = || {
                    write_with_stamp(&self.head, placed.as_ref(), &mut head)?;
                    replaced.with_head(&head, before as u64)
                };
                Ok(with_head().map_err(CompensatorFault::Io)?)
            }
        }
    }
}

fn write_with_stamp(head: &[u8], placed: Option<&StampPlace>, out: &mut impl Write) -> io::Result<()> {
    let Some(StampPlace { offset, line }) = placed else { return out.write_all(head) };
    let (before, after) = head.split_at((*offset).min(head.len()));
    out.write_all(before)?;
    out.write_all(line)?;
    out.write_all(after)
}

impl Write for StampedOutput {
    fn write(&mut self, text: &[u8]) -> io::Result<usize> {
        if matches!(self.state, HeadState::HasLeft(_)) {
            return self.draft.write(text);
        }
        let room = usize::try_from(STAMP_HEAD_BYTES).unwrap_or(usize::MAX) - self.head.len();
        let taken = &text[..room.min(text.len())];
        self.head.extend_from_slice(taken);
        if taken.len() == room {
            let expected = self.expected.as_ref();
            let placed = expected.and_then(|(dialect, stamp)| place_stamp(&self.head, *dialect, stamp));
            self.write_head(placed)?;
        }
        Ok(taken.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.draft.flush()
    }
}
