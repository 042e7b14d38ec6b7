//! The machine profile as clients and the disk have it.

use serde::{Deserialize, Serialize};

use super::{
    CalibrationLimits, Drives, Fault, FaultList, Fixed, MachineCoordinates, PlaneRule, PlaneSolution,
    ProgramUnit, WorkOffsets,
};
use crate::description::ToSchema;
use crate::geometry::Vec3;
use crate::machine::{
    self, AxisField, LocationError, Machine, MachineFault, MachineParts, Motion, ProfileField, RotaryAxis,
    RotaryLetter, Side, Squareness, Travel,
};
use crate::servo::AxisLetter;
use crate::units::{Angle, Length};

/// What the shop states about a machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MachineProfile {
    /// The shop's name for the machine.
    #[schema(example = "DMU 80 T", min_length = 1, max_length = 200)]
    pub name: String,
    /// Axes, travel and errors.
    pub kinematics: Kinematics,
    /// The control's interpolation period.
    #[serde(default = "default_period_s")]
    #[schema(default = 0.002, minimum = 0.00001, maximum = 1.0)]
    pub interpolation_period_s: f64,
    /// Unit of programs that state none, if the request states none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub program_unit: Option<ProgramUnit>,
    /// G codes in force when a program begins.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = "G1 G17 G90 G94")]
    pub start_codes: Option<String>,
    /// Work offsets by their names in programs, such as `G54`, `G54.1 P3` and `G505`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub work_offsets_mm: Option<WorkOffsets>,
    /// Largest feed that a written F may ask for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 15_000.0, minimum = 0.000_001, maximum = 1_000_000)]
    pub max_feed_mm_per_min: Option<f64>,
    /// Shortest time that the control needs for one block.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 1.0, minimum = 0.01, maximum = 1000)]
    pub block_time_ms: Option<f64>,
    /// Which solution of a tilted plane the control takes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plane_solution: Option<PlaneSolution>,
    /// Where machine coordinates (G53, SUPA, M91) and reference positions (G28, G30) are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub machine_coordinates: Option<MachineCoordinates>,
    /// Programs run as in RS274/NGC.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rs274_control: Option<bool>,
    /// The builder's serial number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = "1138-5519", min_length = 1, max_length = 200)]
    pub serial_number: Option<String>,
    /// The machine's id in the shop's own lists.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = "EQ-004711", min_length = 1, max_length = 200)]
    pub asset_id: Option<String>,
    /// Number of days after which the next calibration is due.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = 90.0, exclusive_minimum = 0, maximum = 36_500)]
    pub calibration_due_days: Option<f64>,
    /// Limits of the location errors, for the verdict of the calibration report.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub calibration_limits: Option<CalibrationLimits>,
    /// Drive constants by axis letter, for the servo simulation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drives: Option<Drives>,
}

/// Axes, travel and errors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Kinematics {
    /// Two different axes: table axes from the bed outward, head axes from the ram outward.
    #[schema(min_items = 2, max_items = 2)]
    pub rotary_axes: Vec<RotaryAxisDoc>,
    /// Travel of the linear words.
    #[serde(default)]
    pub linear_limits_mm: LinearLimits,
    /// Squareness of the linear axes.
    #[serde(default)]
    pub squareness_urad: SquarenessDoc,
}

/// One rotary axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = RotaryAxis)]
pub struct RotaryAxisDoc {
    /// Address letter: A, B or C.
    #[schema(pattern = "^[ABC]$", example = "A")]
    pub name: String,
    /// What the axis carries: the workpiece (table) or the tool (head).
    pub side: SideDoc,
    /// Direction at zero pose; the service normalises it.
    pub direction: Fixed<3>,
    /// A point on the axis: in machine coordinates for a table axis, relative to the zero-pose gauge point for a
    /// head axis.
    pub point_mm: Fixed<3>,
    /// Travel of the word; null for an axis without limits.
    #[serde(default)]
    pub limits_deg: Option<Fixed<2>>,
    /// True if the control counts opposite to ISO 841.
    #[serde(default)]
    pub reversed: bool,
    /// Measured displacement of the axis's own frame.
    #[serde(default)]
    pub location_error: LocationErrorDoc,
}

/// What a rotary axis carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = Side)]
pub enum SideDoc {
    /// The workpiece.
    Table,
    /// The tool.
    Head,
}

/// A small displacement of an axis's own frame, cascaded outward.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
#[schema(as = LocationError)]
pub struct LocationErrorDoc {
    /// Shift along X.
    pub e_x_um: f64,
    /// Shift along Y.
    pub e_y_um: f64,
    /// Shift along Z.
    pub e_z_um: f64,
    /// Rotation about X.
    pub e_a_urad: f64,
    /// Rotation about Y.
    pub e_b_urad: f64,
    /// Rotation about Z.
    pub e_c_urad: f64,
}

/// Travel of the linear words; null for an axis without limits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default, rename_all = "UPPERCASE")]
pub struct LinearLimits {
    /// Travel of X.
    pub x: Option<Fixed<2>>,
    /// Travel of Y.
    pub y: Option<Fixed<2>>,
    /// Travel of Z.
    pub z: Option<Fixed<2>>,
}

/// Squareness of the linear axes; X is the reference.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
#[schema(as = Squareness)]
pub struct SquarenessDoc {
    /// Rotation of Y about Z.
    pub e_c0y: f64,
    /// Rotation of Z about Y.
    pub e_b0z: f64,
    /// Rotation of Z about X.
    pub e_a0z: f64,
}

/// A stored revision of a machine.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct MachineDocument {
    /// The id that the client chose.
    #[schema(example = "dmu-80-t")]
    pub machine_id: String,
    /// Counts up from 1; a revision never changes.
    #[schema(example = 3)]
    pub revision: i64,
    /// Time at which this revision was stored.
    #[schema(example = "2026-03-14T09:26:53.589Z")]
    pub created_at: String,
    /// The profile, normalised.
    #[serde(flatten)]
    pub profile: MachineProfile,
}

const fn default_period_s() -> f64 {
    0.002
}

impl MachineProfile {
    /// The profile with directions of unit length, and the machine it describes.
    ///
    /// # Errors
    /// Every fault found, with its JSON pointer.
    pub fn into_machine(mut self) -> Result<(Self, Machine), Vec<Fault>> {
        let mut faults = FaultList::default();
        let letters = self.letters(&mut faults);
        self.check_programs(&mut faults);
        if let Some(drives) = &self.drives {
            for (letter, drive) in drives.iter() {
                let pointer = format!("/drives/{letter}");
                if !"XYZ".contains(letter) && !letters.iter().any(|have| have.as_char() == letter) {
                    faults.push(|| Fault::new(&*pointer, format!("the machine has no axis {letter}")));
                }
                if let Some(axis) = AxisLetter::from_char(letter) {
                    drive.to_core(axis, &pointer, false, &mut faults);
                }
            }
        }
        let machine = match Machine::new(self.parts(&letters)) {
            Ok(machine) => Some(machine),
            Err(found) => {
                for fault in &found {
                    faults.push(|| located(fault));
                }
                None
            }
        };
        faults.into_result()?;
        for axis in &mut self.kinematics.rotary_axes {
            axis.direction = unit(axis.direction);
        }
        self.work_offsets_mm = self.work_offsets_mm.map(WorkOffsets::without_negative_zeros);
        self.machine_coordinates = self.machine_coordinates.map(MachineCoordinates::without_negative_zeros);
        let solution = self.plane_solution.as_ref().map(solution_of);
        let axes = letters.iter().map(|letter| letter.as_char()).collect::<Vec<_>>();
        let coordinates = self.machine_coordinates.as_ref().map(|stated| stated.to_core(&axes));
        let has_rs274_control = self.rs274_control == Some(true);
        let machine = machine.map(|machine| {
            machine
                .with_plane_solution(solution)
                .with_machine_coordinates(coordinates)
                .with_rs274_control(has_rs274_control)
        });
        machine.map(|machine| (self, machine)).ok_or_else(Vec::new)
    }

    /// The letters of the axes. An unknown letter is replaced by one that no other axis has, so that the rest
    /// of the profile can still be checked.
    fn letters(&self, faults: &mut FaultList) -> Vec<RotaryLetter> {
        let axes = &self.kinematics.rotary_axes;
        let known: Vec<_> = axes.iter().map(|axis| letter(&axis.name)).collect();
        let mut spare = [RotaryLetter::A, RotaryLetter::B, RotaryLetter::C]
            .into_iter()
            .filter(|candidate| !known.contains(&Some(*candidate)));
        let mut letters = Vec::with_capacity(known.len());
        for (index, found) in known.iter().enumerate() {
            if found.is_none() {
                faults.push(|| {
                    Fault::new(
                        format!("/kinematics/rotary_axes/{index}/name"),
                        "the name of a rotary axis must be A, B or C",
                    )
                });
            }
            letters.push(found.or_else(|| spare.next()).unwrap_or(RotaryLetter::A));
        }
        letters
    }

    fn parts(&self, letters: &[RotaryLetter]) -> MachineParts {
        let LinearLimits { x, y, z } = self.kinematics.linear_limits_mm;
        let square = self.kinematics.squareness_urad;
        MachineParts {
            name: self.name.clone(),
            rotary_axes: self
                .kinematics
                .rotary_axes
                .iter()
                .zip(letters)
                .map(|(axis, letter)| axis.to_core(*letter))
                .collect(),
            linear_travel_mm: [x, y, z].map(travel),
            squareness: Squareness {
                e_c0y_rad: Angle::from_urad(square.e_c0y).rad(),
                e_b0z_rad: Angle::from_urad(square.e_b0z).rad(),
                e_a0z_rad: Angle::from_urad(square.e_a0z).rad(),
            },
            interpolation_period_s: self.interpolation_period_s,
        }
    }
}

impl RotaryAxisDoc {
    fn to_core(&self, letter: RotaryLetter) -> RotaryAxis {
        let error = &self.location_error;
        RotaryAxis {
            letter,
            side: match self.side {
                SideDoc::Table => Side::Table,
                SideDoc::Head => Side::Head,
            },
            direction: Vec3::from(self.direction.0),
            point_mm: Vec3::from(self.point_mm.0),
            travel_deg: travel(self.limits_deg),
            reversed: self.reversed,
            location_error: LocationError {
                translation_mm: Vec3::from(
                    [error.e_x_um, error.e_y_um, error.e_z_um].map(|um| Length::from_um(um).mm()),
                ),
                rotation_rad: Vec3::from(
                    [error.e_a_urad, error.e_b_urad, error.e_c_urad].map(|urad| Angle::from_urad(urad).rad()),
                ),
            },
        }
    }
}

impl From<&MachineParts> for MachineProfile {
    fn from(parts: &MachineParts) -> Self {
        let [x, y, z] = parts.linear_travel_mm.map(limits);
        let square = parts.squareness;
        Self {
            name: parts.name.clone(),
            kinematics: Kinematics {
                rotary_axes: parts.rotary_axes.iter().map(RotaryAxisDoc::from).collect(),
                linear_limits_mm: LinearLimits { x, y, z },
                squareness_urad: SquarenessDoc {
                    e_c0y: Angle::from_rad(square.e_c0y_rad).urad(),
                    e_b0z: Angle::from_rad(square.e_b0z_rad).urad(),
                    e_a0z: Angle::from_rad(square.e_a0z_rad).urad(),
                },
            },
            interpolation_period_s: parts.interpolation_period_s,
            program_unit: None,
            start_codes: None,
            work_offsets_mm: None,
            max_feed_mm_per_min: None,
            block_time_ms: None,
            plane_solution: None,
            machine_coordinates: None,
            rs274_control: None,
            serial_number: None,
            asset_id: None,
            calibration_due_days: None,
            calibration_limits: None,
            drives: None,
        }
    }
}

impl From<&RotaryAxis> for RotaryAxisDoc {
    fn from(axis: &RotaryAxis) -> Self {
        let [e_x_um, e_y_um, e_z_um] =
            <[f64; 3]>::from(axis.location_error.translation_mm).map(|mm| Length::from_mm(mm).um());
        let [e_a_urad, e_b_urad, e_c_urad] =
            <[f64; 3]>::from(axis.location_error.rotation_rad).map(|rad| Angle::from_rad(rad).urad());
        Self {
            name: axis.letter.as_char().to_string(),
            side: match axis.side {
                Side::Table => SideDoc::Table,
                Side::Head => SideDoc::Head,
            },
            direction: unit(Fixed(axis.direction.into())),
            point_mm: Fixed(axis.point_mm.into()),
            limits_deg: limits(axis.travel_deg),
            reversed: axis.reversed,
            location_error: LocationErrorDoc { e_x_um, e_y_um, e_z_um, e_a_urad, e_b_urad, e_c_urad },
        }
    }
}

fn letter(name: &str) -> Option<RotaryLetter> {
    match name {
        "A" => Some(RotaryLetter::A),
        "B" => Some(RotaryLetter::B),
        "C" => Some(RotaryLetter::C),
        _ => None,
    }
}

/// The rule in the core's terms.
fn solution_of(solution: &PlaneSolution) -> machine::PlaneSolution {
    let rule = match solution.rule {
        PlaneRule::PositiveFirst => machine::PlaneRule::PositiveFirst,
        PlaneRule::NegativeFirst => machine::PlaneRule::NegativeFirst,
        PlaneRule::Shortest => machine::PlaneRule::Shortest,
    };
    machine::PlaneSolution { rule, axis: solution.axis.as_deref().and_then(letter) }
}

fn travel(limits: Option<Fixed<2>>) -> Option<Travel> {
    limits.map(|Fixed([min, max])| Travel { min, max })
}

fn limits(travel: Option<Travel>) -> Option<Fixed<2>> {
    travel.map(|Travel { min, max }| Fixed([min, max]))
}

/// The direction at unit length. A direction that has unit length within rounding stays as it is: a profile
/// that is read from the service and stored again is then the same profile.
fn unit(direction: Fixed<3>) -> Fixed<3> {
    let vector = Vec3::from(direction.0);
    let length = vector.norm();
    if (length - 1.0).abs() <= 4.0 * f64::EPSILON { direction } else { Fixed((vector / length).into()) }
}

fn located(fault: &MachineFault) -> Fault {
    let axis = |index: usize| format!("/kinematics/rotary_axes/{index}");
    let pointer = match *fault {
        MachineFault::AxisCount { .. } | MachineFault::ParallelRotaries { .. } => {
            "/kinematics/rotary_axes".to_owned()
        }
        MachineFault::RepeatedLetter { index, .. } => axis(index) + "/name",
        MachineFault::ZeroDirection { index, .. } | MachineFault::ToolAlongLastRotary { index, .. } => {
            axis(index) + "/direction"
        }
        MachineFault::TravelUpsideDown { motion: Motion::Rotary(index), .. } => axis(index) + "/limits_deg",
        MachineFault::TravelUpsideDown { motion: Motion::Linear(index), .. } => {
            format!("/kinematics/linear_limits_mm/{}", linear_letter(index))
        }
        MachineFault::InterpolationPeriod { .. } => "/interpolation_period_s".to_owned(),
        MachineFault::Absurd { field, value, max_abs } => {
            let (pointer, per_unit) = field_on_wire(field);
            let (value, max_abs) = (value * per_unit, max_abs * per_unit);
            return Fault::new(pointer, format!("{value} is not a number of magnitude at most {max_abs}"));
        }
    };
    Fault::new(pointer, fault.to_string())
}

/// The location of a field, and how many of its wire units make one unit of the core.
fn field_on_wire(field: ProfileField) -> (String, f64) {
    use crate::units::{UM_PER_MM, URAD_PER_RAD};
    match field {
        ProfileField::Axis(index, field) => {
            let (name, per_unit) = match field {
                AxisField::Direction(k) => (format!("direction/{k}"), 1.0),
                AxisField::Point(k) => (format!("point_mm/{k}"), 1.0),
                AxisField::Travel(k) => (format!("limits_deg/{k}"), 1.0),
                AxisField::LocationError(k) => {
                    let names = ["e_x_um", "e_y_um", "e_z_um", "e_a_urad", "e_b_urad", "e_c_urad"];
                    let per_unit = if k < 3 { UM_PER_MM } else { URAD_PER_RAD };
                    (format!("location_error/{}", names.get(k).unwrap_or(&"")), per_unit)
                }
            };
            (format!("/kinematics/rotary_axes/{index}/{name}"), per_unit)
        }
        ProfileField::LinearTravel(index, end) => {
            (format!("/kinematics/linear_limits_mm/{}/{end}", linear_letter(index)), 1.0)
        }
        ProfileField::Squareness(index) => {
            let name = ["e_c0y", "e_b0z", "e_a0z"].get(index).copied().unwrap_or("");
            (format!("/kinematics/squareness_urad/{name}"), URAD_PER_RAD)
        }
        ProfileField::InterpolationPeriod => ("/interpolation_period_s".to_owned(), 1.0),
    }
}

fn linear_letter(index: usize) -> &'static str {
    ["X", "Y", "Z"].get(index).copied().unwrap_or("")
}
