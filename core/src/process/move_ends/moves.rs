//! The inputs that decide where the ends of motions go.

use super::parameters::{LengthInControl, Milling, WearParameters, WornCutter};
use super::worn_tool::WornTool;
use crate::machine::Machine;
use crate::process::fault::Fault;
use crate::process::pipeline::Surveyed;
use crate::process::set_up::{ContactSource, Need, ProgramSetup, SetUps, Stop, ToolUsed};
use crate::program::{StepName, Steps};

/// Everything that decides where the ends of motions go, for a wear compensation, a recalibration, or
/// both.
#[derive(Debug, Clone)]
pub(in crate::process) struct Moves<'a> {
    /// The worn cutter. Without wear no cutter is named here, and the tip is kept.
    pub(in crate::process) parameters: &'a WearParameters,
    /// The program and the machine for which it was made.
    pub(in crate::process) source_program: ProgramSetup,
    /// The machine that runs it, with the nominal tool length.
    pub(in crate::process) written_program: ProgramSetup,
    /// The two differ in more than the tool's length. Every end is then computed anew, including rotary words.
    pub(in crate::process) recalibrates: bool,
    /// A worn cutter was stated.
    pub(in crate::process) has_wear: bool,
}

impl<'a> Moves<'a> {
    /// The inputs of a wear compensation.
    pub(super) fn of_wear(parameters: &'a WearParameters) -> Self {
        Self {
            parameters,
            source_program: parameters.program.clone(),
            written_program: parameters.program.clone(),
            recalibrates: false,
            has_wear: true,
        }
    }

    /// The requested steps.
    pub(super) fn steps(&self) -> Steps {
        let wear = if self.has_wear { Steps::of(&[StepName::Wear]) } else { Steps::NONE };
        if self.recalibrates { wear.with(StepName::LocationErrors) } else { wear }
    }

    /// The set-up of the written program.
    pub(in crate::process) fn program_after(&self) -> ProgramSetup {
        let tools = self.written_program.tools.behind_wear(self.parameters.known_to_control());
        ProgramSetup { tools, ..self.written_program.clone() }
    }

    /// The worn cutter of a section. `None` without wear, or if nothing is known of its tool or of its wear.
    pub(super) fn worn_tool(&self, used: Option<ToolUsed>) -> Option<WornTool> {
        let (used, parameters) = (used.filter(|_| self.has_wear)?, self.parameters);
        let nominal = used.nominal.or(parameters.nominal)?;
        let worn = parameters.worn.clone().or(used.worn.map(WornCutter::Tool))?;
        let unknown_to_control = parameters.shorter_by - parameters.known_to_control();
        Some(WornTool { nominal, worn, milling: parameters.milling, unknown_to_control })
    }

    /// The worn cutters of a program that was surveyed. Without wear there are none.
    pub(super) fn worn_tools(&self) -> Vec<WornTool> {
        let tooling = self.source_program.tools.tooling();
        tooling.all_tools().filter_map(|used| self.worn_tool(Some(used))).collect()
    }

    /// Whether a cutter differs from its nominal shape. A cutter of nominal shape moves only by its length, wherever it
    /// touches.
    pub(super) fn has_worn_shape(&self) -> bool {
        !self.worn_tools().iter().all(WornTool::has_nominal_shape)
    }

    /// Refuses a worn shape whose contact is not known.
    ///
    /// # Errors
    /// The contact must be stated, or another source must be asked for.
    pub(super) fn refuse_contact(&self, contact: ContactSource) -> Result<(), Fault> {
        if !self.has_wear || !self.has_worn_shape() {
            return Ok(());
        }
        let WearParameters { milling, contact: asked, .. } = *self.parameters;
        let side_by_feed = contact == ContactSource::FeedPlane && milling == Milling::Side;
        match contact {
            ContactSource::Tip if asked == ContactSource::Auto => {
                Err(Fault::ContactUnknown { milling: milling.name() })
            }
            ContactSource::Tip => {
                Err(Fault::UnfitContact { contact: contact.name(), milling: milling.name() })
            }
            _ if side_by_feed => {
                Err(Fault::UnfitContact { contact: contact.name(), milling: milling.name() })
            }
            _ => Ok(()),
        }
    }

    /// The same inputs with the tool of each section, for a program that was surveyed.
    ///
    /// # Errors
    /// The cutting tool is not known, the program cannot be read, or the caller has stopped waiting.
    pub(super) fn with_tools(
        &self,
        surveyed: &Surveyed<'_>,
        machine: &Machine,
        stop: &Stop<'_>,
    ) -> Result<Self, Fault> {
        let (source, calls) = (surveyed.source, &surveyed.survey.tools);
        let need = Need {
            cutter: self.has_wear,
            worn: self.has_wear && self.parameters.worn.is_none(),
            is_for_one: self.has_wear && self.parameters.worn.is_some(),
            stated_by: "`nominal_tool`",
            agreement: self.has_wear,
            leaves_unknown: self.has_wear,
        };
        let nominal = self.parameters.nominal;
        let source_program = self.source_program.with_tools(nominal, need, calls, machine, source, stop)?;
        let written_program =
            ProgramSetup { tools: source_program.tools.clone(), ..self.written_program.clone() };
        Ok(Self { source_program, written_program, ..self.clone() })
    }

    /// The set-ups of the machine for the source's motions and for those of the written program.
    pub(super) fn set_ups(&self, machine: &Machine) -> [SetUps; 2] {
        let shorter_by = self.parameters.known_to_control();
        [
            SetUps::new(machine, &self.source_program),
            SetUps::new(machine, &self.written_program.with_shorter_tools(shorter_by)),
        ]
    }

    /// Whether the words of every point mean another place, including those of rapids.
    pub(super) fn moves_everything(&self, machine: &Machine) -> bool {
        self.recalibrates || self.parameters.moves_everything(machine)
    }

    /// Whether U V W must be rewritten because the words of every point mean another place.
    pub(super) fn moves_points(&self, machine: &Machine) -> bool {
        let measured = self.parameters.length_in_control == LengthInControl::Measured;
        self.recalibrates || (measured && self.parameters.moves_everything(machine))
    }
}
