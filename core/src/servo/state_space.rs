//! The drive as a linear system: `z′ = A z + B r`, `y = C z`.

use nalgebra::{DMatrix, DVector};

use super::{Drive, Feedback};

/// Order of the states of a rigid axis: current i \[A\], motor speed ω \[rad/s\], integral of the speed error q
/// \[rad\], motor position in output units p = ρθ. A resonance adds the load's position y in output units and its
/// speed.
const CURRENT: usize = 0;
const SPEED: usize = 1;
const INTEGRAL: usize = 2;
const MOTOR: usize = 3;
const LOAD: usize = 4;
const LOAD_SPEED: usize = 5;

/// The closed loop of one axis from the command r to the position y, both in output units (mm, or rad).
///
/// Feed-forward needs r′ and r″. They are not separate inputs: with `x′ = A x + B0 r + B1 r′ + B2 r″` the states
/// `z = x − B2 r′ − (B1 + A B2) r` obey `z′ = A z + (B0 + A B1 + A² B2) r`. Then y = C x = C z, because neither B2
/// (the current) nor B1 and A B2 (current, speeds, their integral) change a position at once.
#[derive(Debug, Clone, PartialEq)]
pub struct StateSpace {
    /// A.
    pub a: DMatrix<f64>,
    /// B.
    pub b: DVector<f64>,
    /// Index of the state that is the position y.
    pub output: usize,
    /// `−(B1 + A B2)`: the part of z besides the positions for a command at rest at 1.
    rest_shift: DVector<f64>,
    /// States in equilibrium under the load torque, without the positions.
    loaded: DVector<f64>,
}

impl StateSpace {
    /// The closed loop of a drive (`math.md` §3). The drive must have no faults.
    #[must_use]
    pub fn of(drive: &Drive) -> Self {
        let Drive {
            position_gain_per_s: kpp,
            velocity_gain_a_s_per_rad: kvp,
            velocity_integral_time_s: ti,
            current_gain_v_per_a: kcp,
            inductance_h: l,
            resistance_ohm: rb,
            torque_constant_nm_per_a: kt,
            back_emf_v_s_per_rad: ke,
            inertia_kg_m2: j,
            damping_nm_s_per_rad: c,
            output_per_motor_rad: rho,
            ..
        } = *drive;
        let states = if drive.resonance.is_some() { 6 } else { 4 };
        let output = if drive.resonance.is_some() { LOAD } else { MOTOR };
        let measured = match drive.feedback {
            Feedback::Load => output,
            Feedback::Motor => MOTOR,
        };
        let mut a = DMatrix::zeros(states, states);
        // e_v = v*/ρ − ω with v* = Kpp (r − y_fb) + kv r′;  q′ = e_v
        a[(INTEGRAL, measured)] = -kpp / rho;
        a[(INTEGRAL, SPEED)] = -1.0;
        // L i′ = Kcp (Kvp (e_v + q/Ti) − i) − Rb i − Ke ω
        a[(CURRENT, measured)] = -kcp * kvp * kpp / rho / l;
        a[(CURRENT, SPEED)] = -(kcp * kvp + ke) / l;
        a[(CURRENT, INTEGRAL)] = kcp * kvp / ti / l;
        a[(CURRENT, CURRENT)] = -(kcp + rb) / l;
        // J ω′ = Kt i − C ω − T_s;  p′ = ρ ω
        a[(SPEED, CURRENT)] = kt / j;
        a[(SPEED, SPEED)] = -c / j;
        a[(MOTOR, SPEED)] = rho;
        if let Some(resonance) = drive.resonance {
            let omega_n = std::f64::consts::TAU * resonance.frequency_hz;
            let damping = 2.0 * resonance.damping_ratio * omega_n;
            // y″ = ωn² (p − y) + 2ζωn (ρω − y′) for two masses; the filter damps only its own speed.
            a[(LOAD, LOAD_SPEED)] = 1.0;
            a[(LOAD_SPEED, MOTOR)] = omega_n * omega_n;
            a[(LOAD_SPEED, LOAD)] = -omega_n * omega_n;
            a[(LOAD_SPEED, LOAD_SPEED)] = -damping;
            if let Some(load_inertia) = drive.load_inertia_kg_m2 {
                a[(LOAD_SPEED, SPEED)] = damping * rho;
                // T_s = J_l y″/ρ acts on the motor.
                for state in [SPEED, MOTOR, LOAD, LOAD_SPEED] {
                    a[(SPEED, state)] -= load_inertia / j * a[(LOAD_SPEED, state)] / rho;
                }
            }
        }
        let speed_step = |share: f64| {
            let mut column = DVector::zeros(states);
            column[INTEGRAL] = share / rho;
            column[CURRENT] = kcp * kvp * share / rho / l;
            column
        };
        let b0 = speed_step(kpp);
        let b1 = speed_step(drive.velocity_feedforward);
        let mut b2 = DVector::zeros(states);
        b2[CURRENT] = kcp / l * drive.acceleration_feedforward * drive.total_inertia_kg_m2() / (kt * rho);
        let from_derivatives = b1 + &a * b2;
        let b = b0 + &a * &from_derivatives;
        // Kt i = T;  u = Kcp (i* − i) = Rb i;  i* = Kvp q/Ti
        let mut loaded = DVector::zeros(states);
        loaded[CURRENT] = drive.load_torque_nm / kt;
        loaded[INTEGRAL] = loaded[CURRENT] * (1.0 + rb / kcp) * ti / kvp;
        Self { a, b, output, rest_shift: -from_derivatives, loaded }
    }

    /// The number of states.
    #[must_use]
    pub fn states(&self) -> usize {
        self.b.len()
    }

    /// z of an axis at rest at `position` (output units) before the load torque acts. The system is written about
    /// the loaded equilibrium, so a torque that begins at t = 0 is a start away from equilibrium.
    #[must_use]
    pub fn at_rest(&self, position: f64) -> DVector<f64> {
        let mut state = &self.rest_shift * position - &self.loaded;
        state[MOTOR] += position;
        if self.states() > LOAD {
            state[LOAD] += position;
        }
        state
    }
}
