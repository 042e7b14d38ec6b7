//! Exact discretisation: matrix exponential, first-order hold on the command.

use nalgebra::linalg::balancing;
use nalgebra::{DMatrix, DVector, SMatrix};
use thiserror::Error;

use super::StateSpace;

/// One step of length h: `z(t+h) = Φ z + Γ0 r(t) + Γ1 r(t+h)`, exact for a command that is linear within the
/// step.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Φ.
    pub transition: DMatrix<f64>,
    /// Γ0.
    pub from_old: DVector<f64>,
    /// Γ1.
    pub from_new: DVector<f64>,
    /// Index of the state that is the position.
    pub output: usize,
}

/// A drive has no step for a sample period.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "the loops move by a factor of e^{exponent:e} within a sample period of {period_s} s; the limit is e^{max:e}; take a shorter sample period"
)]
pub struct TooStiff {
    /// Norm of A h, balanced.
    pub exponent: f64,
    /// Sample period \[s\].
    pub period_s: f64,
    /// Largest norm accepted.
    pub max: f64,
}

/// Largest ‖A h‖. Beyond it the squarings of the matrix exponential lose the digits of the slow poles.
const MAX_NORM: f64 = 1e7;

impl Step {
    /// Discretises for a sample period h \[s\].
    ///
    /// The exponential of `[[A, B, 0], [0, 0, 1/h], [0, 0, 0]] h` holds Φ, the response to a constant command and
    /// that to a command which rises by 1 (Van Loan 1978). A is balanced first, by powers of two.
    ///
    /// # Errors
    /// ‖A h‖ is too large for the exponential to keep its digits.
    pub fn new(system: &StateSpace, period_s: f64) -> Result<Self, TooStiff> {
        let states = system.states();
        let mut balanced = &system.a * period_s;
        let scale = balancing::balance_parlett_reinsch(&mut balanced);
        let norm = balanced.norm();
        if norm.is_nan() || norm > MAX_NORM {
            return Err(TooStiff { exponent: norm, period_s, max: MAX_NORM });
        }
        let mut input = system.b.component_div(&scale) * period_s;
        let unit = power_of_two_near(input.norm() / norm.max(1.0));
        input /= unit;
        let mut augmented = DMatrix::zeros(states + 2, states + 2);
        augmented.view_mut((0, 0), (states, states)).copy_from(&balanced);
        augmented.view_mut((0, states), (states, 1)).copy_from(&input);
        augmented[(states, states + 1)] = 1.0;
        let exponential = match states {
            4 => exponential::<6>(&augmented, |matrix| matrix.exp()),
            _ => exponential::<8>(&augmented, |matrix| matrix.exp()),
        };
        if !exponential.iter().all(|value| value.is_finite()) {
            return Err(TooStiff { exponent: norm, period_s, max: MAX_NORM });
        }
        let mut transition = exponential.view((0, 0), (states, states)).into_owned();
        balancing::unbalance(&mut transition, &scale);
        let column = |k: usize| {
            let column: DVector<f64> = exponential.view((0, states + k), (states, 1)).column(0).into_owned();
            column.component_mul(&scale) * unit
        };
        let (constant, rise) = (column(0), column(1));
        Ok(Self { transition, from_old: constant - &rise, from_new: rise, output: system.output })
    }

    /// The state one step later.
    #[must_use]
    pub fn advance(&self, state: &DVector<f64>, old: f64, new: f64) -> DVector<f64> {
        &self.transition * state + &self.from_old * old + &self.from_new * new
    }
}

/// The exponential with a matrix of fixed size. Products of other matrices may use fused multiply-add if the
/// processor has it, but the digits must be the same everywhere.
fn exponential<const N: usize>(
    matrix: &DMatrix<f64>,
    exp: impl Fn(SMatrix<f64, N, N>) -> SMatrix<f64, N, N>,
) -> DMatrix<f64> {
    let fixed = exp(SMatrix::from_fn(|row, column| matrix[(row, column)]));
    DMatrix::from_fn(N, N, |row, column| fixed[(row, column)])
}

/// 2ⁿ near a positive number, so that scaling by it is exact.
fn power_of_two_near(value: f64) -> f64 {
    if value.is_normal() && value > 0.0 {
        f64::from_bits(value.to_bits() & 0x7ff0_0000_0000_0000)
    } else {
        1.0
    }
}
