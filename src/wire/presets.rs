//! Starting points for a profile.

use serde::Serialize;
use utoipa::ToSchema;

use super::{
    Fixed, Kinematics, LinearLimits, LocationErrorDoc, MachineProfile, RotaryAxisDoc, SideDoc, SquarenessDoc,
};

/// A common layout, ready to be put after its numbers are filled in.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Preset {
    /// Its name.
    #[schema(example = "ac-table")]
    pub id: &'static str,
    /// In a few words.
    pub title: &'static str,
    /// What to fill in.
    pub description: &'static str,
    /// The profile.
    pub profile: MachineProfile,
}

/// A row of the list: id, title, description, and the axes.
type Row =
    (&'static str, &'static str, &'static str, [(&'static str, SideDoc, [f64; 3], Option<[f64; 2]>); 2]);

const ROWS: [Row; 2] = [
    (
        "ac-table",
        "AC trunnion table",
        "A about X carries C about Z; both turn the workpiece. Set the points of both axes.",
        [
            ("A", SideDoc::Table, [1.0, 0.0, 0.0], Some([-120.0, 120.0])),
            ("C", SideDoc::Table, [0.0, 0.0, 1.0], None),
        ],
    ),
    (
        "bc-head",
        "BC fork head",
        "C about Z carries B about Y; both turn the tool. Set B's point to the pivot above the gauge point.",
        [
            ("C", SideDoc::Head, [0.0, 0.0, 1.0], Some([-360.0, 360.0])),
            ("B", SideDoc::Head, [0.0, 1.0, 0.0], Some([-110.0, 110.0])),
        ],
    ),
];

/// Every preset.
#[must_use]
pub fn presets() -> Vec<Preset> {
    ROWS.iter()
        .map(|(id, title, description, axes)| {
            let rotary_axes = axes
                .iter()
                .map(|(name, side, direction, limits)| RotaryAxisDoc {
                    name: (*name).to_owned(),
                    side: *side,
                    direction: Fixed(*direction),
                    point_mm: Fixed([0.0; 3]),
                    limits_deg: limits.map(Fixed),
                    reversed: false,
                    location_error: LocationErrorDoc::default(),
                })
                .collect();
            let kinematics = Kinematics {
                rotary_axes,
                linear_limits_mm: LinearLimits::default(),
                squareness_urad: SquarenessDoc::default(),
            };
            let name = (*title).to_owned();
            let profile = MachineProfile { name, kinematics, interpolation_period_s: 0.002, drives: None };
            Preset { id, title, description, profile }
        })
        .collect()
}

/// The machine an empty store begins with: A and C tables through the origin, nothing limited but A, no errors.
#[must_use]
pub fn example_profile() -> MachineProfile {
    let axis = |name: &str, direction, limits_deg| RotaryAxisDoc {
        name: name.to_owned(),
        side: SideDoc::Table,
        direction: Fixed(direction),
        point_mm: Fixed([0.0; 3]),
        limits_deg,
        reversed: false,
        location_error: LocationErrorDoc::default(),
    };
    MachineProfile {
        name: "Example AC table".to_owned(),
        kinematics: Kinematics {
            rotary_axes: vec![
                axis("A", [1.0, 0.0, 0.0], Some(Fixed([-120.0, 120.0]))),
                axis("C", [0.0, 0.0, 1.0], None),
            ],
            linear_limits_mm: LinearLimits::default(),
            squareness_urad: SquarenessDoc::default(),
        },
        interpolation_period_s: 0.002,
        drives: None,
    }
}
