//! What a wear compensation is asked to do.

use crate::contact::PartSurface;
use crate::machine::{Machine, Side, Tool};
use crate::process::contact_path::CcParameters;
use crate::process::set_up::{Budget, ContactSource, ProgramSetup};
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
    /// What the text does not say, with the nominal tool length.
    pub program: ProgramSetup,
    /// What the search for contacts may cost.
    pub budget: Budget,
    /// The part's surface.
    pub part: Option<PartSurface>,
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
