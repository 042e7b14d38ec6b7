//! One axis with its cascaded drive: the checked constants and their names.

use std::fmt;

use thiserror::Error;

use crate::units::legible;

/// Address letter of a driven axis (ISO 841).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[expect(missing_docs, reason = "the letters say it")]
pub enum AxisLetter {
    X,
    Y,
    Z,
    A,
    B,
    C,
}

impl AxisLetter {
    /// All letters, linear axes first.
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::A, Self::B, Self::C];

    /// The letter as in a program.
    #[must_use]
    pub const fn as_char(self) -> char {
        match self {
            Self::X => 'X',
            Self::Y => 'Y',
            Self::Z => 'Z',
            Self::A => 'A',
            Self::B => 'B',
            Self::C => 'C',
        }
    }

    /// The axis with this letter.
    #[must_use]
    pub fn from_char(letter: char) -> Option<Self> {
        Self::ALL.into_iter().find(|axis| axis.as_char() == letter)
    }

    /// Whether positions of the axis are lengths \[mm\]; otherwise they are angles \[rad\].
    #[must_use]
    pub const fn is_linear(self) -> bool {
        matches!(self, Self::X | Self::Y | Self::Z)
    }
}

impl fmt::Display for AxisLetter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Write::write_char(f, self.as_char())
    }
}

/// The position measurement of an axis.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Feedback {
    /// On the load: the control measures the part that moves.
    #[default]
    Load,
    /// On the motor: errors of the transmission stay outside the loop.
    Motor,
}

/// A resonance between motor and load: natural frequency ωn = 2π f and damping ratio ζ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resonance {
    /// f \[Hz\].
    pub frequency_hz: f64,
    /// ζ.
    pub damping_ratio: f64,
}

/// Constants of one cascaded drive (P / PI / P) at the motor shaft, coherent SI; letters of `math.md` §3.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drive {
    /// Kpp \[1/s\].
    pub position_gain_per_s: f64,
    /// Kvp [A s/rad].
    pub velocity_gain_a_s_per_rad: f64,
    /// Ti \[s\].
    pub velocity_integral_time_s: f64,
    /// Kcp \[V/A\].
    pub current_gain_v_per_a: f64,
    /// L \[H\].
    pub inductance_h: f64,
    /// Rb \[Ω\].
    pub resistance_ohm: f64,
    /// Kt \[Nm/A\].
    pub torque_constant_nm_per_a: f64,
    /// Ke [V s/rad].
    pub back_emf_v_s_per_rad: f64,
    /// J [kg m²]: of the whole axis, or of the motor side if the load is modelled separately.
    pub inertia_kg_m2: f64,
    /// `J_l` [kg m²] on the motor shaft, for a true two-mass axis. It needs a resonance.
    pub load_inertia_kg_m2: Option<f64>,
    /// C [Nm s/rad].
    pub damping_nm_s_per_rad: f64,
    /// Constant load torque T \[Nm\], acting from t = 0 on.
    pub load_torque_nm: f64,
    /// ρ: output units (mm, or rad) for each radian of the motor.
    pub output_per_motor_rad: f64,
    /// Resonance between motor and load. Without it the transmission is rigid.
    pub resonance: Option<Resonance>,
    /// Place of the position measurement.
    pub feedback: Feedback,
    /// Share of the commanded velocity added to v*.
    pub velocity_feedforward: f64,
    /// Share of the current that the commanded acceleration of a rigid axis needs, added to i*.
    pub acceleration_feedforward: f64,
}

/// A fault of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum DriveFault {
    /// A constant outside its range.
    #[error("{name} is {}; it must be between {} and {}", legible(.value), legible(.min), legible(.max))]
    OutOfRange {
        /// Name of the constant in the contract.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Smallest accepted.
        min: f64,
        /// Largest accepted.
        max: f64,
    },
    /// A two-mass axis without the spring between its masses.
    #[error(
        "load_inertia_kg_m2 models two masses, which need transmission.resonance: give it, or leave load_inertia_kg_m2 out"
    )]
    TwoMassesWithoutSpring,
}

impl DriveFault {
    /// The constant concerned.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::OutOfRange { name, .. } => name,
            Self::TwoMassesWithoutSpring => "load_inertia_kg_m2",
        }
    }
}

/// Smallest value of a constant that must be positive: far below any drive, far above underflow.
const TINY: f64 = 1e-12;

impl Drive {
    /// All faults of the constants; empty for a drive that can be simulated.
    #[must_use]
    pub fn faults(&self) -> Vec<DriveFault> {
        let ranges = [
            ("position_gain_per_s", self.position_gain_per_s, TINY, 1e5),
            ("velocity_gain_a_s_per_rad", self.velocity_gain_a_s_per_rad, TINY, 1e6),
            ("velocity_integral_time_s", self.velocity_integral_time_s, TINY, 1e3),
            ("current_gain_v_per_a", self.current_gain_v_per_a, TINY, 1e6),
            ("inductance_h", self.inductance_h, TINY, 1e3),
            ("resistance_ohm", self.resistance_ohm, TINY, 1e5),
            ("torque_constant_nm_per_a", self.torque_constant_nm_per_a, TINY, 1e5),
            ("inertia_kg_m2", self.inertia_kg_m2, TINY, 1e6),
            ("load_inertia_kg_m2", self.load_inertia_kg_m2.unwrap_or(1.0), TINY, 1e6),
            ("back_emf_v_s_per_rad", self.back_emf_v_s_per_rad, 0.0, 1e5),
            ("damping_nm_s_per_rad", self.damping_nm_s_per_rad, 0.0, 1e6),
            ("load_torque_nm", self.load_torque_nm, -1e6, 1e6),
            ("velocity_feedforward", self.velocity_feedforward, 0.0, 2.0),
            ("acceleration_feedforward", self.acceleration_feedforward, 0.0, 2.0),
            ("transmission", self.output_per_motor_rad, TINY, 1e6),
            (
                "transmission.resonance.frequency_hz",
                self.resonance.map_or(1.0, |r| r.frequency_hz),
                1e-3,
                1e6,
            ),
            (
                "transmission.resonance.damping_ratio",
                self.resonance.map_or(0.0, |r| r.damping_ratio),
                0.0,
                10.0,
            ),
        ];
        let mut faults: Vec<DriveFault> = ranges
            .into_iter()
            // NaN is in no range.
            .filter(|(_, value, min, max)| !(*min..=*max).contains(value))
            .map(|(name, value, min, max)| DriveFault::OutOfRange { name, value, min, max })
            .collect();
        if self.load_inertia_kg_m2.is_some() && self.resonance.is_none() {
            faults.push(DriveFault::TwoMassesWithoutSpring);
        }
        faults
    }

    /// The same drive with its position gain Kpp multiplied.
    #[must_use]
    pub fn with_position_gain_scaled(self, factor: f64) -> Self {
        Self { position_gain_per_s: self.position_gain_per_s * factor, ..self }
    }

    /// The same drive with this Kpp \[1/s\].
    #[must_use]
    pub fn with_position_gain(self, position_gain_per_s: f64) -> Self {
        Self { position_gain_per_s, ..self }
    }

    /// Kv: commanded velocity over the steady following error of a ramp \[1/s\], `Kpp / (1 − kff)` for any
    /// friction, back-EMF and constant load (`math.md` §3). Negative if the feed-forward is too large; `None` if
    /// it leaves no error.
    #[must_use]
    pub fn velocity_gain_factor_per_s(&self) -> Option<f64> {
        let left = 1.0 - self.velocity_feedforward;
        (left != 0.0).then(|| self.position_gain_per_s / left)
    }

    /// The inertia that the motor accelerates at low frequency [kg m²].
    #[must_use]
    pub fn total_inertia_kg_m2(&self) -> f64 {
        self.inertia_kg_m2 + self.load_inertia_kg_m2.unwrap_or(0.0)
    }
}
