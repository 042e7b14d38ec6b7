//! A complete, checked machine.

use super::{
    AxisField, LocationError, MachineCoordinates, MachineFault, Motion, PlaneSolution, ProfileField,
    RotaryAxis, Squareness, Travel,
};
use crate::geometry::{RigidMotion, Screw, Vec3, angle_between};

/// The unchecked parts of a profile, with any number of axes and any values.
#[derive(Debug, Clone, PartialEq)]
pub struct MachineParts {
    /// The shop's name for the machine.
    pub name: String,
    /// Table axes from the bed outward, head axes from the ram outward.
    pub rotary_axes: Vec<RotaryAxis>,
    /// Travel of X, Y, Z words \[mm\]; `None` is unlimited.
    pub linear_travel_mm: [Option<Travel>; 3],
    /// Squareness of the linear axes.
    pub squareness: Squareness,
    /// The control's interpolation period T \[s\].
    pub interpolation_period_s: f64,
}

/// A valid machine: two rotary axes that can point the tool, finite numbers, travels with the lower end below
/// the upper one.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    name: String,
    rotary_axes: [RotaryAxis; 2],
    linear_travel_mm: [Option<Travel>; 3],
    squareness: Squareness,
    interpolation_period_s: f64,
    plane_solution: Option<PlaneSolution>,
    coordinates: Option<MachineCoordinates>,
    has_rs274_control: bool,
}

impl Machine {
    /// Zero-pose tool axis t0.
    pub const TOOL_AXIS: Vec3 = Vec3::new(0.0, 0.0, 1.0);
    /// Smallest angle between two lines that still counts as not parallel \[deg\].
    pub const MIN_AXIS_ANGLE_DEG: f64 = 0.1;
    /// Largest coordinate or travel accepted \[mm\].
    pub const MAX_LENGTH_MM: f64 = 1e5;
    /// Largest rotary travel end accepted \[deg\]: a thousand turns.
    pub const MAX_TRAVEL_DEG: f64 = 360_000.0;
    /// Largest translational location error accepted \[mm\].
    pub const MAX_ERROR_MM: f64 = 10.0;
    /// Largest angular location error or squareness accepted \[rad\].
    pub const MAX_ERROR_RAD: f64 = 0.05;
    /// Shortest and longest interpolation period \[s\].
    pub const PERIOD_RANGE_S: [f64; 2] = [1e-5, 1.0];
    /// A direction shorter than this counts as a zero vector.
    const MIN_DIRECTION_LENGTH: f64 = 1e-9;

    /// Checks `parts` and normalises the directions.
    ///
    /// # Errors
    /// Every fault found, not only the first.
    pub fn new(mut parts: MachineParts) -> Result<Self, Vec<MachineFault>> {
        let mut faults = Vec::new();
        let count = parts.rotary_axes.len();
        if count != 2 {
            faults.push(MachineFault::AxisCount { count });
        }
        for (index, axis) in parts.rotary_axes.iter_mut().enumerate() {
            check_axis(index, axis, &mut faults);
        }
        for index in 1..count {
            let letter = parts.rotary_axes[index].letter;
            if parts.rotary_axes[..index].iter().any(|axis| axis.letter == letter) {
                faults.push(MachineFault::RepeatedLetter { index, letter: letter.as_char() });
            }
        }
        for (index, travel) in parts.linear_travel_mm.iter().enumerate() {
            check_travel(*travel, Motion::Linear(index), Self::MAX_LENGTH_MM, &mut faults);
        }
        let square = parts.squareness;
        for (index, value) in [square.e_c0y_rad, square.e_b0z_rad, square.e_a0z_rad].into_iter().enumerate() {
            check_size(value, Self::MAX_ERROR_RAD, ProfileField::Squareness(index), &mut faults);
        }
        let [min_s, max_s] = Self::PERIOD_RANGE_S;
        let period_s = parts.interpolation_period_s;
        if !(min_s..=max_s).contains(&period_s) {
            faults.push(MachineFault::InterpolationPeriod { period_s, min_s, max_s });
        }
        if !faults.is_empty() {
            return Err(faults);
        }
        let Ok(rotary_axes) = <[RotaryAxis; 2]>::try_from(parts.rotary_axes) else {
            return Err(vec![MachineFault::AxisCount { count }]);
        };
        let machine = Self {
            name: parts.name,
            rotary_axes,
            linear_travel_mm: parts.linear_travel_mm,
            squareness: parts.squareness,
            interpolation_period_s: parts.interpolation_period_s,
            plane_solution: None,
            coordinates: None,
            has_rs274_control: false,
        };
        machine.check_pointing(&mut faults);
        if faults.is_empty() { Ok(machine) } else { Err(faults) }
    }

    /// The same machine, whose control chooses rotary positions for tilted planes by this rule.
    #[must_use]
    pub fn with_plane_solution(self, plane_solution: Option<PlaneSolution>) -> Self {
        Self { plane_solution, ..self }
    }

    /// How the control chooses rotary positions for tilted planes; `None` if this is not stated.
    #[must_use]
    pub fn plane_solution(&self) -> Option<PlaneSolution> {
        self.plane_solution
    }

    /// The same machine, whose control counts machine coordinates in this way.
    #[must_use]
    pub fn with_machine_coordinates(self, coordinates: Option<MachineCoordinates>) -> Self {
        Self { coordinates, ..self }
    }

    /// The same machine, whose control is known to run programs as RS274/NGC does, or is not.
    #[must_use]
    pub fn with_rs274_control(self, has_rs274_control: bool) -> Self {
        Self { has_rs274_control, ..self }
    }

    /// Whether the control is known to run programs as RS274/NGC does, where controls differ.
    #[must_use]
    pub fn has_rs274_control(&self) -> bool {
        self.has_rs274_control
    }

    /// Where the control's machine coordinates count from; `None` if this is not stated.
    #[must_use]
    pub fn machine_coordinates(&self) -> Option<&MachineCoordinates> {
        self.coordinates.as_ref()
    }

    /// The shop's name for the machine.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The rotary axes in the profile's order.
    #[must_use]
    pub fn rotary_axes(&self) -> &[RotaryAxis; 2] {
        &self.rotary_axes
    }

    /// Travel of X, Y, Z words \[mm\].
    #[must_use]
    pub fn linear_travel_mm(&self) -> &[Option<Travel>; 3] {
        &self.linear_travel_mm
    }

    /// Squareness of the linear axes.
    #[must_use]
    pub fn squareness(&self) -> &Squareness {
        &self.squareness
    }

    /// The control's interpolation period T \[s\].
    #[must_use]
    pub fn interpolation_period_s(&self) -> f64 {
        self.interpolation_period_s
    }

    /// The rotary axes' indices in the order u, v: from the workpiece to the tool (table axes from the workpiece
    /// inward, then head axes from the ram outward).
    #[must_use]
    pub fn workpiece_to_tool(&self) -> [usize; 2] {
        use super::Side::{Head, Table};
        // Table axes are listed from the bed outward, so the last one listed is next to the workpiece.
        let mut order = [0, 1];
        order.sort_by_key(|&index| match self.rotary_axes[index].side {
            Table => (0, 2 - index),
            Head => (1, index),
        });
        order
    }

    /// The real lines of the axes in M, in the profile's order: nominal lines displaced by `Ad(G_1 ⋯ G_r)`, the
    /// product taken along each side's own chain outward. With `apply_errors` false, the nominal lines. Head
    /// lines are still relative to the gauge point.
    #[must_use]
    pub fn screws(&self, apply_errors: bool) -> [Screw; 2] {
        if apply_errors {
            self.screws_with(&self.rotary_axes.each_ref().map(|axis| axis.location_error))
        } else {
            self.rotary_axes.each_ref().map(RotaryAxis::nominal_screw)
        }
    }

    /// The lines as [`Machine::screws`] gives them, with these location errors in place of the profile's.
    #[must_use]
    pub fn screws_with(&self, errors: &[LocationError; 2]) -> [Screw; 2] {
        let mut chain = [RigidMotion::identity(), RigidMotion::identity()];
        std::array::from_fn(|index| {
            let axis = &self.rotary_axes[index];
            let side = axis.side as usize;
            chain[side] = chain[side].after(&errors[index].displacement(axis.point_mm));
            axis.nominal_screw().displaced(&chain[side].rotation, chain[side].shift_mm)
        })
    }

    fn check_pointing(&self, faults: &mut Vec<MachineFault>) {
        let min_deg = Self::MIN_AXIS_ANGLE_DEG;
        let last = self.workpiece_to_tool()[1];
        let mut worst = [f64::INFINITY; 2];
        for screws in [self.screws(false), self.screws(true)] {
            worst[0] = worst[0].min(line_angle_deg(screws[0].direction, screws[1].direction));
            worst[1] = worst[1].min(line_angle_deg(screws[last].direction, Self::TOOL_AXIS));
        }
        if worst[0] < min_deg {
            faults.push(MachineFault::ParallelRotaries { angle_deg: worst[0], min_deg });
        }
        if worst[1] < min_deg {
            faults.push(MachineFault::ToolAlongLastRotary { index: last, angle_deg: worst[1], min_deg });
        }
    }
}

/// Angle between two lines regardless of direction, 0–90 \[deg\].
fn line_angle_deg(a: Vec3, b: Vec3) -> f64 {
    let angle = angle_between(a, b).to_degrees();
    angle.min(180.0 - angle)
}

fn check_size(value: f64, max_abs: f64, field: ProfileField, faults: &mut Vec<MachineFault>) {
    // NaN is not in the range either.
    if !(-max_abs..=max_abs).contains(&value) {
        faults.push(MachineFault::Absurd { field, value, max_abs });
    }
}

fn check_travel(travel: Option<Travel>, motion: Motion, max_abs: f64, faults: &mut Vec<MachineFault>) {
    let Some(Travel { min, max }) = travel else { return };
    let before = faults.len();
    for (end, value) in [min, max].into_iter().enumerate() {
        let field = match motion {
            Motion::Rotary(index) => ProfileField::Axis(index, AxisField::Travel(end)),
            Motion::Linear(index) => ProfileField::LinearTravel(index, end),
        };
        check_size(value, max_abs, field, faults);
    }
    if faults.len() == before && min >= max {
        faults.push(MachineFault::TravelUpsideDown { motion, min, max });
    }
}

fn check_axis(index: usize, axis: &mut RotaryAxis, faults: &mut Vec<MachineFault>) {
    let field = |field| ProfileField::Axis(index, field);
    let before = faults.len();
    for k in 0..3 {
        check_size(axis.direction[k], Machine::MAX_LENGTH_MM, field(AxisField::Direction(k)), faults);
    }
    if faults.len() == before {
        let length = axis.direction.norm();
        if length > Machine::MIN_DIRECTION_LENGTH {
            axis.direction /= length;
        } else {
            let min_length = Machine::MIN_DIRECTION_LENGTH;
            faults.push(MachineFault::ZeroDirection { index, length, min_length });
        }
    }
    for k in 0..3 {
        check_size(axis.point_mm[k], Machine::MAX_LENGTH_MM, field(AxisField::Point(k)), faults);
        let error = &axis.location_error;
        check_size(
            error.translation_mm[k],
            Machine::MAX_ERROR_MM,
            field(AxisField::LocationError(k)),
            faults,
        );
        check_size(
            error.rotation_rad[k],
            Machine::MAX_ERROR_RAD,
            field(AxisField::LocationError(k + 3)),
            faults,
        );
    }
    check_travel(axis.travel_deg, Motion::Rotary(index), Machine::MAX_TRAVEL_DEG, faults);
}
