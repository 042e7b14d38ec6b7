//! What work on a program is done with, and what it makes.

use std::io::BufWriter;

use super::flattening::Flattened;
use super::{CompensatorFault, InputFile, JobFault, Spool, Threads};
use crate::process::{Stop, SurveyExtent};
use crate::program::Steps;
use crate::store::Draft;

/// The inputs and means of the work.
#[derive(Clone, Copy)]
pub struct Workplace<'a> {
    /// The program.
    pub program: &'a InputFile,
    /// The part's surface, if one was uploaded.
    pub surface: Option<&'a InputFile>,
    /// Where results go.
    pub spool: &'a Spool,
    /// Threads for work in parts.
    pub threads: &'a Threads,
    /// Breaks when nobody needs the result any more.
    pub stop: &'a Stop<'a>,
    /// How much of the program is surveyed before a step follows it. [`ProgramWork::run`](super::ProgramWork::run)
    /// decides.
    pub survey: SurveyExtent,
}

impl std::fmt::Debug for Workplace<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Workplace").field("program", &self.program).finish_non_exhaustive()
    }
}

/// Bytes that are collected before a result is written.
const GATHERED: usize = 1 << 18;

impl<'a> Workplace<'a> {
    /// The place of the work on a program.
    #[must_use]
    pub fn new(
        program: &'a InputFile,
        surface: Option<&'a InputFile>,
        spool: &'a Spool,
        threads: &'a Threads,
        stop: &'a Stop<'a>,
    ) -> Self {
        Self { program, surface, spool, threads, stop, survey: SurveyExtent::Whole }
    }

    /// The same place with the program whose loops and calls are written out, if there is one.
    pub(super) fn with(self, flattened: Option<&'a Flattened>) -> Self {
        Self { program: flattened.map_or(self.program, |flattened| &flattened.program), ..self }
    }

    /// A new result.
    pub(super) fn output(&self) -> Result<BufWriter<Draft>, JobFault> {
        Ok(BufWriter::with_capacity(GATHERED, self.spool.result()?))
    }
}

/// A result after its last bytes.
pub(super) fn written(output: BufWriter<Draft>) -> Result<Draft, JobFault> {
    output.into_inner().map_err(|fault| CompensatorFault::Io(fault.into_error()).into())
}

/// The result of the work.
#[derive(Debug)]
pub struct Finished {
    /// The report, as JSON text.
    pub report: String,
    /// A program or a table, if the operation makes one.
    pub output: Option<Draft>,
    /// The table of changes, if the operation makes one.
    pub changes: Option<Draft>,
    /// All steps behind the written program, if the operation writes one: those of this work, and those that its input
    /// was known to have. So a step is known however many jobs ago it was done.
    pub steps: Option<Steps>,
    /// Number of motions that were checked in a compensated program.
    pub motions_checked: Option<u64>,
}

impl Finished {
    /// A report without files.
    pub(super) fn of(report: &impl serde::Serialize) -> Result<Self, JobFault> {
        let report = serde_json::to_string(report)?;
        Ok(Self { report, output: None, changes: None, steps: None, motions_checked: None })
    }
}
