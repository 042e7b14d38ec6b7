//! The interpretation of a program: read in the pool, its answer in a file of its own until it is sent.

use std::fs::File;
use std::io::{self, BufWriter, Write};

use super::refusals::in_words_of_the_wire;
use super::workplace::written;
use super::{CompensatorFault, Compute, Cost, InputFile, JobFault, MachineUsed, Means, Spool};
use crate::motion::ToolKey;
use crate::process::{self, Fault, Interpretation, Interpreted, ProgramSetup, Stop};
use crate::program::PlaceInFile;
use crate::store::Draft;
use crate::wire::{
    FaultList, InterpretationEnd, InterpretationParameters, InterpretationTable, InterpretedMotionDoc,
    LeftAloneDoc, fault_of_table,
};

/// The form of the answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InterpretationForm {
    /// Motions, motions left unchanged, and warnings.
    Json,
    /// Only the motions.
    Table,
}

/// Interprets a program; the answer is complete before its first byte is sent. The number is the count of motions
/// that are left unchanged.
///
/// # Errors
/// Parameters that do not fit, a program that cannot be read, work that would cost too much.
pub async fn interpret(
    compute: &Compute,
    spool: &Spool,
    means: &Means,
    on: MachineUsed,
    parameters: InterpretationParameters,
    program: Draft,
    form: InterpretationForm,
) -> Result<(Draft, u64), JobFault> {
    let statements = parameters.statements();
    let mut faults = FaultList::default();
    statements.check(&mut faults);
    faults.into_result().map_err(JobFault::Parameters)?;
    let set_up = on.program(&statements, false).map_err(JobFault::Parameters)?;
    Cost::of_program_reading(program.length()).within(means.max_cost_s)?;
    let spool = spool.clone();
    let work = move |stop: &Stop<'_>| -> Result<(Draft, u64), JobFault> {
        let source = InputFile::of(&program).map_err(CompensatorFault::Io)?;
        let dialect = set_up.dialect.or(source.dialect_of_files());
        let set_up = ProgramSetup { dialect, ..set_up.clone() };
        let answer = Answering { on: &on, parameters: &parameters, set_up: &set_up, spool: &spool };
        match form {
            InterpretationForm::Json => answer.json(&source, stop),
            InterpretationForm::Table => answer.table(&source, stop),
        }
    };
    compute.run_in_parts(move |_threads, stop| work(stop)).await?
}

struct Answering<'a> {
    on: &'a MachineUsed,
    parameters: &'a InterpretationParameters,
    set_up: &'a ProgramSetup,
    spool: &'a Spool,
}

/// Bytes that are collected before they are written.
const GATHERED: usize = 1 << 18;

impl Answering<'_> {
    fn output(&self) -> Result<BufWriter<Draft>, JobFault> {
        Ok(BufWriter::with_capacity(GATHERED, self.spool.result()?))
    }

    fn read(
        &self,
        source: &InputFile,
        take: &mut dyn FnMut(&Interpreted) -> io::Result<()>,
        stop: &Stop<'_>,
    ) -> Result<Interpretation, JobFault> {
        let mut take = |told: &Interpreted| take(told).map_err(Fault::Io);
        let read = process::interpret_program(&self.on.machine, self.set_up, source, &mut take, stop);
        Ok(read.map_err(in_words_of_the_wire)?)
    }

    fn motion(&self, source: &InputFile, motion: &process::InterpretedMotion) -> InterpretedMotionDoc {
        let number_of = |key: ToolKey| self.on.shelf.table().find(key).and_then(|(_, tool)| tool.number);
        InterpretedMotionDoc::of(motion, name(source, motion.called), &self.on.machine, &number_of)
    }

    fn table(&self, source: &InputFile, stop: &Stop<'_>) -> Result<(Draft, u64), JobFault> {
        let in_table = |fault: csv::Error| CompensatorFault::Io(fault_of_table(fault));
        let mut table = InterpretationTable::new(self.output()?, &self.on.machine).map_err(in_table)?;
        let mut alone = 0_u64;
        let mut take = |told: &Interpreted| match told {
            Interpreted::Motion(motion) => table.add(&self.motion(source, motion)).map_err(fault_of_table),
            Interpreted::LeftAlone { .. } => {
                alone += 1;
                Ok(())
            }
        };
        let Interpretation { reading, .. } = self.read(source, &mut take, stop)?;
        self.on.resolved(&self.parameters.statements(), &reading)?;
        Ok((written(table.into_inner().map_err(CompensatorFault::Io)?)?, alone))
    }

    /// Motions go directly to the answer; the motions left unchanged are kept in a file of their own until all
    /// motions are written.
    fn json(&self, source: &InputFile, stop: &Stop<'_>) -> Result<(Draft, u64), JobFault> {
        let (mut out, mut left) = (self.output()?, self.output()?);
        let (mut motions, mut alone) = (0_u64, 0_u64);
        out.write_all(b"{\"motions\":[").map_err(CompensatorFault::Io)?;
        let mut take = |told: &Interpreted| match told {
            Interpreted::Motion(motion) => element(&mut out, &mut motions, &self.motion(source, motion)),
            Interpreted::LeftAlone { line, called, reason } => {
                let line = called.map_or(*line, |place| u64::from(place.line));
                let doc = LeftAloneDoc { line, file: name(source, *called), reason: reason.to_string() };
                element(&mut left, &mut alone, &doc)
            }
        };
        let Interpretation { dialect, reading, blocks, warnings } = self.read(source, &mut take, stop)?;
        let end = InterpretationEnd {
            warnings: warnings.iter().map(Into::into).collect(),
            machine_revision: self.on.revision,
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            input_sha256: source.sha256.clone(),
            dialect: dialect.into(),
            blocks,
            resolved: self.on.resolved(&self.parameters.statements(), &reading)?,
        };
        let left = written(left)?;
        let end = serde_json::to_string(&end)?;
        let mut finish = || -> io::Result<()> {
            out.write_all(b"],\"left_alone\":[")?;
            io::copy(&mut File::open(left.path())?, &mut out)?;
            out.write_all(b"],")?;
            // The members of the last part, without its opening brace.
            out.write_all(end.get(1..).unwrap_or_default().as_bytes())
        };
        finish().map_err(CompensatorFault::Io)?;
        Ok((written(out)?, alone))
    }
}

/// The name of a file that the program calls.
fn name(source: &InputFile, called: Option<PlaceInFile>) -> Option<String> {
    source.name_of(called?.file.get()).map(str::to_owned)
}

/// Writes one more element of an array.
fn element(out: &mut impl Write, count: &mut u64, value: &impl serde::Serialize) -> io::Result<()> {
    if *count > 0 {
        out.write_all(b",")?;
    }
    *count += 1;
    Ok(serde_json::to_writer(out, value)?)
}
