//! The parameters of moved ends. Without wear, those of the cutter are not used.

use crate::contact::PartSurface;
use crate::machine::{Machine, Side, Tool};
use crate::process::set_up::{Budget, ContactSource, ProgramSetup};
use crate::units::{Angle, Length};
use crate::wear::WearTable;

/// The part of the cutter that makes the surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Milling {
    /// The end: the corner, or the flat.
    #[default]
    End,
    /// The flank.
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
    /// A cutter given by its own radii.
    Tool(Tool),
    /// The nominal cutter with a deviation that varies along the corner.
    Table(WearTable),
}

/// The tool length in the control while the written program runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LengthInControl {
    /// The length of the nominal cutter: the tip must be commanded lower.
    #[default]
    Nominal,
    /// The length of the worn cutter.
    Measured,
}

/// The parameters of a wear compensation.
#[derive(Debug, Clone, PartialEq)]
pub struct WearParameters {
    /// The cutter (R, r) for which the program was made. `None`: each section takes its own from the machine's tool
    /// table.
    pub nominal: Option<Tool>,
    /// The cutter that cuts. `None`: as in the tool table.
    pub worn: Option<WornCutter>,
    /// End or flank.
    pub milling: Milling,
    /// ΔL = L − L′; 0 if the lengths are missing.
    pub shorter_by: Length,
    /// Which of the two lengths is in the control.
    pub length_in_control: LengthInControl,
    /// Where contacts come from. The tip is not a contact of a cutter whose shape is worn.
    pub contact: ContactSource,
    /// If the feed turns by more than this angle, an assumed contact belongs to another pass.
    pub pass_break: Angle,
    /// What the text does not state, with the nominal tool length.
    pub program: ProgramSetup,
    /// The limits of the search for contacts.
    pub budget: Budget,
    /// The part's surface.
    pub part: Option<PartSurface>,
}

impl WearParameters {
    /// The defaults: end milling, the nominal cutter's length in the control, contact source found automatically.
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
            pass_break: Angle::from_deg(ContactSource::PASS_BREAK_DEG),
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

    /// Whether the length alone changes the words of every point, including those of rapids.
    pub(super) fn moves_everything(&self, machine: &Machine) -> bool {
        let has_head = machine.rotary_axes().iter().any(|axis| axis.side == Side::Head);
        let shorter_mm = self.shorter_by.mm().abs();
        shorter_mm > 0.0 && (has_head || self.length_in_control == LengthInControl::Nominal)
    }
}
