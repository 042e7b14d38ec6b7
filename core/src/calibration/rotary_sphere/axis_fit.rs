//! Input and result of the fit of an axis.

use nalgebra::Matrix4;

use super::{Outlier, SphereFault};
use crate::geometry::{Screw, Vec3, across, angle_between};
use crate::machine::{Machine, RotaryAxis, Side};

/// A sphere's centre, probed with the axis at a known angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereReading {
    /// The sphere; any number that names it.
    pub ball: usize,
    /// Kinematic angle θ \[rad\]: the word with the control's counting direction removed.
    pub angle_rad: f64,
    /// Centre \[mm\] in the frame of the expected line: M for a table axis, with the linear axes as at zero pose.
    pub center_mm: Vec3,
}

/// The expected axis: its nominal line, and its side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedAxis {
    /// Nominal direction, and the reference point for the reported offsets \[mm\].
    pub line: Screw,
    /// A table axis turns its spheres by −θ, a head axis by +θ.
    pub side: Side,
}

impl ExpectedAxis {
    /// The axis in the profile.
    #[must_use]
    pub fn of(axis: &RotaryAxis) -> Self {
        Self { line: axis.nominal_screw(), side: axis.side }
    }

    /// Two unit vectors across the nominal direction that form a right-handed frame with it: Y Z for X, Z X for Y,
    /// X Y for Z.
    #[must_use]
    pub fn across(&self) -> [Vec3; 2] {
        across_pair(self.line.direction)
    }
}

/// The difference of one reading from the fitted circle or rotation, measured minus fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Residual {
    /// Along the axis, out of the plane \[mm\].
    pub axial_mm: f64,
    /// Away from the axis \[mm\].
    pub radial_mm: f64,
    /// Along the circle, right-handed about the axis \[mm\]; `None` if angles are unknown.
    pub tangential_mm: Option<f64>,
}

/// The circle of one sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// The sphere.
    pub ball: usize,
    /// Centre of its circle, on the axis \[mm\].
    pub center_mm: Vec3,
    /// Radius \[mm\].
    pub radius_mm: f64,
}

/// An axis found from sphere centres.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisFit {
    /// The line, in the sense of the nominal direction. Its point is in the plane through the reference point
    /// across the nominal direction.
    pub line: Screw,
    /// Directions of the reported tilts and offsets.
    pub across: [Vec3; 2],
    /// Rotation vector from the nominal direction to the measured one, about both directions \[rad\].
    pub tilt_rad: [f64; 2],
    /// From the reference point to the line's point, along both directions \[mm\].
    pub offset_mm: [f64; 2],
    /// Covariance of both tilts and both offsets [rad, mm], Type A from the residuals, to first order. `None` if
    /// there are no more readings than unknowns.
    pub covariance: Option<Matrix4<f64>>,
    /// Readings beyond the unknowns. With unknown angles those of plane and circle each, otherwise of all
    /// coordinates.
    pub degrees_of_freedom: usize,
    /// The circles of all spheres.
    pub balls: Vec<Ball>,
    /// The residual of every reading, in order.
    pub residuals: Vec<Residual>,
    /// Readings that do not agree with the others, the worst first, at most 20. They were part of the fit.
    pub outliers: Vec<Outlier>,
}

impl AxisFit {
    /// Standard uncertainties of both tilts \[rad\] and both offsets \[mm\], Type A.
    #[must_use]
    pub fn standard_uncertainties(&self) -> Option<[f64; 4]> {
        self.covariance.map(|covariance| std::array::from_fn(|k| covariance[(k, k)].max(0.0).sqrt()))
    }

    /// Root mean squares of the residuals: axial, radial and, if angles are known, tangential \[mm\].
    #[must_use]
    pub fn rms_mm(&self) -> (f64, f64, Option<f64>) {
        let count = self.residuals.len().max(1) as f64;
        let rms = |of: &dyn Fn(&Residual) -> f64| {
            (self.residuals.iter().map(|r| of(r) * of(r)).sum::<f64>() / count).sqrt()
        };
        let known = self.residuals.iter().any(|r| r.tangential_mm.is_some());
        (rms(&|r| r.axial_mm), rms(&|r| r.radial_mm), known.then(|| rms(&|r| r.tangential_mm.unwrap_or(0.0))))
    }
}

/// Fewest and most readings.
pub(super) const READINGS: [usize; 2] = [3, 10_000];
/// A sphere that moves by less than this did not move \[mm\].
pub(super) const MIN_SPREAD_MM: f64 = 0.01;
/// A sphere nearer to the axis than this does not show its direction \[mm\].
pub(super) const MIN_RADIUS_MM: f64 = 1.0;
/// A line farther from the nominal one than this is another axis \[rad\]: 10°.
const MAX_TILT_RAD: f64 = 0.174_532_925_199_432_95;

/// Faults of the numbers themselves.
pub(super) fn check_centers(centers_mm: impl ExactSizeIterator<Item = Vec3>) -> Vec<SphereFault> {
    let mut faults = Vec::new();
    let [min, max] = READINGS;
    let count = centers_mm.len();
    if !(min..=max).contains(&count) {
        faults.push(SphereFault::ReadingCount { count, min, max });
    }
    let max_mm = Machine::MAX_LENGTH_MM;
    for (reading, center_mm) in centers_mm.take(max).enumerate() {
        for component in 0..3 {
            let value_mm = center_mm[component];
            // NaN is not in the range either.
            if !(-max_mm..=max_mm).contains(&value_mm) {
                faults.push(SphereFault::Coordinate { reading, component, value_mm, max_mm });
            }
        }
    }
    faults
}

/// Refuses an axis that is not the expected one.
pub(super) fn check_direction(direction: Vec3, expected: &ExpectedAxis) -> Result<(), Vec<SphereFault>> {
    let angle_rad = angle_between(direction, expected.line.direction);
    let max_rad = MAX_TILT_RAD;
    if angle_rad <= max_rad { Ok(()) } else { Err(vec![SphereFault::DirectionFar { angle_rad, max_rad }]) }
}

/// Two unit vectors across a unit vector, right-handed with it.
pub(super) fn across_pair(direction: Vec3) -> [Vec3; 2] {
    let largest = direction.iamax();
    let mut next = Vec3::zeros();
    next[(largest + 1) % 3] = 1.0;
    let first = across(next, direction).normalize();
    [first, direction.cross(&first)]
}
