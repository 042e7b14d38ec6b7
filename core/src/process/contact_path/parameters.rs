//! What a cutter-contact compensation is asked to do.

use crate::process::set_up::{Budget, ContactSource};
use std::ops::ControlFlow;

use crate::contact::{Correction, PartSurface};
use crate::machine::{Machine, Tool};
use crate::process::fault::Fault;
use crate::process::set_up::{Need, ProgramSetup, ToolCalls};
use crate::process::text::ProgramSource;
use crate::units::{Angle, Feedrate, Length};

/// How a block over tolerance is divided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum OutputForm {
    /// The fewest equal parts that keep the tolerance.
    #[default]
    Minimal,
    /// One block per interpolation step of the control (P0).
    Interpolated,
}

/// The parameters of a cutter-contact compensation.
#[derive(Debug, Clone, PartialEq)]
pub struct CcParameters {
    /// The cutter; `None`: each section's own from the machine's tool table. With the tip for its contact its shape counts for
    /// nothing.
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
    /// What the text does not say: unit, work offsets, tool length and the like.
    pub program: ProgramSetup,
    /// The largest speed of the tip that an F word may ask for; `None`: [`Self::FEED_TIMES`] the programmed one.
    pub max_feed: Option<Feedrate>,
    /// What the control takes for a block at least \[s\], where that is known.
    pub block_time_s: Option<f64>,
    /// Cost limits of the computation.
    pub budget: Budget,
    /// The part's surface.
    pub part: Option<PartSurface>,
}

impl CcParameters {
    /// Smallest tolerance: a tenth of the last digit of five decimals.
    pub const MIN_TOLERANCE: Length = Length::from_mm(1e-6);
    /// Largest tolerance that is still one.
    pub const MAX_TOLERANCE: Length = Length::from_mm(10.0);

    /// The feed of a finishing pass turns by a few degrees from block to block, that of a link or a corner by more than this.
    pub const PASS_BREAK_DEG: f64 = 15.0;
    /// Parts of a divided block run no faster than so many times the programmed feed: more comes of a contact that swings,
    /// not of the part.
    pub const FEED_TIMES: f64 = 10.0;

    /// The defaults of the contract for a tool: 10 µm, contact found by itself, even correction, fewest blocks.
    #[must_use]
    pub fn new(tool: impl Into<Option<Tool>>, program: ProgramSetup) -> Self {
        Self {
            tool: tool.into(),
            tolerance: Length::from_mm(0.01),
            contact: ContactSource::Auto,
            pass_break: Angle::from_deg(Self::PASS_BREAK_DEG),
            correction: Correction::Even,
            output: OutputForm::Minimal,
            program,
            max_feed: None,
            block_time_s: None,
            budget: Budget::default(),
            part: None,
        }
    }

    /// The same for a program that was looked through, with the tool of each section; `contact` is where contacts come from,
    /// `auto` resolved.
    ///
    /// # Errors
    /// It is not known which tool cuts, the program cannot be read, or the caller no longer waits.
    pub(in crate::process) fn with_tools(
        &self,
        contact: ContactSource,
        calls: &ToolCalls,
        machine: &Machine,
        source: &dyn ProgramSource,
        stop: &dyn Fn() -> ControlFlow<()>,
    ) -> Result<Self, Fault> {
        let need = Need {
            cutter: contact != ContactSource::Tip,
            worn: false,
            is_for_one: false,
            stated_by: "`tool_radius_mm`",
            agreement: contact != ContactSource::Tip,
            leaves_unknown: true,
        };
        let program = self.program.with_tools(self.tool, need, calls, machine, source, stop)?;
        Ok(Self { program, ..self.clone() })
    }
}
