//! Machine coordinates and reference positions of a control, as a profile states them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::reading::escape;
use super::{Fault, FaultList, Fixed};
use crate::description::ToSchema;
use crate::machine::{self, MAX_REFERENCE_POSITIONS, Machine};

/// Where the control's machine coordinates count from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MachineCoordinates {
    /// Place of the gauge point, with rotary axes at zero, when X Y Z stand at zero in machine coordinates.
    pub zero_mm: Fixed<3>,
    /// Whether the tool length in force counts in machine coordinates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool_length_counts: Option<bool>,
    /// Machine coordinates of G28, then of G30 P2, P3 and P4, by axis letter: mm or degrees.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schema(max_items = 4)]
    pub reference_positions: Vec<BTreeMap<String, f64>>,
    /// What the control adds to the origins that a program writes by G10 L2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub external_offset_mm: Option<Fixed<3>>,
    /// Z in machine coordinates at which `M140 MB MAX` ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub retract_z_mm: Option<f64>,
}

/// How many characters of a wrong letter an error shows.
const SHOWN: usize = 16;

impl MachineCoordinates {
    /// Checks the values; `rotary` has the letters of the rotary axes.
    pub(super) fn check(&self, rotary: &[&str], faults: &mut FaultList) {
        let at = "/machine_coordinates";
        for (place, value) in self.zero_mm.0.into_iter().enumerate() {
            let most = Machine::MAX_LENGTH_MM;
            faults.check_range(|| format!("{at}/zero_mm/{place}"), value, -most, most);
        }
        let external_mm = self.external_offset_mm.into_iter().flat_map(|offset| offset.0).enumerate();
        for (place, value) in external_mm {
            let most = Machine::MAX_LENGTH_MM;
            faults.check_range(|| format!("{at}/external_offset_mm/{place}"), value, -most, most);
        }
        if let Some(value) = self.retract_z_mm {
            let most = Machine::MAX_LENGTH_MM;
            faults.check_range(|| format!("{at}/retract_z_mm"), value, -most, most);
        }
        if self.reference_positions.len() > MAX_REFERENCE_POSITIONS {
            let count = self.reference_positions.len();
            let detail = format!(
                "{count} positions are too many: a control has those of G28 and of G30 P2, P3 and P4"
            );
            faults.push(|| Fault::new(format!("{at}/reference_positions"), detail));
        }
        for (place, position) in self.reference_positions.iter().enumerate().take(MAX_REFERENCE_POSITIONS) {
            for (letter, value) in position {
                let shown: String = letter.chars().take(SHOWN).collect();
                let pointer = || format!("{at}/reference_positions/{place}/{}", escape(&shown));
                let most = match letter.as_str() {
                    "X" | "Y" | "Z" => Machine::MAX_LENGTH_MM,
                    other if rotary.contains(&other) => Machine::MAX_TRAVEL_DEG,
                    _ => {
                        let there = rotary.join(" ");
                        faults.push(|| {
                            let detail = format!("the machine has no axis {shown:?}; it has X Y Z {there}");
                            Fault::new(pointer(), detail)
                        });
                        continue;
                    }
                };
                faults.check_range(pointer, *value, -most, most);
            }
        }
    }

    /// The same without negative zeros, so that a profile that says the same is the same revision.
    pub(super) fn without_negative_zeros(self) -> Self {
        let positive = |position: BTreeMap<String, f64>| {
            position.into_iter().map(|(letter, value)| (letter, value + 0.0)).collect()
        };
        Self {
            zero_mm: Fixed(self.zero_mm.0.map(|value| value + 0.0)),
            reference_positions: self.reference_positions.into_iter().map(positive).collect(),
            external_offset_mm: self
                .external_offset_mm
                .map(|offset| Fixed(offset.0.map(|value| value + 0.0))),
            retract_z_mm: self.retract_z_mm.map(|value| value + 0.0),
            ..self
        }
    }

    /// The same in the core's terms; `rotary` has the letters of the rotary axes in the profile's order.
    pub(super) fn to_core(&self, rotary: &[char]) -> machine::MachineCoordinates {
        let letters = || "XYZ".chars().chain(rotary.iter().copied());
        let in_order = |position: &BTreeMap<String, f64>| {
            let mut axes = [None; 5];
            for (axis, letter) in axes.iter_mut().zip(letters()) {
                *axis = position.get(letter.to_string().as_str()).copied();
            }
            axes
        };
        machine::MachineCoordinates {
            zero_mm: self.zero_mm.0,
            length_counts: self.tool_length_counts,
            references: self.reference_positions.iter().map(in_order).collect(),
            external_mm: self.external_offset_mm.map(|offset| offset.0),
            retract_z_mm: self.retract_z_mm,
        }
    }
}
