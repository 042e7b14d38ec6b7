//! A run of probed spheres: first each axis, then the location errors of the machine.

use nalgebra::DMatrix;
use thiserror::Error;

use super::{
    AxisFit, ExpectedAxis, LocationFault, SphereFault, SphereReading, fit_circle, fit_rotation,
    location_errors,
};
use crate::calibration::absolute::{AbsoluteError, absolute_estimates};
use crate::calibration::{ErrorParameter, Unknown};
use crate::geometry::{Screw, Vec3, rotation_from_vector};
use crate::machine::{LocationError, Machine, Side};

/// A probed centre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Center {
    /// The sphere.
    pub ball: usize,
    /// Kinematic angle of the axis \[rad\], if it was recorded.
    pub angle_rad: Option<f64>,
    /// Centre in M \[mm\].
    pub center_mm: Vec3,
}

/// The centres probed while one axis turned, with the other at zero.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisCenters {
    /// The axis, in the profile's order.
    pub axis: usize,
    /// In the order of measurement.
    pub centers: Vec<Center>,
}

/// One reason why a run of spheres is not evaluated. Entries are counted from 0.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SphereRunFault {
    /// No axis, or more axes than the machine can have.
    #[error("spheres are given for {axes} axes, but a run has 1 or {max}")]
    AxisCount {
        /// Number given.
        axes: usize,
        /// Largest number.
        max: usize,
    },
    /// The machine has no such axis.
    #[error("the machine has no rotary axis with index {index}; name one of its axes")]
    NoSuchAxis {
        /// The entry.
        entry: usize,
        /// The index given.
        index: usize,
    },
    /// The same axis twice.
    #[error("the axis was given before; put all its centres into one entry")]
    Repeated {
        /// The entry.
        entry: usize,
    },
    /// A head axis: its spheres are not in the machine's frame.
    #[error("the axis is on the head, but spheres are probed on a table axis; use a ball bar instead")]
    OnHead {
        /// The entry.
        entry: usize,
    },
    /// Angles for some centres only.
    #[error("{with} of {centers} centres have an angle; give it for all of them or for none")]
    SomeAngles {
        /// The entry.
        entry: usize,
        /// Number of centres with an angle.
        with: usize,
        /// Number of all centres.
        centers: usize,
    },
    /// Several spheres without the angles that relate them.
    #[error("{balls} spheres need the angle of every centre; without angles only one sphere can be fitted")]
    BallsWithoutAngles {
        /// The entry.
        entry: usize,
        /// Number of spheres.
        balls: usize,
    },
    /// The centres show no axis.
    #[error("{fault}")]
    Fit {
        /// The entry.
        entry: usize,
        /// The reason.
        fault: SphereFault,
    },
    /// The axes found are not the nominal ones with errors.
    #[error("{fault}")]
    Location {
        /// The reason.
        fault: LocationFault,
    },
}

/// The result of probed spheres for a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct SphereIdentified {
    /// The axes found, in the order of the run.
    pub fits: Vec<AxisFit>,
    /// Cascaded location errors. An axis that was not probed keeps its own.
    pub errors: [LocationError; 2],
    /// The components that the run determines, in the order of `covariance`.
    pub parameters: Vec<ErrorParameter>,
    /// Covariance of `parameters` \[mm², mm·rad, rad²\], Type A; `None` if a fit has no degrees of freedom to
    /// estimate it.
    pub covariance: Option<DMatrix<f64>>,
    /// Errors of the probed axes against the machine's frame.
    pub absolute: Vec<AbsoluteError>,
}

/// Identifies each probed axis ([`fit_rotation`] if angles are known, otherwise [`fit_circle`]), and the location
/// errors with which the machine has these axes ([`location_errors`]).
///
/// # Errors
/// Everything wrong with the run.
pub fn identify_spheres(
    machine: &Machine,
    run: &[AxisCenters],
) -> Result<SphereIdentified, Vec<SphereRunFault>> {
    let max = machine.rotary_axes().len();
    if !(1..=max).contains(&run.len()) {
        return Err(vec![SphereRunFault::AxisCount { axes: run.len(), max }]);
    }
    let mut faults = Vec::new();
    let mut fits = Vec::new();
    for (entry, probed) in run.iter().enumerate() {
        match fit(machine, run, entry, probed) {
            Ok(found) => fits.push(found),
            Err(found) => faults.extend(found),
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let mut lines = [None; 2];
    for (probed, found) in run.iter().zip(&fits) {
        lines[probed.axis] = Some(found.line);
    }
    let errors = location_errors(machine, lines).map_err(|faults| {
        faults.into_iter().map(|fault| SphereRunFault::Location { fault }).collect::<Vec<_>>()
    })?;
    let slopes = slopes(machine, run, &fits, lines);
    let parameters: Vec<ErrorParameter> = ErrorParameter::every()
        .enumerate()
        .filter(|(row, _)| slopes.row(*row).norm() > STILL)
        .map(|(_, parameter)| parameter)
        .collect();
    let covariance = covariance(&parameters, &slopes, &fits);
    let unknowns: Vec<Unknown> = parameters.iter().copied().map(Unknown::Error).collect();
    let undetermined = vec![false; unknowns.len()];
    let mut absolute =
        absolute_estimates(machine, &errors, &unknowns, covariance.as_ref(), &undetermined, &[]);
    absolute.retain(|error| run.iter().any(|probed| probed.axis == error.axis));
    Ok(SphereIdentified { fits, errors, parameters, covariance, absolute })
}

fn fit(
    machine: &Machine,
    run: &[AxisCenters],
    entry: usize,
    probed: &AxisCenters,
) -> Result<AxisFit, Vec<SphereRunFault>> {
    let Some(axis) = machine.rotary_axes().get(probed.axis) else {
        return Err(vec![SphereRunFault::NoSuchAxis { entry, index: probed.axis }]);
    };
    if run.iter().take(entry).any(|before| before.axis == probed.axis) {
        return Err(vec![SphereRunFault::Repeated { entry }]);
    }
    if axis.side == Side::Head {
        return Err(vec![SphereRunFault::OnHead { entry }]);
    }
    let expected = ExpectedAxis::of(axis);
    let centers = probed.centers.len();
    let readings: Vec<SphereReading> = probed
        .centers
        .iter()
        .filter_map(|center| {
            let Center { ball, angle_rad, center_mm } = *center;
            angle_rad.map(|angle_rad| SphereReading { ball, angle_rad, center_mm })
        })
        .collect();
    let found = if readings.len() == centers && centers > 0 {
        fit_rotation(&readings, &expected)
    } else if readings.is_empty() {
        let mut balls: Vec<usize> = probed.centers.iter().map(|center| center.ball).collect();
        balls.sort_unstable();
        balls.dedup();
        if balls.len() > 1 {
            return Err(vec![SphereRunFault::BallsWithoutAngles { entry, balls: balls.len() }]);
        }
        let centers_mm: Vec<Vec3> = probed.centers.iter().map(|center| center.center_mm).collect();
        fit_circle(&centers_mm, &expected)
    } else {
        return Err(vec![SphereRunFault::SomeAngles { entry, with: readings.len(), centers }]);
    };
    found.map_err(|faults| faults.into_iter().map(|fault| SphereRunFault::Fit { entry, fault }).collect())
}

/// Step of the difference quotients \[mm, rad\]: errors are smooth functions of the lines, and this step keeps ten
/// digits.
const STEP: f64 = 1e-4;
/// The run does not determine a component that moves by less than this with every line's coordinates
/// \[mm or rad per mm or rad\]; arms of coordinates are up to metres.
const STILL: f64 = 1e-7;

/// Derivatives of the twelve components by the four coordinates of each probed line: two tilts, two offsets.
fn slopes(
    machine: &Machine,
    run: &[AxisCenters],
    fits: &[AxisFit],
    lines: [Option<Screw>; 2],
) -> DMatrix<f64> {
    let mut slopes = DMatrix::zeros(12, 4 * fits.len());
    for (entry, (probed, found)) in run.iter().zip(fits).enumerate() {
        for coordinate in 0..4 {
            let moved = |by: f64| {
                let along = found.across[coordinate % 2] * by;
                let mut line = found.line;
                if coordinate < 2 {
                    line.direction = rotation_from_vector(along) * line.direction;
                } else {
                    line.point_mm += along;
                }
                let mut lines = lines;
                lines[probed.axis] = Some(line);
                location_errors(machine, lines).ok()
            };
            let (Some(after), Some(before)) = (moved(STEP), moved(-STEP)) else { continue };
            for (row, parameter) in ErrorParameter::every().enumerate() {
                slopes[(row, 4 * entry + coordinate)] =
                    (parameter.value(&after) - parameter.value(&before)) / (2.0 * STEP);
            }
        }
    }
    slopes
}

/// The covariance. Lines of different axes are measured separately, so their covariances are independent blocks.
fn covariance(
    parameters: &[ErrorParameter],
    slopes: &DMatrix<f64>,
    fits: &[AxisFit],
) -> Option<DMatrix<f64>> {
    let rows: Vec<usize> =
        parameters.iter().map(|parameter| parameter.axis * 6 + parameter.component).collect();
    let mut covariance = DMatrix::zeros(rows.len(), rows.len());
    for (entry, found) in fits.iter().enumerate() {
        let of_line = found.covariance?;
        for (left, row) in rows.iter().enumerate() {
            for (right, column) in rows.iter().enumerate() {
                for i in 0..4 {
                    for j in 0..4 {
                        covariance[(left, right)] += slopes[(*row, 4 * entry + i)]
                            * of_line[(i, j)]
                            * slopes[(*column, 4 * entry + j)];
                    }
                }
            }
        }
    }
    Some(covariance)
}
