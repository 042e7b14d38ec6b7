//! What the caller states of a program where its text does not.

use std::sync::Arc;

use super::tooling::{Need, Tools};
use super::tools_at_work::ToolsAtWork;
use crate::kinematics::Setup;
use crate::machine::Tool;
use crate::motion::{Interpolation, InterpreterOptions, WorkOffsets};
use crate::process::fault::Fault;
use crate::program::Dialect;
use crate::units::{Feedrate, Length, LengthUnit};

/// How a program is to be read, and how part and tool are mounted while it runs. Nothing of it is guessed: what is missing is
/// asked for as soon as something depends on it.
#[derive(Debug, Clone, PartialEq)]
pub struct ProgramSetup {
    /// The dialect; `None` detects it.
    pub dialect: Option<Dialect>,
    /// The unit of a program that states none.
    pub unit: Option<LengthUnit>,
    /// Who interpolates; `None` takes it from the program's own switches.
    pub interpolation: Option<Interpolation>,
    /// Feedrate where the program has none.
    pub feed: Option<Feedrate>,
    /// Where the work offsets are.
    pub work_offsets: Arc<WorkOffsets>,
    /// Its tools, cutters of the request apart.
    pub tools: Tools,
    /// Where the axes stand before the first block.
    pub start: StartPosition,
    /// Whether the location errors and the squareness of the machine count.
    pub apply_errors: bool,
    /// Whether steps may be done again to a program that bears their stamp, where doing them again is sound.
    pub allow_repeated: bool,
}

/// Where the axes stand before the first block, as words in the program's first work offset; `None` is not known.
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
            feed: None,
            work_offsets: Arc::default(),
            tools: Tools::default(),
            start: StartPosition::default(),
            apply_errors: true,
            allow_repeated: false,
        }
    }
}

impl ProgramSetup {
    /// Work offset and tool length of a set-up, and a program that counts in millimetres unless it says otherwise.
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

    /// How an interpreter takes the program.
    pub(in crate::process) fn options(&self) -> InterpreterOptions {
        let ([x, y, z], [first, second]) = (self.start.linear_mm, self.start.rotary_deg);
        InterpreterOptions {
            feed_mm_per_min: self.feed.map(Feedrate::mm_per_min),
            interpolation_stated: self.interpolation.is_some(),
            unit: self.unit,
            start: [x, y, z, first, second],
            work_offsets: Arc::clone(&self.work_offsets),
        }
    }

    /// The same, with the tools that were found at work in the program; `stated` is the request's cutter.
    ///
    /// # Errors
    /// Which tool cuts is not known.
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

    /// The same with every length known to the control shorter by so much.
    pub(in crate::process) fn with_shorter_tools(&self, shorter_by: Length) -> Self {
        Self { tools: self.tools.with_shorter(shorter_by), ..self.clone() }
    }
}
