//! The drive constants of an axis, as the servo simulation takes them; coherent SI.

use serde::{Deserialize, Serialize};

use super::{Fault, FaultList};
use crate::description::ToSchema;
use crate::servo;
use crate::servo::{AxisLetter, DriveFault, DriveSet};

/// Drives by axis letter.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, rename_all = "UPPERCASE")]
pub struct Drives {
    /// Drive of X.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub x: Option<Drive>,
    /// Drive of Y.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub y: Option<Drive>,
    /// Drive of Z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub z: Option<Drive>,
    /// Drive of A.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub a: Option<Drive>,
    /// Drive of B.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub b: Option<Drive>,
    /// Drive of C.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub c: Option<Drive>,
}

impl Drives {
    /// Letter and drive of each axis that has one.
    pub fn iter(&self) -> impl Iterator<Item = (char, &Drive)> {
        let all =
            [('X', &self.x), ('Y', &self.y), ('Z', &self.z), ('A', &self.a), ('B', &self.b), ('C', &self.c)];
        all.into_iter().filter_map(|(letter, drive)| drive.as_ref().map(|drive| (letter, drive)))
    }
}

/// Where the position of an axis is measured.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Feedback {
    /// On the load.
    #[default]
    Load,
    /// On the motor.
    Motor,
}

/// A resonance between motor and load.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Resonance {
    /// Natural frequency (Hz).
    pub frequency_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
}

/// The transmission between motor and load.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Transmission {
    /// Travel for each motor turn (mm); linear axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lead_mm: Option<f64>,
    /// Motor turns for each table turn; rotary axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gear_ratio: Option<f64>,
    /// Resonance, where it matters.
    #[serde(default)]
    pub resonance: Option<Resonance>,
}

/// The constants of one cascaded drive.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Position gain (1/s).
    pub position_gain_per_s: f64,
    /// Velocity gain (A s/rad).
    pub velocity_gain_a_s_per_rad: f64,
    /// Integral time of the velocity loop (s).
    pub velocity_integral_time_s: f64,
    /// Current gain (V/A).
    pub current_gain_v_per_a: f64,
    /// Winding inductance (H).
    pub inductance_h: f64,
    /// Winding resistance (Ω).
    pub resistance_ohm: f64,
    /// Torque constant (Nm/A).
    pub torque_constant_nm_per_a: f64,
    /// Back EMF constant (V s/rad).
    pub back_emf_v_s_per_rad: f64,
    /// Inertia on the motor shaft (kg m²).
    pub inertia_kg_m2: f64,
    /// Load inertia on the motor shaft, if it is modelled separately (kg m²).
    #[serde(default)]
    pub load_inertia_kg_m2: Option<f64>,
    /// Viscous damping (Nm s/rad).
    pub damping_nm_s_per_rad: f64,
    /// The transmission between motor and load.
    pub transmission: Transmission,
    /// Constant load torque; it acts from t = 0 on (Nm).
    #[serde(default, skip_serializing_if = "is_zero")]
    pub load_torque_nm: f64,
    /// Where the position is measured.
    #[serde(default)]
    pub feedback: Feedback,
    /// Share of the commanded velocity fed forward.
    #[serde(default)]
    pub velocity_feedforward: f64,
    /// Share of the commanded acceleration fed forward.
    #[serde(default)]
    pub acceleration_feedforward: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Drives {
    /// The drives for a simulation; faults are added to `faults` under `pointer`.
    pub fn to_core(&self, pointer: &str, faults: &mut FaultList) -> DriveSet {
        let mut set = DriveSet::default();
        for (letter, drive) in self.iter() {
            let Some(axis) = AxisLetter::from_char(letter) else { continue };
            if let Some(drive) = drive.to_core(axis, &format!("{pointer}/{letter}"), true, faults) {
                set.set(axis, drive);
            }
        }
        set
    }

    /// The place of the drive of an axis.
    pub fn slot(&mut self, axis: AxisLetter) -> &mut Option<Drive> {
        match axis {
            AxisLetter::X => &mut self.x,
            AxisLetter::Y => &mut self.y,
            AxisLetter::Z => &mut self.z,
            AxisLetter::A => &mut self.a,
            AxisLetter::B => &mut self.b,
            AxisLetter::C => &mut self.c,
        }
    }
}

impl Drive {
    /// The drive of `axis` for a simulation; faults are added to `faults` under `pointer`. A profile may hold
    /// a drive that cannot be simulated yet (a load inertia without its resonance). That is a fault only if
    /// `as_simulated`.
    pub(super) fn to_core(
        self,
        axis: AxisLetter,
        pointer: &str,
        as_simulated: bool,
        faults: &mut FaultList,
    ) -> Option<servo::Drive> {
        let ratio = self.transmission.to_core(axis, &format!("{pointer}/transmission"), faults);
        // The other constants are checked even if the transmission is wrong.
        let output_per_motor_rad = ratio.unwrap_or(1.0);
        let drive = servo::Drive {
            position_gain_per_s: self.position_gain_per_s,
            velocity_gain_a_s_per_rad: self.velocity_gain_a_s_per_rad,
            velocity_integral_time_s: self.velocity_integral_time_s,
            current_gain_v_per_a: self.current_gain_v_per_a,
            inductance_h: self.inductance_h,
            resistance_ohm: self.resistance_ohm,
            torque_constant_nm_per_a: self.torque_constant_nm_per_a,
            back_emf_v_s_per_rad: self.back_emf_v_s_per_rad,
            inertia_kg_m2: self.inertia_kg_m2,
            // A torque of zero means the same as no torque.
            load_inertia_kg_m2: self.load_inertia_kg_m2.filter(|inertia| *inertia != 0.0),
            damping_nm_s_per_rad: self.damping_nm_s_per_rad,
            load_torque_nm: self.load_torque_nm,
            output_per_motor_rad,
            resonance: self.transmission.resonance.map(|resonance| servo::Resonance {
                frequency_hz: resonance.frequency_hz,
                damping_ratio: resonance.damping_ratio,
            }),
            feedback: match self.feedback {
                Feedback::Load => servo::Feedback::Load,
                Feedback::Motor => servo::Feedback::Motor,
            },
            velocity_feedforward: self.velocity_feedforward,
            acceleration_feedforward: self.acceleration_feedforward,
        };
        let mut found = drive.faults();
        if !as_simulated {
            found.retain(|fault| *fault != DriveFault::TwoMassesWithoutSpring);
        }
        for fault in &found {
            faults.push(|| {
                Fault::new(format!("{pointer}/{}", fault.name().replace('.', "/")), fault.to_string())
            });
        }
        (found.is_empty() && ratio.is_some()).then_some(drive)
    }

    /// The drive as a document for `axis`.
    #[must_use]
    pub fn from_core(axis: AxisLetter, drive: &servo::Drive) -> Self {
        let ratio = drive.output_per_motor_rad;
        let (lead_mm, gear_ratio) = if axis.is_linear() {
            (Some(ratio * std::f64::consts::TAU), None)
        } else {
            (None, Some(1.0 / ratio))
        };
        let resonance = drive.resonance.map(|resonance| Resonance {
            frequency_hz: resonance.frequency_hz,
            damping_ratio: resonance.damping_ratio,
        });
        Self {
            position_gain_per_s: drive.position_gain_per_s,
            velocity_gain_a_s_per_rad: drive.velocity_gain_a_s_per_rad,
            velocity_integral_time_s: drive.velocity_integral_time_s,
            current_gain_v_per_a: drive.current_gain_v_per_a,
            inductance_h: drive.inductance_h,
            resistance_ohm: drive.resistance_ohm,
            torque_constant_nm_per_a: drive.torque_constant_nm_per_a,
            back_emf_v_s_per_rad: drive.back_emf_v_s_per_rad,
            inertia_kg_m2: drive.inertia_kg_m2,
            load_inertia_kg_m2: drive.load_inertia_kg_m2,
            damping_nm_s_per_rad: drive.damping_nm_s_per_rad,
            transmission: Transmission { lead_mm, gear_ratio, resonance },
            load_torque_nm: drive.load_torque_nm,
            feedback: match drive.feedback {
                servo::Feedback::Load => Feedback::Load,
                servo::Feedback::Motor => Feedback::Motor,
            },
            velocity_feedforward: drive.velocity_feedforward,
            acceleration_feedforward: drive.acceleration_feedforward,
        }
    }
}

/// Leads and gear ratios that are accepted.
const RATIO_RANGE: [f64; 2] = [1e-6, 1e6];

impl Transmission {
    /// ρ: output units (mm, or rad) for each radian of the motor.
    fn to_core(self, axis: AxisLetter, pointer: &str, faults: &mut FaultList) -> Option<f64> {
        let (needed, other, wanted, unwanted) = if axis.is_linear() {
            ("lead_mm", "gear_ratio", self.lead_mm, self.gear_ratio)
        } else {
            ("gear_ratio", "lead_mm", self.gear_ratio, self.lead_mm)
        };
        let at = |name: &str| format!("{pointer}/{name}");
        if unwanted.is_some() {
            faults.push(|| Fault::new(at(other), format!("axis {axis} has no {other}")));
        }
        let Some(ratio) = wanted else {
            faults.push(|| Fault::new(at(needed), format!("axis {axis} needs {needed}")));
            return None;
        };
        let [min, max] = RATIO_RANGE;
        faults.check_range(|| at(needed), ratio, min, max);
        (min..=max).contains(&ratio).then_some(if axis.is_linear() {
            ratio / std::f64::consts::TAU
        } else {
            1.0 / ratio
        })
    }
}
