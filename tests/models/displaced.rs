//! Machines with location errors, and where these put the axes, worked out with rotation matrices.

use nalgebra::Rotation3;
use trunnion::geometry::Vec3;
use trunnion::machine::{LocationError, Machine, MachineParts, RotaryAxis};

/// Errors of a pair of tables as a calibration finds them.
pub(crate) fn errors() -> [LocationError; 2] {
    [
        LocationError {
            translation_mm: Vec3::new(0.012, -0.021, 0.034),
            rotation_rad: Vec3::new(4.1e-5, -6.3e-5, 2.9e-5),
        },
        LocationError {
            translation_mm: Vec3::new(0.0, 0.045, 0.0),
            rotation_rad: Vec3::new(0.0, 8.1e-5, 0.0),
        },
    ]
}

/// The machine with these errors.
pub(crate) fn with_errors(machine: &Machine, errors: [LocationError; 2]) -> Machine {
    let axes = machine.rotary_axes().iter().zip(errors);
    Machine::new(MachineParts {
        name: machine.name().to_owned(),
        rotary_axes: axes
            .map(|(axis, location_error)| RotaryAxis { location_error, ..axis.clone() })
            .collect(),
        linear_travel_mm: *machine.linear_travel_mm(),
        squareness: *machine.squareness(),
        interpolation_period_s: machine.interpolation_period_s(),
    })
    .expect("a machine")
}

/// Direction and point of a line.
pub(crate) type Line = (Vec3, Vec3);

/// The lines of two table axes, displaced: the first by its own error, the second by the first's and its own, each
/// about the reference point of its axis.
pub(crate) fn displaced(lines: [Line; 2], errors: [LocationError; 2]) -> [Line; 2] {
    let moved = |error: &LocationError, about: Vec3, line: Line| {
        let turn = Rotation3::new(error.rotation_rad);
        (turn * line.0, turn * (line.1 - about) + about + error.translation_mm)
    };
    let [first, second] = lines;
    let own = moved(&errors[1], second.1, second);
    [moved(&errors[0], first.1, first), moved(&errors[0], first.1, own)]
}
