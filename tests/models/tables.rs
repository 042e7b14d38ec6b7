//! The plain machine of tests: two rotary tables through the machine's origin, no limits, no errors.

use trunnion::geometry::Vec3;
use trunnion::machine::{LocationError, Machine, MachineParts, RotaryAxis, RotaryLetter, Side, Squareness};

/// Tables about the axes of their letters, the first next to the bed; `reversed` ones count opposite to ISO 841.
pub(crate) fn tables(letters: [RotaryLetter; 2], reversed: bool) -> Machine {
    let axis = |letter| RotaryAxis {
        letter,
        side: Side::Table,
        direction: match letter {
            RotaryLetter::A => Vec3::x(),
            RotaryLetter::B => Vec3::y(),
            RotaryLetter::C => Vec3::z(),
        },
        point_mm: Vec3::zeros(),
        travel_deg: None,
        reversed,
        location_error: LocationError::default(),
    };
    Machine::new(MachineParts {
        name: "tables".to_owned(),
        rotary_axes: letters.map(axis).to_vec(),
        linear_travel_mm: [None; 3],
        squareness: Squareness::default(),
        interpolation_period_s: 0.002,
    })
    .expect("a plain machine")
}
