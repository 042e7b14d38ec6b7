//! The step that treats singular regions, and how a program goes through it.

use std::io::Write;

use super::check::RegionCheck;
use super::contact::Cutting;
use super::parameters::{SingularityAction, SingularityParameters};
use super::planner::Planner;
use super::report::SingularityReport;
use super::work::RegionWork;
use crate::machine::Machine;
use crate::process::contact_path::CcParameters;
use crate::process::fault::{Fault, Warnings};
use crate::process::pipeline::{
    Hands, Look, MotionChange, Note, Resources, Step, StepRun, StepWork, Surveyed, Upstream, reported,
};
use crate::process::set_up::{ContactSource, Stop};
use crate::process::text::{Inventory, LineMap, ProgramSource, Survey};
use crate::program::{StepName, Steps};
use crate::side_by_side::OneAfterAnother;

/// Finds the singular regions of a program and treats them: reports, divides or smooths (§1 "Conditioning", "Pole").
///
/// Tool, contact, tolerance, set-up, dialect and budget come from `cc`. Contacts that would be assumed from the feed
/// are not used here; the tip replaces them. Blocks outside the regions are copied byte for byte. So are blocks whose
/// words need not change. Before it returns, it reads the written text back with its own decimals. The report's
/// `after` comes from that reading. Memory does not grow with the program. Run this before a compensation of the
/// contact path, which then reads the written program.
///
/// # Errors
/// The reason why the program is refused. `output` then holds text that must not be run and must be discarded.
pub fn treat_singular_regions(
    machine: &Machine,
    cc: &CcParameters,
    singularity: &SingularityParameters,
    source: &dyn ProgramSource,
    output: &mut dyn Write,
    stop: &Stop<'_>,
) -> Result<SingularityReport, Fault> {
    let mut step = SingularStep::new(cc, singularity);
    let with = Resources { machine, parts: &OneAfterAnother, stop };
    step.run(Upstream::upload(source), None, output, &mut |_| Ok(()), &with)?;
    step.report()
}

/// The step that treats singular regions.
pub(in crate::process) struct SingularStep<'p> {
    cc: &'p CcParameters,
    singularity: &'p SingularityParameters,
    report: Option<SingularityReport>,
}

impl<'p> SingularStep<'p> {
    pub(in crate::process) fn new(cc: &'p CcParameters, singularity: &'p SingularityParameters) -> Self {
        Self { cc, singularity, report: None }
    }

    /// The report, available after a program has gone through.
    ///
    /// # Errors
    /// No program has gone through.
    pub(in crate::process) fn report(self) -> Result<SingularityReport, Fault> {
        reported(self.report)
    }
}

impl Step for SingularStep<'_> {
    fn run(
        &mut self,
        upstream: Upstream<'_>,
        mut look: Option<&mut dyn Look>,
        output: &mut dyn Write,
        _note: Note<'_, MotionChange>,
        &Resources { machine, parts, stop }: &Resources<'_>,
    ) -> Result<LineMap, Fault> {
        let Self { cc, singularity, .. } = *self;
        let source = upstream.source;
        let survey = Survey::of(machine, cc.program.dialect, source, stop)?;
        if singularity.action != SingularityAction::Report {
            survey.refuse_repeated(Steps::of(&[StepName::Singularity]), cc.program.allow_repeated)?;
        }
        let contact = survey.contact(cc.contact, cc.part.is_some())?;
        // Contacts that would be assumed from the feed are not used here.
        let counts = if contact == ContactSource::FeedPlane { ContactSource::Tip } else { contact };
        let cc = &cc.with_tools(counts, &survey.tools, machine, source, stop)?;
        let cutting = Cutting::of(machine, cc, contact);
        let planner = Planner { cutting, survey, singularity: *singularity };
        let mut inventory = Inventory::default();
        let mut run = StepRun::begin(upstream, machine, &cc.program, &inventory, stop)?;
        let dialect = run.dialect();
        if let Some(look) = &mut look {
            look.begin(&Surveyed { source, survey, program: None }, dialect)?;
        }
        let mut work = RegionWork::new(planner.clone(), dialect, stop);
        let mut check = RegionCheck::new(machine, planner, dialect, cc.budget.effort(stop));
        let mut hands = Hands {
            prepare: &mut inventory,
            work: &mut work,
            check: &mut check,
            look: look.map(|look| look as &mut dyn Look),
        };
        let note = &mut |(): &()| Ok(());
        run.run(&mut hands, output, note, parts)?;
        if hands.work.has_faults() {
            return Err(Fault::Lines(work.collector.faults));
        }
        hands.finish(&run.passages, output, note)?;
        let passages = &run.passages;
        let mut warnings = Warnings::default();
        passages.warn(&mut warnings);
        let (report, lines) = work.report(check, dialect, passages.blocks);
        self.report = Some(SingularityReport { warnings: warnings.into_list(), ..report });
        Ok(lines)
    }

    fn notes_motions(&self) -> bool {
        false
    }
}
