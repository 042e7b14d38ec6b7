//! The caller's statements for everything that the program text does not state.

use std::sync::Arc;

use super::tooling::{Need, Tools};
use super::tools_at_work::ToolsAtWork;
use crate::kinematics::Setup;
use crate::machine::Tool;
use crate::motion::{Interpolation, InterpreterOptions, RadiusOffsets, StartModes, WorkOffsets};
use crate::process::fault::Fault;
use crate::program::{Dialect, Steps};
use crate::units::{Feedrate, Length, LengthUnit};

/// How a program is read, and how part and tool are mounted while it runs. Nothing is guessed: the service asks for
/// a missing value as soon as something depends on it.
#[derive(Debug, Clone, PartialEq)]
pub struct ProgramSetup {
    /// The dialect; `None` detects it from the text.
    pub dialect: Option<Dialect>,
    /// The unit of a program that does not state one.
    pub unit: Option<LengthUnit>,
    /// Interpolation mode; `None` takes it from the program's own switches.
    pub interpolation: Option<Interpolation>,
    /// The points of cutter location data under `CUTCOM/` are places of the cutter's centre.
    pub cutcom_at_centre: bool,
    /// Feedrate for a program without a feed.
    pub feed: Option<Feedrate>,
    /// Positions of the work offsets.
    pub work_offsets: Arc<WorkOffsets>,
    /// Radii in the registers of the control.
    pub radius_offsets: Arc<RadiusOffsets>,
    /// The tools of the program, without the cutters in the request.
    pub tools: Tools,
    /// Modes before the first block.
    pub start_modes: StartModes,
    /// Positions of the axes before the first block.
    pub start: StartPosition,
    /// Whether the location errors and the squareness of the machine are applied.
    pub apply_errors: bool,
    /// Whether steps may be repeated on a program that has their stamp, if repeating them is sound.
    pub allow_repeated: bool,
    /// Steps that were done to the program before, as the caller knows. Those of its stamp are added.
    pub steps_done: Steps,
    /// How much of the text is surveyed before a step follows it.
    pub survey: SurveyExtent,
}

/// How much of a program's text is surveyed before a step that writes follows it. The survey shows stated contacts,
/// decimals, block numbers, tool calls and stamps. The result of a step does not depend on the extent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SurveyExtent {
    /// All of it. The text is read twice.
    #[default]
    Whole,
    /// Its head. The rest is surveyed while the step reads it. If the rest shows what the head did not, the step ends
    /// with [`Fault::HeadMisled`]. So does a refusal before the end of the program, because the head may be its cause.
    /// The caller then has to begin again with [`Self::Whole`].
    Head,
}

/// Positions of the axes before the first block, as words in the program's first work offset. `None` is unknown.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StartPosition {
    /// X Y Z \[mm\].
    pub linear_mm: [Option<f64>; 3],
    /// The rotary axes in the profile's order \[deg\].
    pub rotary_deg: [Option<f64>; 2],
}

impl Default for ProgramSetup {
    fn default() -> Self {
        Self {
            dialect: None,
            unit: None,
            interpolation: None,
            cutcom_at_centre: false,
            feed: None,
            work_offsets: Arc::default(),
            radius_offsets: Arc::default(),
            tools: Tools::default(),
            start_modes: StartModes::default(),
            start: StartPosition::default(),
            apply_errors: true,
            allow_repeated: false,
            steps_done: Steps::NONE,
            survey: SurveyExtent::Whole,
        }
    }
}

impl ProgramSetup {
    /// Work offset and tool length of a set-up, for a program in millimetres unless its text states another unit.
    #[must_use]
    pub fn in_mm(setup: &Setup) -> Self {
        Self {
            unit: Some(LengthUnit::Millimetre),
            work_offsets: Arc::new(WorkOffsets::only(setup.work_offset_mm.into())),
            tools: Tools::of_length(Some(Length::from_mm(setup.tool_length_mm))),
            apply_errors: setup.apply_errors,
            ..Self::default()
        }
    }

    /// The options with which an interpreter reads the program.
    pub(in crate::process) fn options(&self) -> InterpreterOptions {
        let ([x, y, z], [first, second]) = (self.start.linear_mm, self.start.rotary_deg);
        InterpreterOptions {
            feed_mm_per_min: self.feed.map(Feedrate::mm_per_min),
            interpolation: self.interpolation,
            cutcom_at_centre: self.cutcom_at_centre,
            unit: self.unit,
            start_modes: self.start_modes,
            start: [x, y, z, first, second],
            work_offsets: Arc::clone(&self.work_offsets),
            tool_lengths: self.tools.lengths(),
            radius_offsets: Arc::clone(&self.radius_offsets),
            as_it_runs: false,
        }
    }

    /// The same with the tools found at work in the program. `stated` is the request's cutter.
    ///
    /// # Errors
    /// It is not known which tool cuts.
    pub(in crate::process) fn with_tools_at_work(
        &self,
        stated: Option<Tool>,
        need: Need,
        has_head: bool,
        at_work: &ToolsAtWork,
    ) -> Result<Self, Fault> {
        let tools = self.tools.found_at_work(stated, need, has_head, at_work).map_err(Fault::Tool)?;
        Ok(Self { tools, ..self.clone() })
    }

    /// The same with every length known to the control shorter by `shorter_by`.
    pub(in crate::process) fn with_shorter_tools(&self, shorter_by: Length) -> Self {
        Self { tools: self.tools.with_shorter(shorter_by), ..self.clone() }
    }
}
