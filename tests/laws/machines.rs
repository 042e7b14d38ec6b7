//! Random machines and poses for the laws.

use proptest::prelude::*;
use trunnion::geometry::Vec3;
use trunnion::kinematics::{Setup, ToolPose};
use trunnion::machine::{LocationError, Machine, MachineParts, PRESETS, RotaryAxis, Side, Squareness};

/// A vector with components in ±`size`.
pub(crate) fn vector(size: f64) -> impl Strategy<Value = Vec3> {
    [-size..=size, -size..=size, -size..=size].prop_map(Vec3::from)
}

/// A direction, anywhere on the sphere.
pub(crate) fn direction() -> impl Strategy<Value = Vec3> {
    vector(1.0).prop_filter_map("too short", |v| (v.norm() > 0.1).then(|| v.normalize()))
}

/// A location error of the size found on real machines, and ten times it.
fn location_error() -> impl Strategy<Value = LocationError> {
    (vector(0.3), vector(5e-4))
        .prop_map(|(translation_mm, rotation_rad)| LocationError { translation_mm, rotation_rad })
}

fn squareness() -> impl Strategy<Value = Squareness> {
    vector(3e-4).prop_map(|v| Squareness { e_c0y_rad: v.x, e_b0z_rad: v.y, e_a0z_rad: v.z })
}

/// Points, errors and senses of a layout drawn at random.
fn measured(parts: MachineParts, errors: bool) -> impl Strategy<Value = Machine> {
    (
        [vector(200.0), vector(200.0)],
        [location_error(), location_error()],
        squareness(),
        [any::<bool>(), any::<bool>()],
    )
        .prop_filter_map("not a machine", move |(points, location_errors, squareness, reversed)| {
            let mut parts = parts.clone();
            for k in 0..2 {
                parts.rotary_axes[k].point_mm += points[k];
                parts.rotary_axes[k].reversed = reversed[k];
                if errors {
                    parts.rotary_axes[k].location_error = location_errors[k];
                    parts.squareness = squareness;
                }
            }
            Machine::new(parts).ok()
        })
}

/// Every preset, with random points, senses and errors.
pub(crate) fn preset_machine(errors: bool) -> impl Strategy<Value = Machine> {
    (0..PRESETS.len()).prop_flat_map(move |n| measured(PRESETS[n].parts(), errors))
}

/// Two axes of any direction on any side, no travels.
pub(crate) fn any_machine() -> impl Strategy<Value = Machine> {
    let side = || any::<bool>().prop_map(|table| if table { Side::Table } else { Side::Head });
    let directions = [direction(), direction()].prop_filter("cannot point the tool", |[a, b]| {
        a.cross(b).norm() > 0.02 && [a, b].iter().all(|d| d.cross(&Vec3::z()).norm() > 0.02)
    });
    (directions, [side(), side()]).prop_flat_map(|(directions, sides)| {
        let mut parts = PRESETS[0].parts();
        for k in 0..2 {
            parts.rotary_axes[k] = RotaryAxis {
                direction: directions[k],
                side: sides[k],
                travel_deg: None,
                ..parts.rotary_axes[k].clone()
            };
        }
        measured(parts, true)
    })
}

/// What is mounted.
pub(crate) fn setup() -> impl Strategy<Value = Setup> {
    (vector(300.0), 0.0..250.0).prop_map(|(work_offset_mm, tool_length_mm)| Setup {
        work_offset_mm,
        tool_length_mm,
        apply_errors: true,
    })
}

/// A pose anywhere.
pub(crate) fn pose() -> impl Strategy<Value = ToolPose> {
    (vector(300.0), direction()).prop_map(|(tip_mm, axis)| ToolPose { tip_mm, axis })
}
