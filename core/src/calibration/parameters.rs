//! The location errors that readings can determine, and the axes' lines as functions of them.

use crate::geometry::{Mat3, RigidMotion, Screw, Vec3};
use crate::machine::{LocationError, Machine};
use crate::units::{UM_PER_MM, URAD_PER_RAD};

/// Names of the components of a location error, each with its reported unit.
pub const COMPONENT_NAMES: [&str; 6] = ["e_x_um", "e_y_um", "e_z_um", "e_a_urad", "e_b_urad", "e_c_urad"];

/// The factor from the computed unit of a component (0–5) to the reported one: µm per mm, µrad per rad.
#[must_use]
pub const fn told_per_unit(component: usize) -> f64 {
    if component < 3 { UM_PER_MM } else { URAD_PER_RAD }
}

/// One component of one axis' location error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct ErrorParameter {
    /// The axis, in the profile's order.
    pub axis: usize,
    /// 0–2 `e_x e_y e_z` \[mm\], 3–5 `e_a e_b e_c` \[rad\].
    pub component: usize,
}

impl ErrorParameter {
    /// All components of both axes, those of the first axis first.
    pub fn every() -> impl Iterator<Item = Self> {
        (0..2).flat_map(|axis| (0..6).map(move |component| Self { axis, component }))
    }

    /// Whether it is a rotation.
    #[must_use]
    pub fn is_angle(&self) -> bool {
        self.component >= 3
    }

    /// Its value in `errors` \[mm or rad\].
    #[must_use]
    pub fn value(&self, errors: &[LocationError; 2]) -> f64 {
        let error = &errors[self.axis];
        match self.component {
            component @ 0..3 => error.translation_mm[component],
            component => error.rotation_rad[component - 3],
        }
    }

    /// Largest magnitude that a profile accepts as an error \[mm or rad\].
    pub(super) fn max_abs(&self) -> f64 {
        if self.is_angle() { Machine::MAX_ERROR_RAD } else { Machine::MAX_ERROR_MM }
    }

    /// Sets this component of `errors` to `value` \[mm or rad\].
    pub(super) fn set(&self, errors: &mut [LocationError; 2], value: f64) {
        let error = &mut errors[self.axis];
        match self.component {
            component @ 0..3 => error.translation_mm[component] = value,
            component => error.rotation_rad[component - 3] = value,
        }
    }
}

/// Derivative of a line by one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ScrewSlope {
    /// Change of the unit direction, per mm or rad.
    pub(super) direction: Vec3,
    /// Change of the carried reference point \[mm\] per mm or rad.
    pub(super) point_mm: Vec3,
}

const STILL: ScrewSlope =
    ScrewSlope { direction: Vec3::new(0.0, 0.0, 0.0), point_mm: Vec3::new(0.0, 0.0, 0.0) };

/// The lines of both axes with given errors, and their derivatives by each of the twelve components.
#[derive(Debug, Clone)]
pub(super) struct MovedLines {
    /// The lines, in the profile's order.
    pub(super) screws: [Screw; 2],
    slopes: [[ScrewSlope; 12]; 2],
}

impl MovedLines {
    /// Exact derivatives of [`Machine::screws_with`]. A small change of a rotation vector turns by the left
    /// Jacobian of the rotation, about the displaced reference point.
    pub(super) fn new(machine: &Machine, errors: &[LocationError; 2]) -> Self {
        let screws = machine.screws_with(errors);
        let axes = machine.rotary_axes();
        let mut slopes = [[STILL; 12]; 2];
        for parameter in ErrorParameter::every() {
            let ErrorParameter { axis: moved, component } = parameter;
            // The axes inboard of the moved frame carry its change into M.
            let inboard = (0..moved)
                .filter(|inner| axes[*inner].side == axes[moved].side)
                .fold(RigidMotion::identity(), |chain, inner| {
                    chain.after(&errors[inner].displacement(axes[inner].point_mm))
                });
            let unit = Vec3::ith(component % 3, 1.0);
            for (line, slope) in slopes.iter_mut().enumerate() {
                if line < moved || axes[line].side != axes[moved].side {
                    continue;
                }
                slope[moved * 6 + component] = if parameter.is_angle() {
                    let turn = inboard.rotation * (left_jacobian(errors[moved].rotation_rad) * unit);
                    let about_mm = inboard.rotation * (axes[moved].point_mm + errors[moved].translation_mm)
                        + inboard.shift_mm;
                    ScrewSlope {
                        direction: turn.cross(&screws[line].direction),
                        point_mm: turn.cross(&(screws[line].point_mm - about_mm)),
                    }
                } else {
                    ScrewSlope { direction: Vec3::zeros(), point_mm: inboard.rotation * unit }
                };
            }
        }
        Self { screws, slopes }
    }

    /// The derivative of the line of `axis` by `parameter`.
    pub(super) fn slope(&self, axis: usize, parameter: ErrorParameter) -> ScrewSlope {
        self.slopes[axis][parameter.axis * 6 + parameter.component]
    }
}

/// The left Jacobian of the rotation with this rotation vector: `R(ω + dω) = R(J dω) R(ω)` for small dω.
fn left_jacobian(rotation_rad: Vec3) -> Mat3 {
    let angle_squared = rotation_rad.norm_squared();
    // (1 − cos θ)/θ² and (θ − sin θ)/θ³ as series. Location errors stay below 0.1 rad (three components of 0.05),
    // where the omitted terms are below 1e-10; a slope needs no more.
    let first = 0.5 - angle_squared * (1.0 / 24.0 - angle_squared / 720.0);
    let second = 1.0 / 6.0 - angle_squared * (1.0 / 120.0 - angle_squared / 5040.0);
    let cross = rotation_rad.cross_matrix();
    Mat3::identity() + cross * first + cross * cross * second
}

/// Arm over which a tilt has the same weight as a shift in the choice of parameters \[mm\]: the size of a part.
const ARM_MM: f64 = 100.0;
/// A component whose effect on the lines is this close to a combination of earlier components adds nothing (ratio
/// of lengths). This is far above rounding, and far below the sine of the smallest angle between two rotary axes
/// (0.1°).
const SAME_EFFECT: f64 = 1e-6;

/// The components that place both lines of the machine, each needed and none twice: eight in all (two offsets and
/// two tilts of each line). They are taken in the order of [`ErrorParameter::every`]. So the inner axis of a chain
/// takes all it can, and the outer axis only the missing ones, as in P4: on an AC table `A e_x … e_c` and
/// `C e_y e_b`. The others are redundant: they move no line (along and about an axis itself), or have the effect of
/// others.
#[must_use]
pub fn placing_parameters(machine: &Machine) -> Vec<ErrorParameter> {
    let lines = MovedLines::new(machine, &[LocationError::default(); 2]);
    let mut basis: Vec<[Vec3; 4]> = Vec::new();
    let mut chosen = Vec::new();
    for parameter in ErrorParameter::every() {
        let mut effect = [Vec3::zeros(); 4];
        for axis in 0..2 {
            let (slope, along) = (lines.slope(axis, parameter), lines.screws[axis].direction);
            effect[axis * 2] = slope.direction * ARM_MM;
            // A line does not move along itself.
            effect[axis * 2 + 1] = slope.point_mm - along * along.dot(&slope.point_mm);
        }
        let whole = dot(&effect, &effect).sqrt();
        for known in &basis {
            let share = dot(&effect, known);
            for (part, known) in effect.iter_mut().zip(known) {
                *part -= known * share;
            }
        }
        let rest = dot(&effect, &effect).sqrt();
        // A shift moves a line by about 1 mm per mm, a tilt by about the arm.
        if rest > SAME_EFFECT * whole.max(1.0) {
            basis.push(effect.map(|part| part / rest));
            chosen.push(parameter);
        }
    }
    chosen
}

fn dot(a: &[Vec3; 4], b: &[Vec3; 4]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{PRESETS, Preset};

    fn names(machine: &Machine) -> Vec<String> {
        let axes = machine.rotary_axes();
        placing_parameters(machine)
            .iter()
            .map(|parameter| {
                let letter = axes[parameter.axis].letter.as_char();
                format!("{letter}.{}", COMPONENT_NAMES[parameter.component])
            })
            .collect()
    }

    #[test]
    fn an_ac_table_has_the_eight_errors_of_the_paper() {
        let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
        let expected = [
            "A.e_x_um",
            "A.e_y_um",
            "A.e_z_um",
            "A.e_a_urad",
            "A.e_b_urad",
            "A.e_c_urad",
            "C.e_y_um",
            "C.e_b_urad",
        ];
        assert_eq!(names(&machine), expected);
    }

    #[test]
    fn slopes_are_the_derivatives_of_the_lines() {
        /// Step of the difference \[mm, rad\], and the bound on its error and rounding: h² of a third derivative
        /// times 300 mm, 1e-13 mm over h.
        const STEP: f64 = 1e-4;
        const CLOSE: f64 = 1e-5;
        for preset in PRESETS {
            let machine = Machine::new(preset.parts()).unwrap();
            let mut errors = [LocationError::default(); 2];
            for (count, parameter) in (0u32..).zip(ErrorParameter::every()) {
                parameter.set(&mut errors, 0.001 * f64::from(count * 7 % 13) - 0.006);
            }
            let lines = MovedLines::new(&machine, &errors);
            for parameter in ErrorParameter::every() {
                let moved = |by: f64| {
                    let mut errors = errors;
                    let value = parameter.value(&errors) + by;
                    parameter.set(&mut errors, value);
                    machine.screws_with(&errors)
                };
                let (after, before) = (moved(STEP), moved(-STEP));
                for axis in 0..2 {
                    let slope = lines.slope(axis, parameter);
                    let direction = (after[axis].direction - before[axis].direction) / (2.0 * STEP);
                    let point_mm = (after[axis].point_mm - before[axis].point_mm) / (2.0 * STEP);
                    assert!((slope.direction - direction).norm() < CLOSE, "{parameter:?} of axis {axis}");
                    assert!((slope.point_mm - point_mm).norm() < CLOSE, "{parameter:?} of axis {axis}");
                }
            }
        }
    }
}
