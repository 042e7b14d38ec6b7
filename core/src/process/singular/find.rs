//! Looks for singular regions while another step reads the program. It lists them and changes nothing.

use std::sync::OnceLock;

use super::collector::{Collector, Seen};
use super::contact::Cutting;
use super::measured::{as_uploaded, measured};
use super::parameters::{SingularityAction, SingularityParameters};
use super::planner::Planner;
use super::regions::{RegionFiguresWritten, Regions};
use super::report::SingularityReport;
use crate::contact::Effort;
use crate::geometry::trig;
use crate::machine::Machine;
use crate::motion::Motion;
use crate::process::contact_path::CcParameters;
use crate::process::fault::{Fault, Warnings};
use crate::process::pipeline::{Look, Resources, Surveyed};
use crate::process::set_up::{ContactSource, Stop};
use crate::process::text::{Passages, Stretch, Survey};
use crate::program::{Batch, Dialect};

/// Lists the singular regions of a program while another step works on it. It refuses nothing: if regions cannot be
/// listed, there is no list.
pub(in crate::process) struct RegionSearch<'a> {
    machine: &'a Machine,
    /// Tool, contact and tolerance.
    cc: &'a CcParameters,
    /// The limits of singular regions.
    zone: &'a SingularityParameters,
    /// The same as `cc`, with the tools of the program.
    with_tools: &'a OnceLock<CcParameters>,
    stop: &'a Stop<'a>,
    finder: Option<RegionFinder<'a>>,
    report: Option<SingularityReport>,
}

impl<'a> RegionSearch<'a> {
    /// A search in the first program that it looks at. `with_tools` must be empty.
    pub(in crate::process) fn new(
        cc: &'a CcParameters,
        zone: &'a SingularityParameters,
        with_tools: &'a OnceLock<CcParameters>,
        with: &Resources<'a>,
    ) -> Self {
        let Resources { machine, stop, .. } = *with;
        Self { machine, cc, zone, with_tools, stop, finder: None, report: None }
    }

    /// The list. `None` if regions cannot be listed.
    pub(in crate::process) fn into_report(self) -> Option<SingularityReport> {
        self.report
    }

    /// The parameters with the tools of the program. `None` if the tools are not known.
    fn parameters(
        &self,
        surveyed: &Surveyed<'_>,
        contact: ContactSource,
    ) -> Result<Option<CcParameters>, Fault> {
        if let Some(program) = surveyed.program {
            return Ok(Some(CcParameters { program: program.clone(), ..self.cc.clone() }));
        }
        match self.cc.with_tools(&Surveyed { contact, ..*surveyed }, self.machine, self.stop) {
            Ok(parameters) => Ok(Some(parameters)),
            Err(fault @ (Fault::Cancelled | Fault::Io(_))) => Err(fault),
            Err(_) => Ok(None),
        }
    }
}

impl Look for RegionSearch<'_> {
    fn begin(&mut self, surveyed: &Surveyed<'_>, dialect: Dialect) -> Result<(), Fault> {
        let survey = surveyed.survey;
        let Ok(contact) = survey.contact(self.cc.contact, self.cc.part.is_some()) else { return Ok(()) };
        let Some(parameters) = self.parameters(surveyed, contact)? else { return Ok(()) };
        let cc = self.with_tools.get_or_init(|| parameters);
        self.finder =
            Some(RegionFinder::new(self.machine, cc, self.zone, survey, contact, dialect, self.stop));
        Ok(())
    }

    fn look(&mut self, stretch: &Stretch) {
        if let Some(finder) = &mut self.finder {
            finder.look(stretch);
        }
    }

    fn finish(&mut self, passages: &Passages<'_>) -> Result<(), Fault> {
        self.report = self.finder.take().map_or(Ok(None), |finder| finder.finish(passages))?;
        Ok(())
    }
}

/// Finds the regions of one program.
struct RegionFinder<'a> {
    planner: Planner<'a>,
    collector: Collector<'a>,
    regions: Regions,
    /// The figures as written. They equal those that were read, because nothing is changed.
    written: RegionFiguresWritten,
    effort: Effort<'a>,
    /// The number of the next motion.
    next: u64,
    /// The fault because of which there is no list.
    fault: Option<Fault>,
}

impl<'a> RegionFinder<'a> {
    /// A finder for one program. Tool, contact, tolerance, set-up and budget come from `cc`, whose tools are known.
    /// `survey` belongs to the same program.
    fn new(
        machine: &'a Machine,
        cc: &'a CcParameters,
        zone: &SingularityParameters,
        survey: Survey,
        contact: ContactSource,
        dialect: Dialect,
        stop: &'a Stop<'a>,
    ) -> Self {
        let cutting = Cutting::of(machine, cc, contact);
        let (sine, _) = trig::sin_cos(zone.zone.rad());
        let singular_zone = cutting.kinematics.singular_zone(sine);
        Self {
            collector: Collector::new(cutting.clone(), singular_zone, dialect),
            planner: Planner { cutting, survey, singularity: *zone },
            regions: Regions::default(),
            written: RegionFiguresWritten::default(),
            effort: cc.budget.effort(stop),
            next: 0,
            fault: None,
        }
    }

    fn look(&mut self, stretch: &Stretch) {
        for passage in &stretch.passages {
            if self.fault.is_none() && self.collector.pass_by(&passage.batch, &passage.motions) {
                self.next += passage.motions.len() as u64;
                continue;
            }
            for motion in &passage.motions {
                if self.fault.is_none()
                    && let Err(fault) = self.see(&passage.batch, motion)
                {
                    self.fault = Some(fault);
                }
            }
        }
    }

    fn see(&mut self, batch: &Batch, motion: &Motion) -> Result<(), Fault> {
        let index = self.next;
        self.next += 1;
        if self.collector.see(batch, motion, index) == Seen::Closes && self.collector.is_open() {
            self.close()?;
            self.collector.see(batch, motion, index);
        }
        if self.collector.is_full() {
            self.close()?;
        }
        Ok(())
    }

    fn close(&mut self) -> Result<(), Fault> {
        let region = self.collector.take();
        let (Some(first), Some(last)) = (region.first(), region.last()) else { return Ok(()) };
        let planner = self.planner.on(first);
        let Some(found) = measured(&planner, &region, &mut self.effort)? else { return Ok(()) };
        let number = self.regions.add(as_uploaded([first, last], region.len(), found.before, &found.nearest));
        found.each.iter().for_each(|figures| self.written.take(number, figures));
        Ok(())
    }

    /// The list, after the end of the program that `passages` read. `None` if regions cannot be listed.
    ///
    /// # Errors
    /// The caller has stopped waiting.
    fn finish(mut self, passages: &Passages<'_>) -> Result<Option<SingularityReport>, Fault> {
        let last = if self.fault.is_none() { self.close() } else { Ok(()) };
        match self.fault.or(last.err()) {
            Some(fault @ Fault::Cancelled) => return Err(fault),
            Some(_) => return Ok(None),
            None => {}
        }
        if self.collector.faults.total > 0 {
            return Ok(None);
        }
        let mut warnings = Warnings::default();
        passages.warn(&mut warnings);
        Ok(Some(SingularityReport {
            blocks_in: passages.blocks,
            blocks_out: passages.blocks,
            motions_checked: self.collector.checked,
            warnings: warnings.into_list(),
            ..self.regions.report(self.written, passages.dialect(), SingularityAction::Report)
        }))
    }
}
