//! Preset drives.

use super::{AxisLetter, Drive, Feedback};

/// A drive with the source of its numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrivePreset {
    /// Short name.
    pub id: &'static str,
    /// Short description.
    pub title: &'static str,
    /// Axes for which it is made.
    pub axes: &'static [AxisLetter],
    /// Constants without a published source. All others are published values.
    pub assumed: &'static [&'static str],
    /// The constants.
    pub drive: Drive,
}

/// Travel of the reference X axis for each motor turn \[mm\].
const REFERENCE_LEAD_MM: f64 = 10.0;
/// Motor turns for each turn of the reference C axis.
const REFERENCE_GEAR_RATIO: f64 = 90.0;

/// Published motor data (Kt, Rb, L) with a published identified axis (Ke, J, C, lead, Kvp, Ti).
const REFERENCE_X: Drive = Drive {
    position_gain_per_s: 30.0,
    velocity_gain_a_s_per_rad: 0.576,
    velocity_integral_time_s: 0.12,
    current_gain_v_per_a: 20.0,
    inductance_h: 4.2e-3,
    resistance_ohm: 0.61,
    torque_constant_nm_per_a: 0.88,
    back_emf_v_s_per_rad: 0.314,
    inertia_kg_m2: 3.3e-3,
    load_inertia_kg_m2: None,
    damping_nm_s_per_rad: 0.019,
    load_torque_nm: 0.0,
    output_per_motor_rad: REFERENCE_LEAD_MM / std::f64::consts::TAU,
    resonance: None,
    feedback: Feedback::Load,
    velocity_feedforward: 0.0,
    acceleration_feedforward: 0.0,
};

/// An axis of the identified three-axis mill: current amplifier of gain Ka, so that Kvp = Kv Ka; Kf = 1 of its
/// velocity feed-forward is published like the gains. Its winding is not published and is that of the reference
/// motor. Its identified dry friction (static, Coulomb, Stribeck) is not modelled: the loops are linear, and
/// contain only the viscous part of friction.
const fn mill(
    amplifier_a_per_v: f64,
    velocity_gain_v_s_per_rad: f64,
    position_gain_rad_per_mm_s: f64,
    transmission_mm_per_rad: f64,
    inertia_kg_m2: f64,
    damping_nm_s_per_rad: f64,
) -> Drive {
    Drive {
        position_gain_per_s: position_gain_rad_per_mm_s * transmission_mm_per_rad,
        velocity_gain_a_s_per_rad: velocity_gain_v_s_per_rad * amplifier_a_per_v,
        torque_constant_nm_per_a: 0.891,
        inertia_kg_m2,
        damping_nm_s_per_rad,
        output_per_motor_rad: transmission_mm_per_rad,
        velocity_feedforward: 1.0,
        ..REFERENCE_X
    }
}

const MILL_ASSUMED: &[&str] =
    &["current_gain_v_per_a", "inductance_h", "resistance_ohm", "back_emf_v_s_per_rad"];

use AxisLetter::{A, B, C, X, Y, Z};

/// All drives: the reference drive of `math.md` §3 for a small trunnion machine, and the axes of an identified
/// three-axis mill.
pub const DRIVE_PRESETS: [DrivePreset; 5] = [
    DrivePreset {
        id: "reference-linear",
        title: "Ball screw of 10 mm lead, servo motor of 0.88 Nm/A",
        axes: &[X, Y, Z],
        assumed: &["position_gain_per_s", "current_gain_v_per_a"],
        drive: REFERENCE_X,
    },
    DrivePreset {
        id: "reference-rotary",
        title: "Worm table 90 : 1, the same motor",
        axes: &[A, B, C],
        assumed: &["position_gain_per_s", "current_gain_v_per_a", "transmission.gear_ratio"],
        drive: Drive {
            inertia_kg_m2: 3.5e-3,
            output_per_motor_rad: 1.0 / REFERENCE_GEAR_RATIO,
            ..REFERENCE_X
        },
    },
    DrivePreset {
        id: "mill-x",
        title: "X axis of an identified three-axis mill, its dry friction left out",
        axes: &[X],
        assumed: MILL_ASSUMED,
        drive: mill(3.1201, 0.1846, 102.2, 1.5915, 3.3177e-3, 0.0192),
    },
    DrivePreset {
        id: "mill-y",
        title: "Y axis of an identified three-axis mill, its dry friction left out",
        axes: &[Y],
        assumed: MILL_ASSUMED,
        drive: mill(3.1201, 0.2151, 102.2, 1.5915, 3.8650e-3, 0.0219),
    },
    DrivePreset {
        id: "mill-z",
        title: "Z axis of an identified three-axis mill, its dry friction left out",
        axes: &[Z],
        assumed: MILL_ASSUMED,
        drive: mill(3.1201, 0.35, 50.0, 6.3662, 15.974e-3, 0.0041),
    },
];

impl DrivePreset {
    /// The preset with this id.
    #[must_use]
    pub fn by_id(id: &str) -> Option<&'static Self> {
        const ROWS: &[DrivePreset] = &DRIVE_PRESETS;
        ROWS.iter().find(|preset| preset.id == id)
    }
}
