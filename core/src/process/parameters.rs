//! What a cutter-contact compensation is asked to do.

use std::ops::ControlFlow;

use super::tools::{Need, ToolCalls};
use super::{Fault, ProgramSetup, ProgramSource, Stop};
use crate::contact::{Correction, Effort, PartSurface};
use crate::machine::{Machine, Tool};
use crate::units::{Angle, Feedrate, Length};

/// Where the contact at the block ends comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ContactSource {
    /// The first available of program, normals and surface, else the tip.
    #[default]
    Auto,
    /// U V W words.
    Program,
    /// Contact normals carried with the program (CSV columns nx ny nz).
    Normals,
    /// P0's rule from the feed direction, where rotary axes turn; an assumption, reported as such.
    FeedPlane,
    /// The part's surface, where it comes with the program: where the cutter touches it.
    Surface,
    /// The tool tip itself.
    Tip,
}

impl ContactSource {
    /// The name in the contract.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Program => "program",
            Self::Normals => "normals",
            Self::FeedPlane => "feed-plane",
            Self::Surface => "surface",
            Self::Tip => "tip",
        }
    }
}

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
    /// Where contacts come from.
    pub contact: ContactSource,
    /// Where the feed turns by more, an assumed contact belongs to another pass.
    pub pass_break: Angle,
    /// How the tip is moved.
    pub correction: Correction,
    /// How blocks are divided.
    pub output: OutputForm,
    /// What the text does not say: unit, work offsets, tool length and the like.
    pub program: ProgramSetup,
    /// The largest speed of the tip that an F word may ask for; `None`: [`Self::FEED_TIMES`] the programmed one.
    pub max_feed: Option<Feedrate>,
    /// What the control takes for a block at least \[s\], where that is known.
    pub block_time_s: Option<f64>,
    /// What the computation may cost.
    pub budget: Budget,
    /// The part's surface.
    pub part: Option<PartSurface>,
}

/// Bounds on what one program may cost, checked as it runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget {
    /// Most evaluations of the deviation.
    pub max_evaluations: u64,
    /// Most blocks written.
    pub max_blocks_out: u64,
    /// Most steps of searches on the part's surface.
    pub max_surface_steps: u64,
}

impl Default for Budget {
    fn default() -> Self {
        Self { max_evaluations: 1_000_000_000, max_blocks_out: 20_000_000, max_surface_steps: 2_000_000_000 }
    }
}

impl Budget {
    /// An effort that may take as much.
    pub(super) fn effort<'s>(&self, stop: &'s Stop<'s>) -> Effort<'s> {
        Effort::new(stop, self.max_evaluations).searching_at_most(self.max_surface_steps)
    }
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
    /// Which tool cuts is not known, the program cannot be read, or nobody waits any more.
    pub(super) fn with_tools(
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
