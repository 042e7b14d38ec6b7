//! Programs whose loops and calls are written out before a step follows them.

use std::io::BufWriter;

use super::refusals::in_words_of_the_wire;
use super::{InputFile, JobFault, Spool};
use crate::machine::Machine;
use crate::process::{self, ProgramSetup, Stop, WarningKind, WrittenOut, write_out};
use crate::program::Dialect;
use crate::store::Draft;
use crate::wire::Warning;

/// A program whose loops and calls are written out.
pub(super) struct Flattened {
    /// The program. Its digest is that of the upload.
    pub(super) program: InputFile,
    done: WrittenOut,
    /// It keeps the bytes counted for their owner.
    _draft: Draft,
}

impl Flattened {
    /// The program with its loops and calls written out; `None` if that is not asked for, or if it has none.
    ///
    /// # Errors
    /// The program cannot be written out.
    pub(super) fn of(
        is_asked: bool,
        machine: &Machine,
        set_up: &ProgramSetup,
        source: &InputFile,
        spool: &Spool,
        stop: &Stop<'_>,
    ) -> Result<Option<Self>, JobFault> {
        if !is_asked {
            return Ok(None);
        }
        let mut draft = None;
        let read = |out: BufWriter<Draft>| {
            let made = out.into_inner().map_err(std::io::IntoInnerError::into_error)?;
            let program = source.written_out(&made)?;
            draft = Some(made);
            Ok(program)
        };
        let out = BufWriter::with_capacity(GATHERED, spool.result()?.within(MOST_BYTES));
        let made = write_out(machine, set_up, source, out, read, stop).map_err(in_words_of_the_wire)?;
        let flattened = made.zip(draft);
        Ok(flattened.map(|((done, program), draft)| Self { program, done, _draft: draft }))
    }

    /// The dialect of the program, for the steps that follow it.
    pub(super) fn dialect(&self) -> Dialect {
        self.done.dialect
    }

    /// What the caller should know of it.
    pub(super) fn warnings(&self) -> impl Iterator<Item = Warning> {
        let warning = |kind, count, line| {
            let (worst_line, max_distance_mm, min_time_s, reason) = (None, None, None, None);
            process::Warning { kind, count, line, worst_line, max_distance_mm, min_time_s, reason }
        };
        let WrittenOut { assignments, first_assignment, files_never_called, .. } = self.done;
        let idle = warning(WarningKind::FileNotCalled, files_never_called, None);
        let written_out = warning(WarningKind::WrittenOut, assignments, first_assignment);
        [Some(written_out), (files_never_called > 0).then_some(idle)]
            .into_iter()
            .flatten()
            .map(|warning| Warning::from(&warning))
    }
}

/// The longest program that is written out: as many blocks as a run may have, of 256 bytes each \[bytes\].
const MOST_BYTES: u64 = 64_000_000;
/// Bytes that are collected before they are written.
const GATHERED: usize = 1 << 18;
