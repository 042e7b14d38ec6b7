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
use crate::process::fault::Fault;
use crate::process::pipeline::{
    Asked, Hands, Look, MotionChange, Note, Resources, Step, StepDone, StepRun, Surveyed, Upstream, reported,
};
use crate::process::set_up::{ContactSource, Stop};
use crate::process::text::{Inventory, ProgramSource};
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
    output: &mut (dyn Write + Send),
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
        look: Option<&mut dyn Look>,
        output: &mut (dyn Write + Send),
        _note: Note<'_, MotionChange>,
        with: &Resources<'_>,
    ) -> Result<StepDone, Fault> {
        let Resources { machine, parts, stop } = *with;
        let Self { cc, singularity, .. } = *self;
        let changes = singularity.action != SingularityAction::Report;
        let asked = Asked {
            program: &cc.program,
            steps: if changes { Steps::of(&[StepName::Singularity]) } else { Steps::NONE },
            contact: cc.contact,
            has_part: cc.part.is_some(),
        };
        let surveyed = Surveyed::of(upstream.source, &asked, with)?;
        // Contacts that would be assumed from the feed are not used here.
        let is_assumed = surveyed.contact == ContactSource::FeedPlane;
        let counts = if is_assumed { ContactSource::Tip } else { surveyed.contact };
        let with_tools = cc.with_tools(&Surveyed { contact: counts, ..surveyed }, machine, stop);
        let cc = &with_tools.map_err(|fault| surveyed.before_the_end(fault))?;
        let cutting = Cutting::of(machine, cc, surveyed.contact);
        let planner = Planner { cutting, survey: surveyed.survey, singularity: *singularity };
        let mut inventory = Inventory::default();
        let mut run = StepRun::begin(upstream, &surveyed, machine, &cc.program, &inventory, stop)?;
        let mut work = RegionWork::new(planner.clone(), run.dialect(), stop);
        let mut check = RegionCheck::new(machine, planner, run.dialect(), cc.budget.effort(stop));
        let hands = Hands { prepare: &mut inventory, work: &mut work, check: &mut check, look };
        run.run(hands, &surveyed, output, &mut |(): &()| Ok(()), parts)?;
        let (report, lines) = work.report(check, &run.passages);
        let told = StepDone::new(&run.passages, lines, None, report.steps(), report.blocks_out);
        self.report = Some(report);
        Ok(told)
    }

    fn notes_motions(&self) -> bool {
        false
    }
}
