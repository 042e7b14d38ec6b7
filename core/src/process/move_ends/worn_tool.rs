//! A worn cutter, with the nominal cutter for which the program was made.

use super::parameters::{Milling, WornCutter};
use crate::machine::Tool;
use crate::units::Length;
use crate::wear::CutterWear;

/// A worn cutter, with the nominal cutter for which the program was made.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct WornTool {
    pub(super) nominal: Tool,
    pub(super) worn: WornCutter,
    pub(super) milling: Milling,
    /// ΔL as far as the control does not know of it.
    pub(super) unknown_to_control: Length,
}

impl WornTool {
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

    /// The cutter that cuts. With a wear table, the nominal one.
    pub(super) fn actual(&self) -> Tool {
        match &self.worn {
            WornCutter::Tool(tool) => *tool,
            WornCutter::Table(_) => self.nominal,
        }
    }

    /// The wear in the form for the formulas of a tool (R, r). With a table: the nominal cutter and the length.
    pub(super) fn cutter_wear(&self) -> CutterWear {
        CutterWear { nominal: self.nominal, actual: self.actual(), shorter_by: self.unknown_to_control }
    }
}
