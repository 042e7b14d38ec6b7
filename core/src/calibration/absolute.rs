//! Location errors against the machine's frame, with the symbols of ISO 230-7.

use nalgebra::DMatrix;

use super::blind::Blind;
use super::{ErrorParameter, Unknown};
use crate::geometry::{Vec3, across};
use crate::machine::{LocationError, Machine, RotaryLetter};

/// One location error of one axis against the machine's frame: the part of a shift or turn across the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AbsoluteError {
    /// The axis, in the profile's order.
    pub axis: usize,
    /// 0–2 `E_X0· E_Y0· E_Z0·` \[mm\], 3–5 `E_A0· E_B0· E_C0·` \[rad\].
    pub component: usize,
    /// \[mm or rad\]
    pub value: f64,
    /// Variance \[mm² or rad²\]; `None` if the readings give none.
    pub variance: Option<f64>,
    /// Whether the readings determine it. If not, the value holds under the assumptions made.
    pub identifiable: bool,
}

/// An axis this parallel to X, Y or Z has no error along or about it: the cosine of 45 µrad.
const ALONG: f64 = 1.0 - 1e-9;

/// The symbol of ISO 230-7 for a component (0–5) of an axis' error against the machine's frame: `E_X0C`.
#[must_use]
pub fn iso_230_symbol(letter: RotaryLetter, component: usize) -> String {
    let motion = ['X', 'Y', 'Z', 'A', 'B', 'C'].get(component).copied().unwrap_or('?');
    format!("E_{motion}0{}", letter.as_char())
}

/// The absolute errors of both axes of a machine, from the location errors of its profile, without variances.
#[must_use]
pub fn absolute_errors(machine: &Machine) -> Vec<AbsoluteError> {
    let errors = machine.rotary_axes().each_ref().map(|axis| axis.location_error);
    absolute_estimates(machine, &errors, &[], None, &[], &[])
}

/// The share of each cascaded component in an absolute one, first order in the errors (shared notation §1, end):
/// an inner axis of the same chain carries the outer axis' reference point along.
fn share(machine: &Machine, parameter: ErrorParameter, axis: usize, component: usize) -> f64 {
    let axes = machine.rotary_axes();
    let (moved, carried) = (&axes[parameter.axis], &axes[axis]);
    if parameter.axis > axis || moved.side != carried.side {
        return 0.0;
    }
    let unit = Vec3::ith(parameter.component % 3, 1.0);
    let (shift, turn) = if parameter.is_angle() {
        (unit.cross(&(carried.point_mm - moved.point_mm)), unit)
    } else {
        (unit, Vec3::zeros())
    };
    let whole = if component < 3 { shift } else { turn };
    across(whole, carried.direction)[component % 3]
}

/// The components of an axis: those that are not along or about it.
fn components(machine: &Machine, axis: usize) -> impl Iterator<Item = usize> {
    let direction = machine.rotary_axes()[axis].direction;
    (0..6).filter(move |component| direction[component % 3].abs() < ALONG)
}

/// The absolute errors of both axes, with variances from the covariance of `unknowns`.
pub(super) fn absolute_estimates(
    machine: &Machine,
    errors: &[LocationError; 2],
    unknowns: &[Unknown],
    covariance: Option<&DMatrix<f64>>,
    undetermined: &[bool],
    blind: &[Blind],
) -> Vec<AbsoluteError> {
    /// A share of a combination below this is rounding (µm or µrad per µm or µrad).
    const PART: f64 = 1e-6;
    let mut absolute = Vec::new();
    for axis in 0..2 {
        for component in components(machine, axis) {
            let shares: Vec<f64> = unknowns
                .iter()
                .map(|unknown| match unknown {
                    Unknown::Error(parameter) => share(machine, *parameter, axis, component),
                    Unknown::SetupError(_) => 0.0,
                })
                .collect();
            let value = ErrorParameter::every()
                .map(|parameter| share(machine, parameter, axis, component) * parameter.value(errors))
                .sum();
            let open = shares.iter().zip(undetermined).any(|(share, open)| *share != 0.0 && *open);
            let variance = covariance.filter(|_| !open).map(|covariance| {
                let mut sum = 0.0;
                for (row, left) in shares.iter().enumerate() {
                    for (column, right) in shares.iter().enumerate() {
                        sum += left * right * covariance[(row, column)];
                    }
                }
                sum
            });
            let hidden = blind.iter().any(|blind| {
                let part: f64 = blind
                    .parts
                    .iter()
                    .map(|(unknown, part)| match unknown {
                        Unknown::Error(parameter) => share(machine, *parameter, axis, component) * part,
                        Unknown::SetupError(_) => 0.0,
                    })
                    .sum();
                part.abs() > PART
            });
            absolute.push(AbsoluteError { axis, component, value, variance, identifiable: !open && !hidden });
        }
    }
    absolute
}
