//! What a wear compensation is asked to do.

use super::super::ContactSource;
use crate::contact::PartSurface;
use crate::kinematics::Setup;
use crate::machine::{Machine, Side, Tool};
use crate::motion::Interpolation;
use crate::program::Dialect;
use crate::units::{Feedrate, Length};
use crate::wear::{CutterWear, WearTable};

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
    /// The cutter (R, r) the program was made for.
    pub nominal: Tool,
    /// The cutter that cuts.
    pub worn: WornCutter,
    /// End or flank.
    pub milling: Milling,
    /// ΔL = L − L′; 0 where the lengths are not given.
    pub shorter_by: Length,
    /// Which of the two lengths the control has.
    pub length_in_control: LengthInControl,
    /// Where contacts come from; the tip is none.
    pub contact: ContactSource,
    /// Who interpolates; `None` takes it from the program's own switches.
    pub interpolation: Option<Interpolation>,
    /// The T number of the cutter, in a program of several; the others' motions stay as they are.
    pub tool_number: Option<u32>,
    /// Work offset, nominal tool length, location errors.
    pub setup: Setup,
    /// Feedrate where the program has none.
    pub feed: Option<Feedrate>,
    /// The dialect; `None` detects it.
    pub dialect: Option<Dialect>,
    /// The part's surface.
    pub part: Option<PartSurface>,
}

impl WearParameters {
    /// End milling with the worn cutter's own length in the control, contact found by itself.
    #[must_use]
    pub fn new(nominal: Tool, worn: WornCutter) -> Self {
        Self {
            nominal,
            worn,
            milling: Milling::End,
            shorter_by: Length::ZERO,
            length_in_control: LengthInControl::Nominal,
            contact: ContactSource::Auto,
            interpolation: None,
            tool_number: None,
            setup: Setup::default(),
            feed: None,
            dialect: None,
            part: None,
        }
    }

    /// ΔL as far as the control does not know of it.
    pub(super) fn unknown_to_control(&self) -> Length {
        match self.length_in_control {
            LengthInControl::Nominal => self.shorter_by,
            LengthInControl::Measured => Length::ZERO,
        }
    }

    /// The set-up under which the written program runs.
    pub(super) fn written_setup(&self) -> Setup {
        let shorter_mm = (self.shorter_by - self.unknown_to_control()).mm();
        Setup { tool_length_mm: self.setup.tool_length_mm - shorter_mm, ..self.setup }
    }

    /// Whether the length alone moves the words of every point, rapids too.
    pub(super) fn moves_everything(&self, machine: &Machine) -> bool {
        let has_head = machine.rotary_axes().iter().any(|axis| axis.side == Side::Head);
        let shorter_mm = self.shorter_by.mm().abs();
        shorter_mm > 0.0 && (has_head || self.length_in_control == LengthInControl::Nominal)
    }

    /// Whether the worn cutter has the nominal one's shape.
    pub(super) fn has_nominal_shape(&self) -> bool {
        match &self.worn {
            WornCutter::Tool(tool) => *tool == self.nominal,
            WornCutter::Table(table) => table.is_zero(),
        }
    }

    /// Whether the worn cutter, tip on tip, reaches beyond the nominal one anywhere.
    pub(super) fn is_larger(&self) -> bool {
        match &self.worn {
            WornCutter::Tool(tool) => {
                tool.radius() > self.nominal.radius() || tool.core_radius() > self.nominal.core_radius()
            }
            WornCutter::Table(table) => table.is_above_zero(),
        }
    }

    /// The wear as the formulas of tool (R, r) take it; of a table the nominal cutter and the length.
    pub(super) fn cutter_wear(&self) -> CutterWear {
        let actual = match &self.worn {
            WornCutter::Tool(tool) => *tool,
            WornCutter::Table(_) => self.nominal,
        };
        CutterWear { nominal: self.nominal, actual, shorter_by: self.unknown_to_control() }
    }
}
