//! A cutter in a request about wear.

use serde::{Deserialize, Serialize};

use super::{Fault, FaultList};
use crate::description::ToSchema;
use crate::machine::{Tool, ToolFault};
use crate::units::Length;
use crate::wear::CutterWear;

/// A cutter, nominal or as measured.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = WearTool)]
pub struct ToolDoc {
    /// Cutter radius.
    #[schema(example = 5.0)]
    pub radius_mm: f64,
    /// Corner radius: equal to the radius for a ball (the default), 0 for a flat cutter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_radius_mm: Option<f64>,
    /// Length. The control keeps the nominal length if both cutters have one, else the measured length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_mm: Option<f64>,
}

/// Longest tool that is accepted \[mm\].
const MAX_LENGTH_MM: f64 = 10_000.0;

impl ToolDoc {
    /// The cutter; faults are added to `faults` under `pointer`.
    pub fn to_core(self, pointer: &str, faults: &mut FaultList) -> Option<Tool> {
        if let Some(length_mm) = self.length_mm {
            faults.check_range(|| format!("{pointer}/length_mm"), length_mm, 0.0, MAX_LENGTH_MM);
        }
        let corner_mm = self.corner_radius_mm.unwrap_or(self.radius_mm);
        match Tool::new(Length::from_mm(self.radius_mm), Length::from_mm(corner_mm)) {
            Ok(tool) => Some(tool),
            Err(fault) => {
                let member = match fault {
                    ToolFault::Radius { .. } => "radius_mm",
                    ToolFault::CornerRadius { .. } => "corner_radius_mm",
                };
                faults.push(|| Fault::new(format!("{pointer}/{member}"), fault.to_string()));
                None
            }
        }
    }

    /// If one of two cutters is stated not to be a ball, the other's corner radius must be stated too: a
    /// measured radius alone does not mean that the corner has become a ball.
    pub fn check_corners(nominal: &Self, actual: &Self, faults: &mut FaultList) {
        for (tool, other, pointer) in [
            (actual, nominal, "/actual_tool/corner_radius_mm"),
            (nominal, actual, "/nominal_tool/corner_radius_mm"),
        ] {
            let is_no_ball = other.corner_radius_mm.is_some_and(|corner_mm| corner_mm < other.radius_mm);
            if tool.corner_radius_mm.is_none() && is_no_ball {
                faults.push(|| {
                    Fault::new(
                        pointer,
                        "missing: the other cutter is not a ball, so state the corner radius of this one",
                    )
                });
            }
        }
    }

    /// A worn cutter against its nominal one; faults are added to `faults`.
    pub fn wear(nominal: &Self, actual: &Self, faults: &mut FaultList) -> Option<CutterWear> {
        Self::check_corners(nominal, actual, faults);
        let tools = [nominal.to_core("/nominal_tool", faults), actual.to_core("/actual_tool", faults)];
        let shorter_mm = nominal.length_mm.zip(actual.length_mm).map_or(0.0, |(full, left)| full - left);
        let [Some(nominal), Some(actual)] = tools else { return None };
        Some(CutterWear { nominal, actual, shorter_by: Length::from_mm(shorter_mm) })
    }
}
