//! From lines to location errors.

use super::LocationFault;
use crate::calibration::{CommonPerpendicular, ErrorParameter, rotation_vector_rad};
use crate::geometry::{Mat3, RigidMotion, Screw, Vec3, across, angle_between, shortest_turn_rad};
use crate::machine::{LocationError, Machine};

/// A line farther than this from its nominal direction is not a location error \[rad\]: the sum that both axes of a
/// chain may reach.
const MAX_ANGLE_RAD: f64 = 2.0 * Machine::MAX_ERROR_RAD;

/// A direction shorter than this is not valid.
const MIN_LENGTH: f64 = 1e-9;

/// The cascaded location errors of both axes with which `machine` has these lines. Lines are in the profile's order
/// and frames (M; head lines relative to the gauge point), in the sense of the nominal directions. Exact: nothing
/// is linearised. Errors in mm and rad.
///
/// An axis without a line keeps its error. If both axes of one side have lines, the inner axis (next to bed or ram)
/// takes all six components. The outer axis takes the missing two: a shift along, and a turn about, the common
/// perpendicular of the nominal directions (P4's choice: of an AC table A takes six and C takes `e_y`, `e_b`). A
/// line that is alone on its side, or the only one measured, gives its axis four components, none along or about
/// itself.
///
/// # Errors
/// Every invalid line or line too far from nominal, parallel lines, components beyond the limits of a profile.
pub fn location_errors(
    machine: &Machine,
    lines: [Option<Screw>; 2],
) -> Result<[LocationError; 2], Vec<LocationFault>> {
    let mut faults = Vec::new();
    let nominal = machine.screws(false);
    let lines: [Option<Screw>; 2] = std::array::from_fn(|axis| {
        let line = lines[axis]?;
        match checked(&line, &nominal[axis], axis) {
            Ok(line) => Some(line),
            Err(fault) => {
                faults.push(fault);
                None
            }
        }
    });
    if !faults.is_empty() {
        return Err(faults);
    }
    let axes = machine.rotary_axes();
    let mut errors = [0, 1].map(|axis| axes[axis].location_error);
    let one_chain = axes[0].side == axes[1].side;
    match lines {
        [Some(inner), Some(outer)] if one_chain => {
            errors = chain(&nominal, &[inner, outer]).ok_or_else(|| vec![LocationFault::Parallel])?;
        }
        _ => {
            for axis in 0..2 {
                if let Some(line) = lines[axis] {
                    let carried = one_chain && axis == 1;
                    let carrier = if carried {
                        errors[0].displacement(axes[0].point_mm)
                    } else {
                        RigidMotion::identity()
                    };
                    errors[axis] = alone(&nominal[axis], &undone(&line, &carrier));
                }
            }
        }
    }
    for parameter in ErrorParameter::every() {
        let ErrorParameter { axis, component } = parameter;
        let (value, max_abs) = (parameter.value(&errors), parameter.max_abs());
        if !(-max_abs..=max_abs).contains(&value) {
            faults.push(LocationFault::TooLarge { axis, component, value, max_abs });
        }
    }
    if faults.is_empty() { Ok(errors) } else { Err(faults) }
}

/// The line with a unit direction.
fn checked(line: &Screw, nominal: &Screw, axis: usize) -> Result<Screw, LocationFault> {
    let max = Machine::MAX_LENGTH_MM;
    let sound = line.direction.iter().chain(line.point_mm.iter()).all(|value| (-max..=max).contains(value));
    let length = line.direction.norm();
    if !sound || length < MIN_LENGTH {
        return Err(LocationFault::NoLine { axis });
    }
    let direction = line.direction / length;
    let angle_rad = angle_between(direction, nominal.direction);
    if angle_rad > MAX_ANGLE_RAD {
        return Err(LocationFault::DirectionFar { axis, angle_rad, max_rad: MAX_ANGLE_RAD });
    }
    Ok(Screw { direction, point_mm: line.point_mm })
}

/// The line before a motion displaced it.
fn undone(line: &Screw, motion: &RigidMotion) -> Screw {
    let back = motion.rotation.transpose();
    Screw {
        direction: (back * line.direction).normalize(),
        point_mm: back * (line.point_mm - motion.shift_mm),
    }
}

/// Four components: the shortest turn, and the shift of the reference point across the axis.
fn alone(nominal: &Screw, line: &Screw) -> LocationError {
    let rotation = shortest_turn_rad(nominal.direction, line.direction);
    let along =
        (nominal.point_mm - line.point_mm).dot(&nominal.direction) / line.direction.dot(&nominal.direction);
    let shift = line.point_mm + line.direction * along - nominal.point_mm;
    // −0 becomes 0.
    let without = |v: Vec3| across(v, nominal.direction).map(|value| value + 0.0);
    LocationError { translation_mm: without(shift), rotation_rad: without(rotation) }
}

/// Six components of the inner axis, two of the outer one; `None` if two lines are parallel.
fn chain(nominal: &[Screw; 2], lines: &[Screw; 2]) -> Option<[LocationError; 2]> {
    let [inner, outer] = nominal;
    let designed = CommonPerpendicular::of(inner, outer)?;
    let real = CommonPerpendicular::of(&lines[0], &lines[1])?;
    // The outer axis gives the two lines their real angle and distance: about and along the perpendicular, from its
    // reference point.
    let perpendicular = designed.direction;
    let distance_mm = (outer.point_mm - inner.point_mm).dot(&perpendicular);
    let outer_error = LocationError {
        translation_mm: (perpendicular * (real.distance_mm - distance_mm)).map(|value| value + 0.0),
        rotation_rad: (perpendicular * (real.angle_rad - designed.angle_rad)).map(|value| value + 0.0),
    };
    let moved = outer_error.displacement(outer.point_mm);
    let moved = outer.displaced(&moved.rotation, moved.shift_mm);
    let between = CommonPerpendicular::of(inner, &moved)?;
    // The inner axis then carries both lines, as one body, to their real positions.
    let frame = |direction: Vec3, perpendicular: Vec3| {
        Mat3::from_columns(&[direction, perpendicular, direction.cross(&perpendicular)])
    };
    let rotation =
        frame(lines[0].direction, real.direction) * frame(inner.direction, between.direction).transpose();
    let carried = rotation * (inner.point_mm - between.feet_mm[0]) + real.feet_mm[0];
    let inner_error = LocationError {
        translation_mm: carried - inner.point_mm,
        rotation_rad: rotation_vector_rad(&rotation),
    };
    Some([inner_error, outer_error])
}
