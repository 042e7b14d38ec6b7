//! The stamp of a changed program: one comment that states what was done to it.

use std::fs::File;
use std::io::{self, BufWriter, Read, Write};

use super::workplace::{Finished, Workplace, written};
use super::{CompensatorFault, InputFile, JobFault, MachineUsed};
use crate::process::ProgramSource;
use crate::program::{Dialect, Stamp, Steps, borne_by, place_stamp};
use crate::store::{Draft, sha256_hex};
use crate::wire::{JobOperation, Provenance, ResolvedInputs, StampForm, StepName};

/// Digits of a digest in a stamp.
const DIGITS: usize = 16;
/// The part of a program in which the place of its stamp is searched \[bytes\].
const HEAD_BYTES: u64 = 64 * 1024;

/// The steps that a program's stamps name, as far as stamps are written: in its head.
///
/// # Errors
/// The program cannot be read.
pub(super) fn stamped_steps(program: &InputFile) -> io::Result<Steps> {
    let mut head = Vec::new();
    program.open()?.take(HEAD_BYTES).read_to_end(&mut head)?;
    Ok(borne_by(&head).steps)
}

/// A program that is about to be sent.
pub(super) struct Leaving<'a> {
    pub(super) on: &'a MachineUsed,
    pub(super) operation: JobOperation,
    /// Parameters with their defaults filled in.
    pub(super) parameters: &'a serde_json::Value,
    pub(super) resolved: ResolvedInputs,
    pub(super) form: StampForm,
    pub(super) dialect: Dialect,
    pub(super) steps: Steps,
}

impl Leaving<'_> {
    /// The result of the work: the program with its stamp, and the report that `report` makes of the program's origin
    /// and the inputs. A program that nothing changed stays as it came.
    pub(super) fn finish<R: serde::Serialize>(
        self,
        output: BufWriter<Draft>,
        place: &Workplace<'_>,
        report: impl FnOnce(Provenance, ResolvedInputs) -> R,
    ) -> Result<Finished, JobFault> {
        let output = written(output)?;
        let output = if self.steps.is_empty() || self.form == StampForm::None {
            output
        } else {
            self.with_stamp(place.program, output, place)?
        };
        let provenance = Provenance {
            steps: Some(StepName::all_of(self.steps)),
            ..self.on.provenance(place.program, &output)
        };
        let report = report(provenance, self.resolved);
        Ok(Finished { output: Some(output), steps: Some(self.steps), ..Finished::of(&report)? })
    }

    fn with_stamp(
        &self,
        program: &InputFile,
        output: Draft,
        place: &Workplace<'_>,
    ) -> Result<Draft, JobFault> {
        let mut file = File::open(output.path()).map_err(CompensatorFault::Io)?;
        let mut head = Vec::new();
        (&mut file).take(HEAD_BYTES).read_to_end(&mut head).map_err(CompensatorFault::Io)?;
        let stamp = self.stamp(program)?;
        let Some(stands) = place_stamp(&head, self.dialect, &stamp) else { return Ok(output) };
        let mut stamped = place.output()?;
        let (before, after) = head.split_at(stands.offset.min(head.len()));
        let mut write = || -> io::Result<()> {
            stamped.write_all(before)?;
            stamped.write_all(&stands.line)?;
            stamped.write_all(after)?;
            io::copy(&mut file, &mut stamped).map(|_bytes| ())
        };
        write().map_err(CompensatorFault::Io)?;
        written(stamped)
    }

    fn stamp(&self, program: &InputFile) -> Result<Stamp, JobFault> {
        // The digest covers the resolved values, not the lines that use them.
        let said = serde_json::to_string(&(self.operation, self.parameters, self.resolved.values()))?;
        let digest = |sha256: &str| sha256.chars().take(DIGITS).collect();
        Ok(Stamp {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            operation: self.operation.as_str().to_owned(),
            steps: self.steps,
            machine: self.on.machine_id.clone(),
            revision: self.on.revision,
            tool: self.resolved.only_tool(),
            source: digest(&program.sha256),
            parameters: digest(&sha256_hex(said.as_bytes())),
        })
    }
}
