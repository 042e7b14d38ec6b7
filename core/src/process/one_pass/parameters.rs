//! What a compensation in one pass is asked to do.

use crate::contact::{Correction, PartSurface};
use crate::machine::Tool;
use crate::process::contact_path::{CcParameters, OutputForm};
use crate::process::move_ends::{LengthInControl, Milling, WearParameters, WornCutter};
use crate::process::set_up::{Budget, ContactSource, ProgramSetup};
use crate::process::singular::{SingularityAction, SingularityParameters};
use crate::servo::{DriveSet, FeedProfile};
use crate::units::{Angle, Feedrate, Length};

/// The steps asked for, and what they share. At least one step has to be named.
#[derive(Debug, Clone, PartialEq)]
pub struct CompensationParameters {
    /// Move the program for a worn cutter.
    pub wear: Option<WearStep>,
    /// The program was posted for the nominal machine: post it anew for the calibrated one.
    pub location_errors: bool,
    /// Compensate the cutter-contact path between the ends of blocks.
    pub cc: Option<CcStep>,
    /// What is done about singular regions, before every other step; `None`: nobody looks for them.
    pub singularity: Option<SingularityParameters>,
    /// Drives of the machine: the budget then has what servo lag leaves.
    pub servo: Option<ServoStep>,
    /// What the text does not say, with the nominal tool length. Its `apply_errors` says for which machine the program is where
    /// `location_errors` is not asked for; else it is not looked at.
    pub program: ProgramSetup,
    /// The largest speed of the tip that an F word may ask for.
    pub max_feed: Option<Feedrate>,
    /// What the control takes for a block at least \[s\].
    pub block_time_s: Option<f64>,
    /// What a step without a budget of its own may cost.
    pub budget: Budget,
    /// The part's surface.
    pub part: Option<PartSurface>,
}

/// What the step for a worn cutter needs; the members mean what they do in [`WearParameters`].
#[derive(Debug, Clone, PartialEq)]
pub struct WearStep {
    /// The cutter (R, r) the program was made for; `None`: each section's own from the machine's tool table.
    pub nominal: Option<Tool>,
    /// The cutter that cuts; `None`: as the table has it.
    pub worn: Option<WornCutter>,
    /// End or flank.
    pub milling: Milling,
    /// ΔL = L − L′; 0 where the lengths are not given.
    pub shorter_by: Length,
    /// Which of the two lengths the control has.
    pub length_in_control: LengthInControl,
    /// Where contacts come from; the tip is none.
    pub contact: ContactSource,
    /// Where the feed turns by more, an assumed contact belongs to another pass.
    pub pass_break: Angle,
}

/// What the step for the cutter-contact path needs; the members mean what they do in [`CcParameters`].
#[derive(Debug, Clone, PartialEq)]
pub struct CcStep {
    /// The cutter the program was made for; a worn one counts in its place. `None`: each section's own from the machine's tool
    /// table.
    pub tool: Option<Tool>,
    /// Largest deviation of the contact point from its line.
    pub tolerance: Length,
    /// Where contacts come from.
    pub contact: ContactSource,
    /// Where the feed turns by more, an assumed contact belongs to another pass.
    pub pass_break: Angle,
    /// How the tip is moved.
    pub correction: Correction,
    /// How blocks are divided.
    pub output: OutputForm,
    /// What the computation may cost.
    pub budget: Budget,
}

/// How the written program runs through the drives, for the error budget.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoStep {
    /// Drives of the axes that move.
    pub drives: DriveSet,
    /// Sample period of the command \[s\].
    pub period_s: f64,
    /// Jerk-limited feed; without one every block runs at its feed.
    pub profile: Option<FeedProfile>,
    /// Most samples the program may take; a longer one is not simulated, and the budget says so.
    pub max_samples: u64,
}

impl CompensationParameters {
    /// No step, and the defaults of the contract.
    #[must_use]
    pub fn new(program: ProgramSetup) -> Self {
        Self {
            wear: None,
            location_errors: false,
            cc: None,
            singularity: None,
            servo: None,
            program,
            max_feed: None,
            block_time_s: None,
            budget: Budget::default(),
            part: None,
        }
    }

    /// Whether ends of motions are to be moved.
    pub(super) fn moves(&self) -> bool {
        self.wear.is_some() || self.location_errors
    }

    /// What holds for the written program, the tool's length apart.
    pub(super) fn real_program(&self) -> ProgramSetup {
        let apply_errors = self.location_errors || self.program.apply_errors;
        ProgramSetup { apply_errors, ..self.program.clone() }
    }

    /// The moving step as that of a wear compensation; `fallback` is a cutter that nothing depends on.
    pub(super) fn moving(&self, fallback: Tool) -> WearParameters {
        let shared = |parameters: WearParameters| WearParameters {
            budget: self.budget,
            part: self.part.clone(),
            ..parameters
        };
        match &self.wear {
            Some(step) => shared(WearParameters {
                milling: step.milling,
                shorter_by: step.shorter_by,
                length_in_control: step.length_in_control,
                contact: step.contact,
                pass_break: step.pass_break,
                ..WearParameters::new(step.nominal, step.worn.clone(), self.real_program())
            }),
            None => shared(WearParameters {
                contact: ContactSource::Tip,
                part: None,
                ..WearParameters::new(fallback, WornCutter::Tool(fallback), self.real_program())
            }),
        }
    }

    /// What singular regions are treated with: the cutter, the contact and the tolerance of the step for its path, or the
    /// tip; the set-up is that of the machine which the program was made for.
    pub(super) fn treatment(&self) -> CcParameters {
        let apply_errors = !self.location_errors && self.program.apply_errors;
        let program = ProgramSetup { apply_errors, ..self.program.clone() };
        let step = match (&self.cc, &self.wear) {
            (Some(step), _) => step.clone(),
            (None, Some(wear)) => {
                CcStep { contact: wear.contact, budget: self.budget, ..CcStep::new(wear.nominal) }
            }
            (None, None) => CcStep { contact: ContactSource::Tip, budget: self.budget, ..CcStep::new(None) },
        };
        CcParameters { tool: step.tool, ..self.contact_path(&step, program) }
    }

    /// The regions that are only to be listed: the first step finds them in its own reading.
    pub(super) fn regions_to_list(&self) -> Option<&SingularityParameters> {
        self.singularity.as_ref().filter(|regions| regions.action == SingularityAction::Report)
    }

    /// The step for the cutter-contact path as a compensation of its own; `program` is the moved program's.
    pub(super) fn contact_path(&self, step: &CcStep, program: ProgramSetup) -> CcParameters {
        let tool = match self.wear.as_ref().map(|wear| &wear.worn) {
            Some(Some(WornCutter::Tool(worn))) => Some(*worn),
            Some(Some(WornCutter::Table(_)) | None) | None => step.tool,
        };
        CcParameters {
            tolerance: step.tolerance,
            contact: step.contact,
            pass_break: step.pass_break,
            correction: step.correction,
            output: step.output,
            max_feed: self.max_feed,
            block_time_s: self.block_time_s,
            budget: step.budget,
            part: self.part.clone(),
            ..CcParameters::new(tool, program)
        }
    }
}

impl WearStep {
    /// End milling, contact found by itself, the nominal length in the control.
    #[must_use]
    pub fn new(nominal: impl Into<Option<Tool>>, worn: impl Into<Option<WornCutter>>) -> Self {
        let WearParameters {
            nominal, worn, milling, shorter_by, length_in_control, contact, pass_break, ..
        } = WearParameters::new(nominal, worn, ProgramSetup::default());
        Self { nominal, worn, milling, shorter_by, length_in_control, contact, pass_break }
    }
}

impl CcStep {
    /// The defaults of the contract for a tool.
    #[must_use]
    pub fn new(tool: impl Into<Option<Tool>>) -> Self {
        let CcParameters { tool, tolerance, contact, pass_break, correction, output, budget, .. } =
            CcParameters::new(tool, ProgramSetup::default());
        Self { tool, tolerance, contact, pass_break, correction, output, budget }
    }
}

impl ServoStep {
    /// The defaults of the contract: 1 ms, no profile, ten million samples.
    #[must_use]
    pub fn new(drives: DriveSet) -> Self {
        Self { drives, period_s: 0.001, profile: None, max_samples: 10_000_000 }
    }
}
