//! The parameters of a cutter-contact compensation.

use crate::contact::{Correction, PartSurface};
use crate::machine::{Machine, Tool};
use crate::process::fault::Fault;
use crate::process::pipeline::FEED_TIMES;
use crate::process::pipeline::Surveyed;
use crate::process::set_up::{Budget, ContactSource, Need, ProgramSetup, Stop};
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
    /// The cutter. `None`: each section takes its own from the machine's tool table. If the tip is the contact, the
    /// cutter's shape does not matter.
    pub tool: Option<Tool>,
    /// Largest deviation of the contact point from its line.
    pub tolerance: Length,
    /// The source of contacts.
    pub contact: ContactSource,
    /// If the feed turns by more than this angle, an assumed contact belongs to another pass.
    pub pass_break: Angle,
    /// How the tip moves.
    pub correction: Correction,
    /// How blocks are divided.
    pub output: OutputForm,
    /// What the text does not state: unit, work offsets, tool length and the like.
    pub program: ProgramSetup,
    /// The largest speed of the tip that an F word may demand. `None`: [`Self::FEED_TIMES`] the programmed speed.
    pub max_feed: Option<Feedrate>,
    /// The shortest time that the control needs for a block \[s\], if it is known.
    pub block_time_s: Option<f64>,
    /// The limits of the computation.
    pub budget: Budget,
    /// The part's surface.
    pub part: Option<PartSurface>,
}

impl CcParameters {
    /// Smallest tolerance: a tenth of the last digit of five decimals.
    pub const MIN_TOLERANCE: Length = Length::from_mm(1e-6);
    /// Largest tolerance.
    pub const MAX_TOLERANCE: Length = Length::from_mm(10.0);

    /// Parts of a divided block run no faster than this number times the programmed feed. A higher speed comes from a
    /// contact that swings, not from the part.
    pub const FEED_TIMES: f64 = FEED_TIMES;

    /// The defaults of the contract for a tool: 10 µm, contact source found automatically, even correction, fewest
    /// blocks.
    #[must_use]
    pub fn new(tool: impl Into<Option<Tool>>, program: ProgramSetup) -> Self {
        Self {
            tool: tool.into(),
            tolerance: Length::from_mm(0.01),
            contact: ContactSource::Auto,
            pass_break: Angle::from_deg(ContactSource::PASS_BREAK_DEG),
            correction: Correction::Even,
            output: OutputForm::Minimal,
            program,
            max_feed: None,
            block_time_s: None,
            budget: Budget::default(),
            part: None,
        }
    }

    /// The same parameters with the tool of each section, for a program that was surveyed. `contact` is the source of
    /// contacts, with `auto` resolved.
    ///
    /// # Errors
    /// The cutting tool is not known, the program cannot be read, or the caller has stopped waiting.
    pub(in crate::process) fn with_tools(
        &self,
        surveyed: &Surveyed<'_>,
        machine: &Machine,
        stop: &Stop<'_>,
    ) -> Result<Self, Fault> {
        let Surveyed { source, survey, contact, .. } = *surveyed;
        let need = Need {
            cutter: contact != ContactSource::Tip,
            worn: false,
            is_for_one: false,
            stated_by: "`tool_radius_mm`",
            agreement: contact != ContactSource::Tip,
            leaves_unknown: true,
        };
        let program = self.program.with_tools(self.tool, need, &survey.tools, machine, source, stop)?;
        Ok(Self { program, ..self.clone() })
    }
}
