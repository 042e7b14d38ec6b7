//! The common layouts of five-axis machines, as rows of data to start a profile from.

use super::{LocationError, MachineParts, RotaryAxis, RotaryLetter, Side, Squareness, Travel};
use crate::geometry::Vec3;

/// One layout: a profile with plausible travels, to be filled with the measured points of a real machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Preset {
    /// Short name, usable as a machine id.
    pub id: &'static str,
    /// Name for a list.
    pub title: &'static str,
    /// Description of what each axis carries, in order.
    pub description: &'static str,
    axes: [PresetAxis; 2],
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct PresetAxis {
    letter: RotaryLetter,
    side: Side,
    /// Normalised together with the profile.
    direction: [f64; 3],
    point_mm: [f64; 3],
    travel_deg: Option<[f64; 2]>,
}

/// The id of the machine in a new store.
pub const EXAMPLE_ID: &str = "example-ac-table";

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];
const ORIGIN: [f64; 3] = [0.0; 3];
/// Pivot above the gauge point, at a usual distance for fork and nutating heads.
const PIVOT: [f64; 3] = [0.0, 0.0, 150.0];

const fn table(letter: RotaryLetter, direction: [f64; 3], travel_deg: Option<[f64; 2]>) -> PresetAxis {
    PresetAxis { letter, side: Side::Table, direction, point_mm: ORIGIN, travel_deg }
}

const fn head(letter: RotaryLetter, direction: [f64; 3], travel_deg: Option<[f64; 2]>) -> PresetAxis {
    PresetAxis { letter, side: Side::Head, direction, point_mm: PIVOT, travel_deg }
}

const TILT: Option<[f64; 2]> = Some([-120.0, 120.0]);
const HEAD_TILT: Option<[f64; 2]> = Some([-110.0, 110.0]);
const WOUND: Option<[f64; 2]> = Some([-360.0, 360.0]);
const NUTATION: Option<[f64; 2]> = Some([-180.0, 180.0]);

use RotaryLetter::{A, B, C};

/// All layouts. Table axes are listed from the bed outward, head axes from the ram outward.
pub const PRESETS: [Preset; 13] = [
    Preset {
        id: EXAMPLE_ID,
        title: "Example: trunnion table A C",
        description: "A and C tables through the machine origin, C without end, no errors",
        axes: [table(A, X, TILT), table(C, Z, None)],
    },
    Preset {
        id: "ac-table",
        title: "Trunnion table A C",
        description: "A cradle on the bed tilts about X and carries the rotary table C",
        axes: [table(A, X, TILT), table(C, Z, None)],
    },
    Preset {
        id: "bc-table",
        title: "Trunnion table B C",
        description: "A cradle on the bed tilts about Y and carries the rotary table C",
        axes: [table(B, Y, TILT), table(C, Z, None)],
    },
    Preset {
        id: "ab-table",
        title: "Rotary table A on rotary table B",
        description: "B turns about Y on the bed and carries the rotary axis A about X",
        axes: [table(B, Y, None), table(A, X, TILT)],
    },
    Preset {
        id: "ac-head",
        title: "Fork head C A",
        description: "C turns under the ram and carries the fork A with the spindle",
        axes: [head(C, Z, WOUND), head(A, X, HEAD_TILT)],
    },
    Preset {
        id: "bc-head",
        title: "Fork head C B",
        description: "C turns under the ram and carries the fork B with the spindle",
        axes: [head(C, Z, WOUND), head(B, Y, HEAD_TILT)],
    },
    Preset {
        id: "a-head-c-table",
        title: "Swivel head A, rotary table C",
        description: "The spindle tilts about X, the table turns about Z",
        axes: [head(A, X, HEAD_TILT), table(C, Z, None)],
    },
    Preset {
        id: "b-head-c-table",
        title: "Swivel head B, rotary table C",
        description: "The spindle tilts about Y, the table turns about Z",
        axes: [head(B, Y, HEAD_TILT), table(C, Z, None)],
    },
    Preset {
        id: "b-head-a-table",
        title: "Swivel head B, rotary table A",
        description: "The spindle tilts about Y, the workpiece turns about X as on a mill-turn machine",
        axes: [head(B, Y, HEAD_TILT), table(A, X, None)],
    },
    Preset {
        id: "nutating-b-head-c-table",
        title: "45° nutating head B, rotary table C",
        description: "The spindle nutates about a line halfway between −Y and Z, the table turns about Z",
        axes: [head(B, [0.0, -1.0, 1.0], NUTATION), table(C, Z, None)],
    },
    Preset {
        id: "nutating-bc-table",
        title: "45° nutating table B C",
        description: "B nutates about a line halfway between Y and Z and carries the rotary table C",
        axes: [table(B, [0.0, 1.0, 1.0], NUTATION), table(C, Z, None)],
    },
    Preset {
        id: "nutating-ac-head",
        title: "45° nutating head C A",
        description: "C turns under the ram and carries A, which nutates about a line halfway between X and Z",
        axes: [head(C, Z, WOUND), head(A, [1.0, 0.0, 1.0], NUTATION)],
    },
    Preset {
        id: "nutating-a-head-b-table",
        title: "45° nutating head A, rotary table B",
        description: "The spindle nutates about a line halfway between X and Z, the table turns about Y",
        axes: [head(A, [1.0, 0.0, 1.0], NUTATION), table(B, Y, None)],
    },
];

impl Preset {
    /// The layout with this id.
    #[must_use]
    pub fn by_id(id: &str) -> Option<&'static Self> {
        const ROWS: &[Preset] = &PRESETS;
        ROWS.iter().find(|preset| preset.id == id)
    }

    /// The layout as parts of a profile: X Y Z unlimited, no errors, interpolation period 2 ms.
    #[must_use]
    pub fn parts(&self) -> MachineParts {
        MachineParts {
            name: self.title.to_owned(),
            rotary_axes: self.axes.iter().map(PresetAxis::rotary_axis).collect(),
            linear_travel_mm: [None; 3],
            squareness: Squareness::default(),
            interpolation_period_s: 0.002,
        }
    }
}

impl PresetAxis {
    fn rotary_axis(&self) -> RotaryAxis {
        RotaryAxis {
            letter: self.letter,
            side: self.side,
            direction: Vec3::from(self.direction).normalize(),
            point_mm: Vec3::from(self.point_mm),
            travel_deg: self.travel_deg.map(|[min, max]| Travel { min, max }),
            reversed: false,
            location_error: LocationError::default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::Machine;

    #[test]
    fn every_preset_is_a_machine_and_no_id_repeats() {
        for (n, preset) in PRESETS.iter().enumerate() {
            assert!(Machine::new(preset.parts()).is_ok(), "{}", preset.id);
            assert!(PRESETS[..n].iter().all(|other| other.id != preset.id), "{}", preset.id);
            assert_eq!(Preset::by_id(preset.id), Some(preset));
        }
    }
}
