//! Singular regions and the cutter-contact path, without moved ends.

use std::io::Write;
use std::sync::OnceLock;

use super::steps::StepList;
use crate::machine::Machine;
use crate::process::contact_path::{CcParameters, CcReport, PathStep};
use crate::process::fault::Fault;
use crate::process::pipeline::Resources;
use crate::process::set_up::Stop;
use crate::process::singular::{
    RegionSearch, SingularStep, SingularityAction, SingularityParameters, SingularityReport,
};
use crate::process::text::{ProgramSource, StepStore};
use crate::side_by_side::SideBySide;

/// Treats the singular regions of a program, then repairs the cutter-contact path of the written program. Between
/// the two steps the program is stored in `store`. Regions that are only reported are found during the reading of
/// the path step. They refuse nothing, and the report is `None` if they cannot be listed. Lines in both reports are
/// the upload's.
///
/// # Errors
/// Why the program is refused. `output` must then be thrown away and not be run.
#[expect(clippy::too_many_arguments, reason = "those of both steps")]
pub fn treat_and_compensate(
    machine: &Machine,
    cc: &CcParameters,
    singularity: &SingularityParameters,
    source: &dyn ProgramSource,
    store: &dyn StepStore,
    output: &mut (dyn Write + Send),
    parts: &dyn SideBySide,
    stop: &Stop<'_>,
) -> Result<(Option<SingularityReport>, CcReport), Fault> {
    let with = Resources { machine, parts, stop };
    let with_tools = OnceLock::new();
    let lists = singularity.action == SingularityAction::Report;
    let mut steps = StepList {
        search: lists.then(|| RegionSearch::new(cc, singularity, &with_tools, &with)),
        singular: (!lists).then(|| SingularStep::new(cc, singularity)),
        moves: None,
        path: Some(PathStep::new(cc)),
    };
    steps.run(source, store, output, &mut |_| Ok(()), &with)?;
    let done = steps.reports()?;
    let report = done.path.ok_or(Fault::NothingAsked)?;
    let blocks_in = done.singular.as_ref().map_or(report.blocks_in, |treated| treated.blocks_in);
    Ok((done.singular, CcReport { blocks_in, ..report }))
}
