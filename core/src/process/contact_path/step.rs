//! The step that repairs the cutter-contact path, and how a program goes through it.

use std::io::Write;

use super::check::{Judged, PathCheck};
use super::parameters::CcParameters;
use super::preparation::Preparation;
use super::report::CcReport;
use super::work::PathWork;
use crate::machine::Machine;
use crate::process::fault::Fault;
use crate::process::pipeline::{
    Asked, Hands, Look, MotionChange, Note, Resources, Step, StepDone, StepRun, Surveyed, Upstream, reported,
};
use crate::process::set_up::Stop;
use crate::process::text::ProgramSource;
use crate::program::{StepName, Steps};
use crate::side_by_side::{OneAfterAnother, SideBySide};

/// Compensates the cutter-contact path of a program on one machine (§2; P0), in the caller's thread.
///
/// # Errors
/// Those of [`compensate_side_by_side`].
pub fn compensate(
    machine: &Machine,
    parameters: &CcParameters,
    source: &dyn ProgramSource,
    output: &mut (dyn Write + Send),
    stop: &Stop<'_>,
) -> Result<CcReport, Fault> {
    compensate_side_by_side(machine, parameters, source, output, &OneAfterAnother, stop)
}

/// Compensates the cutter-contact path of a program on one machine (§2; P0).
///
/// Divides and corrects blocks whose contact deviates by more than the tolerance, and copies all other bytes. Before
/// it returns, it reads the written text back with its own decimals and checks it against the source's lines. The
/// report's `after` comes from that reading. Memory does not grow with the program.
///
/// The function asks `stop` every few milliseconds.
///
/// # Errors
/// The reason why the program is refused. `output` then holds text that must not be run and must be discarded.
pub fn compensate_side_by_side(
    machine: &Machine,
    parameters: &CcParameters,
    source: &dyn ProgramSource,
    output: &mut (dyn Write + Send),
    parts: &dyn SideBySide,
    stop: &Stop<'_>,
) -> Result<CcReport, Fault> {
    let mut step = PathStep::new(parameters);
    let with = Resources { machine, parts, stop };
    step.run(Upstream::upload(source), None, output, &mut |_| Ok(()), &with)?;
    step.report()
}

/// The step that repairs the cutter-contact path.
pub(in crate::process) struct PathStep<'p> {
    parameters: &'p CcParameters,
    report: Option<CcReport>,
}

impl<'p> PathStep<'p> {
    pub(in crate::process) fn new(parameters: &'p CcParameters) -> Self {
        Self { parameters, report: None }
    }

    /// The report, available after a program has gone through.
    ///
    /// # Errors
    /// No program has gone through.
    pub(in crate::process) fn report(self) -> Result<CcReport, Fault> {
        reported(self.report)
    }
}

impl Step for PathStep<'_> {
    fn run(
        &mut self,
        upstream: Upstream<'_>,
        look: Option<&mut dyn Look>,
        output: &mut (dyn Write + Send),
        note: Note<'_, MotionChange>,
        with: &Resources<'_>,
    ) -> Result<StepDone, Fault> {
        let Resources { machine, parts, stop } = *with;
        let parameters = self.parameters;
        let asked = Asked {
            program: &parameters.program,
            steps: Steps::of(&[StepName::Cc]),
            contact: parameters.contact,
            has_part: parameters.part.is_some(),
        };
        let surveyed = Surveyed::of(upstream.source, &asked, with)?;
        let with_tools = parameters.with_tools(&surveyed, machine, stop);
        let parameters = &with_tools.map_err(|fault| surveyed.before_the_end(fault))?;
        let surveyed = surveyed.with_tools_of(&parameters.program);
        let mut preparation = Preparation::new(machine, parameters, surveyed.contact);
        let mut run = StepRun::begin(upstream, &surveyed, machine, &parameters.program, &preparation, stop)?;
        let effort = || parameters.budget.effort(stop);
        let mut work = PathWork::new(machine, parameters, run.dialect(), &surveyed, effort());
        let mut check = PathCheck::new(machine, parameters, run.dialect(), effort());
        let hands = Hands { prepare: &mut preparation, work: &mut work, check: &mut check, look };
        let note = &mut |judged: &Judged| note(&judged.change());
        run.run(hands, &surveyed, output, note, parts)?;
        let (report, lines) = work.report(check, &run.passages);
        let interpolation = Some(report.interpolation);
        let told = StepDone::new(&run.passages, lines, interpolation, report.steps, report.blocks_out);
        self.report = Some(report);
        Ok(told)
    }

    fn notes_motions(&self) -> bool {
        true
    }
}
