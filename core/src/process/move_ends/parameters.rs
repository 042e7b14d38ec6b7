//! What a wear compensation is asked to do.

use std::ops::ControlFlow;

use super::worn_tool::WornTool;
use crate::contact::PartSurface;
use crate::machine::{Machine, Side, Tool};
use crate::process::contact_path::CcParameters;
use crate::process::fault::Fault;
use crate::process::set_up::{Budget, ContactSource, Need, ProgramSetup, SetUps, ToolCalls, ToolUsed};
use crate::process::text::ProgramSource;
use crate::program::{Step, Steps};
use crate::units::{Angle, Length};
use crate::wear::WearTable;

/// Which part of the cutter makes the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Milling {
    /// Its end: the corner, or the flat.
    #[default]
    End,
    /// Its flank.
    Side,
}

impl Milling {
    /// The name in the contract.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::End => "end",
            Self::Side => "side",
        }
    }
}

/// The cutter in the spindle.
#[derive(Debug, Clone, PartialEq)]
pub enum WornCutter {
    /// By its own radii.
    Tool(Tool),
    /// The nominal one with a deviation that differs along the corner.
    Table(WearTable),
}

/// Which length stands in the control while the written program runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LengthInControl {
    /// That of the nominal cutter: the tip has to be commanded lower.
    #[default]
    Nominal,
    /// That of the worn cutter.
    Measured,
}

/// The parameters of a wear compensation.
#[derive(Debug, Clone, PartialEq)]
pub struct WearParameters {
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
    /// What the text does not say, with the nominal tool length.
    pub program: ProgramSetup,
    /// What the search for contacts may cost.
    pub budget: Budget,
    /// The part's surface.
    pub part: Option<PartSurface>,
}

/// Everything that decides where ends of motions go: a wear compensation, posting for another machine, or both.
#[derive(Debug, Clone)]
pub(in crate::process) struct Moves<'a> {
    /// The worn cutter; without wear a cutter of nominal shape, whose tip is kept.
    pub(in crate::process) parameters: &'a WearParameters,
    /// The program and the machine that it was made for.
    pub(in crate::process) source_program: ProgramSetup,
    /// The machine that runs it, with the nominal tool length.
    pub(in crate::process) written_program: ProgramSetup,
    /// The two differ in more than the tool's length: every end is posted anew, rotary words too.
    pub(in crate::process) posts: bool,
    /// A worn cutter was named.
    pub(in crate::process) has_wear: bool,
}

impl<'a> Moves<'a> {
    /// Those of a wear compensation.
    pub(super) fn of_wear(parameters: &'a WearParameters) -> Self {
        Self {
            parameters,
            source_program: parameters.program.clone(),
            written_program: parameters.program.clone(),
            posts: false,
            has_wear: true,
        }
    }

    /// The steps that are asked for.
    pub(super) fn steps(&self) -> Steps {
        let wear = if self.has_wear { Steps::of(&[Step::Wear]) } else { Steps::NONE };
        if self.posts { wear.with(Step::LocationErrors) } else { wear }
    }

    /// What holds for the written program.
    pub(in crate::process) fn program_after(&self) -> ProgramSetup {
        let tools = self.written_program.tools.behind_wear(self.parameters.known_to_control());
        ProgramSetup { tools, ..self.written_program.clone() }
    }

    /// The worn cutter of a section; `None` where nothing is known of its tool or of its wear. Without wear a cutter of nominal
    /// shape.
    pub(super) fn worn_tool(&self, used: Option<ToolUsed>) -> Option<WornTool> {
        let (used, parameters) = (used?, self.parameters);
        let nominal = used.nominal.or(parameters.nominal)?;
        let worn = if self.has_wear {
            parameters.worn.clone().or(used.worn.map(WornCutter::Tool))?
        } else {
            WornCutter::Tool(nominal)
        };
        let unknown_to_control = parameters.shorter_by - parameters.known_to_control();
        Some(WornTool { nominal, worn, milling: parameters.milling, unknown_to_control })
    }

    /// The worn cutters of a program that was looked through.
    pub(super) fn worn_tools(&self) -> Vec<WornTool> {
        let tooling = self.source_program.tools.tooling();
        tooling.all_tools().filter_map(|used| self.worn_tool(Some(used))).collect()
    }

    /// The same for a program that was looked through, with the tool of each section.
    ///
    /// # Errors
    /// Which tool cuts is not known, the program cannot be read, or nobody waits any more.
    pub(super) fn with_tools(
        &self,
        calls: &ToolCalls,
        machine: &Machine,
        source: &dyn ProgramSource,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Self, Fault> {
        let need = Need {
            cutter: self.has_wear,
            worn: self.has_wear && self.parameters.worn.is_none(),
            is_for_one: self.has_wear && self.parameters.worn.is_some(),
            stated_by: "`nominal_tool`",
            agreement: self.has_wear,
            leaves_unknown: self.has_wear,
        };
        let stated = self.parameters.nominal.filter(|_| self.has_wear);
        let source_program = self.source_program.with_tools(stated, need, calls, machine, source, stop)?;
        let written_program =
            ProgramSetup { tools: source_program.tools.clone(), ..self.written_program.clone() };
        Ok(Self { source_program, written_program, ..self.clone() })
    }

    /// The machine as it is set up for the source's motions, and for those of the written program.
    pub(super) fn set_ups(&self, machine: &Machine) -> [SetUps; 2] {
        let shorter_by = self.parameters.known_to_control();
        [
            SetUps::new(machine, &self.source_program),
            SetUps::new(machine, &self.written_program.with_shorter_tools(shorter_by)),
        ]
    }

    /// Whether the words of every point mean another place, rapids too.
    pub(super) fn moves_everything(&self, machine: &Machine) -> bool {
        self.posts || self.parameters.moves_everything(machine)
    }

    /// Whether U V W have to be written anew because the words of every point mean another place.
    pub(super) fn moves_points(&self, machine: &Machine) -> bool {
        let measured = self.parameters.length_in_control == LengthInControl::Measured;
        self.posts || (measured && self.parameters.moves_everything(machine))
    }
}

impl WearParameters {
    /// End milling with the worn cutter's own length in the control, contact found by itself.
    #[must_use]
    pub fn new(
        nominal: impl Into<Option<Tool>>,
        worn: impl Into<Option<WornCutter>>,
        program: ProgramSetup,
    ) -> Self {
        Self {
            nominal: nominal.into(),
            worn: worn.into(),
            milling: Milling::End,
            shorter_by: Length::ZERO,
            length_in_control: LengthInControl::Nominal,
            contact: ContactSource::Auto,
            pass_break: Angle::from_deg(CcParameters::PASS_BREAK_DEG),
            program,
            budget: Budget::default(),
            part: None,
        }
    }

    /// ΔL as far as the control knows of it.
    pub(super) fn known_to_control(&self) -> Length {
        match self.length_in_control {
            LengthInControl::Nominal => Length::ZERO,
            LengthInControl::Measured => self.shorter_by,
        }
    }

    /// Whether the length alone moves the words of every point, rapids too.
    pub(super) fn moves_everything(&self, machine: &Machine) -> bool {
        let has_head = machine.rotary_axes().iter().any(|axis| axis.side == Side::Head);
        let shorter_mm = self.shorter_by.mm().abs();
        shorter_mm > 0.0 && (has_head || self.length_in_control == LengthInControl::Nominal)
    }
}
