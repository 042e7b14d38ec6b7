//! The drive constants of an axis, as the servo simulation takes them; coherent SI.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::FaultList;

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

/// What stands between motor and load.
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
    /// Load inertia on the motor shaft, where it is modelled apart (kg m²).
    #[serde(default)]
    pub load_inertia_kg_m2: Option<f64>,
    /// Viscous damping (Nm s/rad).
    pub damping_nm_s_per_rad: f64,
    /// What stands between motor and load.
    pub transmission: Transmission,
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

impl Drive {
    /// Checks the constants of the drive of axis `letter` which stands at `pointer`.
    pub(super) fn check(&self, letter: char, pointer: &str, faults: &mut FaultList) {
        let positive = [
            ("position_gain_per_s", self.position_gain_per_s, 1e5),
            ("velocity_gain_a_s_per_rad", self.velocity_gain_a_s_per_rad, 1e6),
            ("velocity_integral_time_s", self.velocity_integral_time_s, 1e3),
            ("current_gain_v_per_a", self.current_gain_v_per_a, 1e6),
            ("inductance_h", self.inductance_h, 1e3),
            ("resistance_ohm", self.resistance_ohm, 1e5),
            ("torque_constant_nm_per_a", self.torque_constant_nm_per_a, 1e5),
            ("inertia_kg_m2", self.inertia_kg_m2, 1e6),
        ];
        for (name, value, max) in positive {
            faults.check_range(|| format!("{pointer}/{name}"), value, 1e-12, max);
        }
        let not_negative = [
            ("back_emf_v_s_per_rad", self.back_emf_v_s_per_rad, 1e5),
            ("damping_nm_s_per_rad", self.damping_nm_s_per_rad, 1e6),
            ("load_inertia_kg_m2", self.load_inertia_kg_m2.unwrap_or(0.0), 1e6),
            ("velocity_feedforward", self.velocity_feedforward, 2.0),
            ("acceleration_feedforward", self.acceleration_feedforward, 2.0),
        ];
        for (name, value, max) in not_negative {
            faults.check_range(|| format!("{pointer}/{name}"), value, 0.0, max);
        }
        self.transmission.check(letter, &format!("{pointer}/transmission"), faults);
    }
}

impl Transmission {
    fn check(&self, letter: char, pointer: &str, faults: &mut FaultList) {
        let linear = matches!(letter, 'X' | 'Y' | 'Z');
        let (needed, other, wanted, unwanted) = if linear {
            ("lead_mm", "gear_ratio", self.lead_mm, self.gear_ratio)
        } else {
            ("gear_ratio", "lead_mm", self.gear_ratio, self.lead_mm)
        };
        let at = |name: &str| format!("{pointer}/{name}");
        match wanted {
            Some(value) => faults.check_range(|| at(needed), value, 1e-6, 1e6),
            None => faults.push(|| super::Fault::new(at(needed), format!("axis {letter} needs {needed}"))),
        }
        if unwanted.is_some() {
            faults.push(|| super::Fault::new(at(other), format!("axis {letter} has no {other}")));
        }
        if let Some(resonance) = self.resonance {
            faults.check_range(|| at("resonance/frequency_hz"), resonance.frequency_hz, 1e-3, 1e6);
            faults.check_range(|| at("resonance/damping_ratio"), resonance.damping_ratio, 0.0, 10.0);
        }
    }
}
