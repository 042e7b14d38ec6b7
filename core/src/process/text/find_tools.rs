//! The tools that cut in a program, found by reading it.

use std::ops::ControlFlow;

use super::source::ProgramSource;
use super::stream::Passages;
use super::survey::Survey;
use crate::machine::{Machine, Side, Tool};
use crate::process::fault::Fault;
use crate::process::set_up::{Need, ProgramSetup, SurveyExtent, ToolCalls, ToolsAtWork};

/// The tools that cut in a surveyed program. The program is followed only if the survey leaves more than one tool
/// possible, or if `compares` asks for the cutters stated by `CUTTER/`. Then it is
/// followed in the order of its text or `as_it_runs`.
///
/// # Errors
/// The program cannot be read, or the caller no longer waits.
fn tools_at_work(
    calls: &ToolCalls,
    machine: &Machine,
    program: &ProgramSetup,
    source: &dyn ProgramSource,
    [compares, as_it_runs]: [bool; 2],
    stop: &dyn Fn() -> ControlFlow<()>,
) -> Result<ToolsAtWork, Fault> {
    let only = calls.only().filter(|_| !(compares && calls.has_shapes));
    if let Some((tool, name)) = only {
        let has_changer = calls.has_changer();
        let names = name.into_iter().collect();
        return Ok(ToolsAtWork { tools: vec![tool], names, has_changer, ..ToolsAtWork::default() });
    }
    let mut found = ToolsAtWork { has_changer: calls.has_changer(), ..ToolsAtWork::default() };
    let mut passages = Passages::open(source, machine, program)?;
    if as_it_runs {
        passages = passages.following_its_run(machine, program);
    }
    // The step that works on the program reports its refusals.
    let _refusals = passages.work(stop, |passage, _, _| {
        passage.motions.iter().for_each(|motion| found.see(motion));
        Ok(())
    });
    if stop().is_break() {
        return Err(Fault::Cancelled);
    }
    (found.names, found.cutters) = passages.tools_told();
    Ok(found)
}

fn has_head(machine: &Machine) -> bool {
    machine.rotary_axes().iter().any(|axis| axis.side == Side::Head)
}

impl ProgramSetup {
    /// The same setup with the tool of each section. `stated` is the request's cutter.
    ///
    /// # Errors
    /// It is not known which tool cuts, the program cannot be read, or the caller no longer waits.
    pub(in crate::process) fn with_tools(
        &self,
        stated: Option<Tool>,
        need: Need,
        calls: &ToolCalls,
        machine: &Machine,
        source: &dyn ProgramSource,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Self, Fault> {
        self.with_tools_followed(stated, need, calls, machine, source, false, stop)
    }

    #[expect(clippy::too_many_arguments, reason = "those of `with_tools`, and how the program is followed")]
    fn with_tools_followed(
        &self,
        stated: Option<Tool>,
        need: Need,
        calls: &ToolCalls,
        machine: &Machine,
        source: &dyn ProgramSource,
        as_it_runs: bool,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Self, Fault> {
        if self.tools.are_resolved() {
            return Ok(self.clone());
        }
        let ways = [self.tools.compares_cutters(stated), as_it_runs];
        let at_work = tools_at_work(calls, machine, self, source, ways, stop)?;
        self.with_tools_at_work(stated, need, has_head(machine), &at_work)
    }

    /// [`Self::with_tools`] for a program that was not surveyed yet, and that is followed as it runs. The program is not read if the result does not
    /// depend on the tool.
    ///
    /// # Errors
    /// As for [`Self::with_tools`].
    pub(in crate::process) fn with_surveyed_tools(
        &self,
        stated: Option<Tool>,
        need: Need,
        machine: &Machine,
        source: &dyn ProgramSource,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Self, Fault> {
        let height_counts = machine.machine_coordinates().is_some() && self.tools.length.is_some();
        let counts_nothing =
            !need.cutter && !has_head(machine) && self.tools.table.is_empty() && !height_counts;
        if self.tools.are_resolved() || (counts_nothing && self.tools.number.is_none()) {
            return Ok(self.clone());
        }
        let (survey, _) = Survey::of(machine, self.dialect, source, SurveyExtent::Whole, stop)?;
        self.with_tools_followed(stated, need, &survey.tools, machine, source, true, stop)
    }
}
