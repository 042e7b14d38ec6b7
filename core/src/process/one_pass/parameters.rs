//! The parameters of a compensation in one pass.

use crate::contact::{Correction, PartSurface};
use crate::machine::Tool;
use crate::process::contact_path::{CcParameters, OutputForm};
use crate::process::move_ends::{LengthInControl, Milling, WearParameters, WornCutter};
use crate::process::set_up::{Budget, ContactSource, ProgramSetup};
use crate::process::singular::{SingularityAction, SingularityParameters};
use crate::servo::{DriveSet, FeedProfile};
use crate::units::{Angle, Feedrate, Length};

/// The steps asked for, and their common parameters. At least one step has to be named.
#[derive(Debug, Clone, PartialEq)]
pub struct CompensationParameters {
    /// Move the program for a worn cutter.
    pub wear: Option<WearStep>,
    /// The program was posted for the nominal machine: post it again for the calibrated one.
    pub location_errors: bool,
    /// Compensate the cutter-contact path between the ends of blocks.
    pub cc: Option<CcStep>,
    /// The treatment of singular regions before all other steps; `None`: they are not searched.
    pub singularity: Option<SingularityParameters>,
    /// Drives of the machine. The budget then includes servo lag.
    pub servo: Option<ServoStep>,
    /// The caller's statements that the text does not have, with the nominal tool length. Without
    /// `location_errors`, its `apply_errors` says for which machine the program was made; with it, that member is
    /// ignored.
    pub program: ProgramSetup,
    /// Largest speed of the tip that an F word may ask for.
    pub max_feed: Option<Feedrate>,
    /// Shortest time that the control needs for a block \[s\].
    pub block_time_s: Option<f64>,
    /// Cost limits of a step without a budget of its own.
    pub budget: Budget,
    /// The part's surface.
    pub part: Option<PartSurface>,
}

/// The parameters of the step for a worn cutter, with the meanings in [`WearParameters`].
#[derive(Debug, Clone, PartialEq)]
pub struct WearStep {
    /// The cutter (R, r) for which the program was made; `None` takes each section's cutter from the machine's tool
    /// table.
    pub nominal: Option<Tool>,
    /// The worn cutter; `None` takes it from the table.
    pub worn: Option<WornCutter>,
    /// End or flank.
    pub milling: Milling,
    /// ΔL = L − L′; 0 if the lengths are not given.
    pub shorter_by: Length,
    /// The length that the control has: nominal or actual.
    pub length_in_control: LengthInControl,
    /// The source of contacts; the tip gives no contact here.
    pub contact: ContactSource,
    /// An assumed contact belongs to another pass if the feed direction turns by more than this.
    pub pass_break: Angle,
}

/// The parameters of the step for the cutter-contact path, with the meanings in [`CcParameters`].
#[derive(Debug, Clone, PartialEq)]
pub struct CcStep {
    /// The cutter for which the program was made. A worn cutter replaces it. `None` takes each section's cutter
    /// from the machine's tool table.
    pub tool: Option<Tool>,
    /// Largest deviation of the contact point from its line.
    pub tolerance: Length,
    /// The source of contacts.
    pub contact: ContactSource,
    /// An assumed contact belongs to another pass if the feed direction turns by more than this.
    pub pass_break: Angle,
    /// How the tip moves.
    pub correction: Correction,
    /// How blocks are divided.
    pub output: OutputForm,
    /// Cost limits of the computation.
    pub budget: Budget,
}

/// The simulation of the written program through the drives, for the error budget.
#[derive(Debug, Clone, PartialEq)]
pub struct ServoStep {
    /// Drives of the axes that move.
    pub drives: DriveSet,
    /// Sample period of the command \[s\].
    pub period_s: f64,
    /// Jerk-limited feed. Without it every block runs at its feed.
    pub profile: Option<FeedProfile>,
    /// Most samples of the program. A longer program is not simulated, and the budget says so.
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

    /// Whether ends of motions have to move.
    pub(super) fn moves(&self) -> bool {
        self.wear.is_some() || self.location_errors
    }

    /// The set-up of the written program, without the tool's length.
    pub(super) fn real_program(&self) -> ProgramSetup {
        let apply_errors = self.location_errors || self.program.apply_errors;
        ProgramSetup { apply_errors, ..self.program.clone() }
    }

    /// The parameters of the step that moves ends. Without wear they name no cutter.
    pub(super) fn moving(&self) -> WearParameters {
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
                ..WearParameters::new(None, None, self.real_program())
            }),
        }
    }

    /// The parameters for treating singular regions: the cutter, contact and tolerance of the path step, or the
    /// tip. The set-up is that of the machine for which the program was made.
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

    /// The regions that are only listed. The first step finds them during its own reading.
    pub(super) fn regions_to_list(&self) -> Option<&SingularityParameters> {
        self.singularity.as_ref().filter(|regions| regions.action == SingularityAction::Report)
    }

    /// The step for the cutter-contact path as a compensation of its own. `program` is the set-up of the moved
    /// program.
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
    /// End milling, contact from the first available source, the nominal length in the control.
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
