//! Poles, margins and bandwidth: whether a drive may run, and how near it is to its limits.

use nalgebra::linalg::{Schur, balancing};
use nalgebra::{Complex, DMatrix};
use thiserror::Error;

use super::{Drive, Feedback, StateSpace};

/// The closed loop has a pole in the right half plane or on its edge.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("the loop is unstable: its right-most pole is {} {:+}i 1/s; lower the gains", worst.re, worst.im)]
pub struct UnstableLoop {
    /// All poles \[1/s\], the right-most first.
    pub poles_per_s: Vec<Complex<f64>>,
    /// The right-most pole.
    pub worst: Complex<f64>,
}

/// The margins of a position loop; `None` if there is no such crossing.
#[derive(Debug, Clone, PartialEq)]
pub struct Stability {
    /// Poles of the closed loop \[1/s\], the right-most first.
    pub poles_per_s: Vec<Complex<f64>>,
    /// Factor by which Kpp may be multiplied before the loop oscillates.
    pub gain_margin: Option<f64>,
    /// Phase margin where the open loop's gain is 1 \[rad\].
    pub phase_margin_rad: Option<f64>,
    /// Lowest frequency at which the closed loop's gain falls below 1/√2 \[Hz\].
    pub bandwidth_hz: Option<f64>,
    /// Largest gain of the closed loop over all frequencies.
    pub resonance_peak: f64,
}

/// A real part within this share of the largest pole's size counts as zero.
const EDGE: f64 = 1e-13;
/// Most rounds of the QR iteration. A few are enough for six states.
const MAX_ROUNDS: usize = 10_000;
/// Frequencies per decade in the first scan.
const PER_DECADE: i32 = 60;
/// Start and end of the scan, relative to the slowest and fastest pole.
const BELOW: f64 = 1e-3;
const ABOVE: f64 = 1e3;
/// Halvings that narrow an interval of 4 % to the last digit.
const HALVINGS: u32 = 60;

/// Poles of the closed loop \[1/s\], the right-most first.
#[must_use]
pub fn poles(drive: &Drive) -> Vec<Complex<f64>> {
    let mut a = StateSpace::of(drive).a;
    balancing::balance_parlett_reinsch(&mut a);
    eigenvalues(a)
}

fn eigenvalues(matrix: DMatrix<f64>) -> Vec<Complex<f64>> {
    // An iteration that does not end is treated like a pole at infinity: refused.
    let mut poles = Schur::try_new(matrix, f64::EPSILON, MAX_ROUNDS).map_or_else(
        || vec![Complex::new(f64::INFINITY, 0.0)],
        |schur| schur.complex_eigenvalues().iter().copied().collect(),
    );
    poles.sort_by(|p, q| q.re.total_cmp(&p.re).then(q.im.total_cmp(&p.im)));
    poles
}

/// The poles, if all of them decay.
///
/// # Errors
/// A pole whose real part is not below zero.
pub fn stable_poles(drive: &Drive) -> Result<Vec<Complex<f64>>, UnstableLoop> {
    let poles = poles(drive);
    let largest = poles.iter().map(|pole| pole.norm()).fold(0.0, f64::max);
    match poles.first() {
        Some(worst) if worst.re.is_nan() || worst.re >= -EDGE * largest || !largest.is_finite() => {
            Err(UnstableLoop { worst: *worst, poles_per_s: poles })
        }
        _ => Ok(poles),
    }
}

/// Number of time constants of the slowest pole until an axis is at rest: 0.7 % of that mode remains, and every
/// overshoot has been seen.
const SETTLING_TIME_CONSTANTS: f64 = 5.0;
/// Longest settling time of an axis \[s\]. The loops of a machine tool need a tenth of it (0.6 s with the reference
/// drive), and it limits the cost of slower ones.
pub const MAX_SETTLING_S: f64 = 10.0;

/// Time that an axis needs to come to rest after its command \[s\]; 0 for an axis that never does, which no run
/// accepts.
#[must_use]
pub fn settling_s(drive: &Drive) -> f64 {
    let slowest = stable_poles(drive).ok().and_then(|poles| poles.first().map(|pole| -pole.re));
    slowest.map_or(0.0, |per_s| (SETTLING_TIME_CONSTANTS / per_s).min(MAX_SETTLING_S))
}

/// Positions of motor and load for a unit of v* \[s\]: the speed loop and its load at complex frequency s, directly
/// from the equations of `math.md` §3 (no matrices).
fn speed_loop(drive: &Drive, s: Complex<f64>) -> [Complex<f64>; 2] {
    let to_load = transmission(drive, s);
    // Torque on the motor per motor speed: C + J s, and J_l s G if two masses are modelled.
    let load = drive.load_inertia_kg_m2.unwrap_or(0.0) * s * to_load;
    let impedance = s * drive.inertia_kg_m2 + drive.damping_nm_s_per_rad + load;
    let winding = s * drive.inductance_h + drive.resistance_ohm + drive.current_gain_v_per_a;
    // (L s + Rb + Kcp) i = Kcp i* − Ke ω;  Kt i = impedance ω
    let current_per_speed = impedance / drive.torque_constant_nm_per_a;
    let speed_per_wanted_current =
        drive.current_gain_v_per_a / (winding * current_per_speed + drive.back_emf_v_s_per_rad);
    let controller = speed_controller(drive, s);
    let speed = controller * speed_per_wanted_current / (1.0 + controller * speed_per_wanted_current);
    let motor = speed / s;
    [motor, motor * to_load]
}

/// i* for each rad/s of speed error.
fn speed_controller(drive: &Drive, s: Complex<f64>) -> Complex<f64> {
    drive.velocity_gain_a_s_per_rad * (1.0 + 1.0 / (drive.velocity_integral_time_s * s))
}

/// G(s) = y/(ρθ).
fn transmission(drive: &Drive, s: Complex<f64>) -> Complex<f64> {
    let Some(resonance) = drive.resonance else { return Complex::new(1.0, 0.0) };
    let omega_n = std::f64::consts::TAU * resonance.frequency_hz;
    let damper = 2.0 * resonance.damping_ratio * omega_n * s;
    let spring = omega_n * omega_n;
    let above = if drive.load_inertia_kg_m2.is_some() { spring + damper } else { Complex::new(spring, 0.0) };
    above / (s * s + damper + spring)
}

/// Open position loop: measured position for a unit of position error.
#[must_use]
pub fn open_loop(drive: &Drive, s: Complex<f64>) -> Complex<f64> {
    let [motor, load] = speed_loop(drive, s);
    let measured = match drive.feedback {
        Feedback::Motor => motor,
        Feedback::Load => load,
    };
    measured * drive.position_gain_per_s
}

/// Closed loop y/r at complex frequency s, feed-forward included.
#[must_use]
pub fn closed_loop(drive: &Drive, s: Complex<f64>) -> Complex<f64> {
    let [_, load] = speed_loop(drive, s);
    let current_per_speed = speed_controller(drive, s);
    // A current added to i* acts like v* = ρ i*/controller.
    let forward = drive.velocity_feedforward * s
        + drive.acceleration_feedforward * drive.total_inertia_kg_m2() / drive.torque_constant_nm_per_a
            * s
            * s
            / current_per_speed;
    load * (drive.position_gain_per_s + forward) / (1.0 + open_loop(drive, s))
}

impl Stability {
    /// Poles, margins and bandwidth of a drive without faults.
    ///
    /// # Errors
    /// The loop is unstable.
    pub fn of(drive: &Drive) -> Result<Self, UnstableLoop> {
        let poles_per_s = stable_poles(drive)?;
        let frequencies = frequencies(&poles_per_s);
        let open = |omega: f64| open_loop(drive, Complex::new(0.0, omega));
        let closed = |omega: f64| closed_loop(drive, Complex::new(0.0, omega)).norm();
        let mut gain_margin: Option<f64> = None;
        let mut phase_margin_rad: Option<f64> = None;
        let mut bandwidth_hz = None;
        let mut resonance_peak = 1.0_f64;
        for pair in frequencies.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let (a, b) = (open(from), open(to));
            resonance_peak = resonance_peak.max(closed(from));
            // The locus crosses the negative real axis: Kpp may be larger by the factor 1/|L|.
            if a.im.signum() != b.im.signum() && a.re.min(b.re) < 0.0 {
                let at = open(bisect(from, to, |omega| open(omega).im));
                if at.re < 0.0 && at.norm() < 1.0 {
                    gain_margin =
                        Some(gain_margin.map_or(1.0 / at.norm(), |margin| margin.min(1.0 / at.norm())));
                }
            }
            if (a.norm() - 1.0).signum() != (b.norm() - 1.0).signum() {
                let at = open(bisect(from, to, |omega| open(omega).norm() - 1.0));
                let margin = (-at).arg().abs();
                phase_margin_rad = Some(phase_margin_rad.map_or(margin, |least: f64| least.min(margin)));
            }
            let level = std::f64::consts::FRAC_1_SQRT_2;
            if bandwidth_hz.is_none() && closed(from) >= level && closed(to) < level {
                let omega = bisect(from, to, |omega| closed(omega) - level);
                bandwidth_hz = Some(omega / std::f64::consts::TAU);
            }
        }
        Ok(Self { poles_per_s, gain_margin, phase_margin_rad, bandwidth_hz, resonance_peak })
    }
}

/// Angular frequencies to check \[rad/s\]: evenly over the decades of the poles, and closely about each pole, where
/// a narrow resonance may be.
fn frequencies(poles: &[Complex<f64>]) -> Vec<f64> {
    let sizes = poles.iter().map(|pole| pole.norm());
    let slowest = sizes.clone().fold(f64::INFINITY, f64::min) * BELOW;
    let fastest = sizes.fold(0.0, f64::max) * ABOVE;
    let mut all = Vec::new();
    let factor = 10_f64.powf(1.0 / f64::from(PER_DECADE));
    let mut omega = slowest;
    while omega <= fastest {
        all.push(omega);
        omega *= factor;
    }
    for pole in poles.iter().filter(|pole| pole.im > 0.0) {
        for k in -40..=40_i32 {
            all.push(pole.im + pole.re * f64::from(k) / 8.0);
        }
    }
    all.retain(|omega| *omega > 0.0);
    all.sort_by(f64::total_cmp);
    all
}

fn bisect(mut from: f64, mut to: f64, value: impl Fn(f64) -> f64) -> f64 {
    let rises = value(from) < 0.0;
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        if (value(middle) < 0.0) == rises {
            from = middle;
        } else {
            to = middle;
        }
    }
    0.5 * (from + to)
}
