//! The steps of a program in their order.

use std::io::Write;

use crate::process::contact_path::{CcReport, PathStep};
use crate::process::fault::Fault;
use crate::process::move_ends::{MoveStep, Moved};
use crate::process::pipeline::{Look, MotionChange, Note, Resources, Step, StepDone, run_chain};
use crate::process::singular::{RegionSearch, SingularStep, SingularityReport};
use crate::process::text::{ProgramSource, StepStore};

/// The steps that a program goes through. Singular regions are treated first. Then the ends of motions are moved, for
/// wear and for location errors. The contact path between the ends is repaired last.
pub(super) struct StepList<'p> {
    /// Lists singular regions during the reading of the first step.
    pub(super) search: Option<RegionSearch<'p>>,
    pub(super) singular: Option<SingularStep<'p>>,
    pub(super) moves: Option<MoveStep<'p>>,
    pub(super) path: Option<PathStep<'p>>,
}

/// The reports of the finished steps.
pub(super) struct StepReports {
    pub(super) singular: Option<SingularityReport>,
    pub(super) moved: Option<Moved>,
    pub(super) path: Option<CcReport>,
}

impl StepList<'_> {
    /// Takes a program through the steps. Returns the results of the steps, in their order.
    ///
    /// # Errors
    /// As for [`run_chain`].
    pub(super) fn run(
        &mut self,
        upload: &dyn ProgramSource,
        store: &dyn StepStore,
        output: &mut (dyn Write + Send),
        note: Note<'_, MotionChange>,
        with: &Resources<'_>,
    ) -> Result<Vec<StepDone>, Fault> {
        let Self { search, singular, moves, path } = self;
        let mut steps: Vec<&mut dyn Step> = Vec::new();
        steps.extend(singular.as_mut().map(|step| step as &mut dyn Step));
        steps.extend(moves.as_mut().map(|step| step as &mut dyn Step));
        steps.extend(path.as_mut().map(|step| step as &mut dyn Step));
        let look = search.as_mut().map(|search| search as &mut dyn Look);
        run_chain(&mut steps, look, upload, store, output, note, with)
    }

    /// The reports after the program has gone through.
    ///
    /// # Errors
    /// A step was left out.
    pub(super) fn reports(self) -> Result<StepReports, Fault> {
        let treated = self.singular.map(SingularStep::report).transpose()?;
        Ok(StepReports {
            singular: treated.or(self.search.and_then(RegionSearch::into_report)),
            moved: self.moves.map(MoveStep::report).transpose()?,
            path: self.path.map(PathStep::report).transpose()?,
        })
    }
}
