//! Fit with unknown angles: a plane through the centres, and a circle in the plane.

use nalgebra::{Matrix2, Matrix3, Matrix4, Vector3};

use super::axis_fit::{
    AxisFit, Ball, ExpectedAxis, MIN_RADIUS_MM, MIN_SPREAD_MM, READINGS, Residual, across_pair,
    check_centers, check_direction,
};
use super::outliers::{Deletion, MOST, worst};
use super::symmetric::eigen;
use super::{Outlier, SphereFault};
use crate::geometry::{Mat3, Screw, Vec3, shortest_turn_rad};
use crate::machine::Machine;

/// The centres lie on a line if their spread across it is below this share of the spread along it: an arc of half a
/// degree.
const MIN_WIDTH: f64 = 1e-3;
/// The spread in the plane has to be larger than that out of it by this factor.
const MIN_FLATNESS: f64 = 3.0;
/// Most steps of the circle's least squares. A few are enough.
const STEPS: usize = 100;

/// The axis about which one sphere turned, from its centres at unrecorded angles, in mm.
///
/// Plane by least squares of the distances from it (its normal is the eigenvector of the smallest spread), then a
/// circle in the plane by least squares of the radial distances (Gauss–Newton from the linear fit). The sense is
/// that of the nominal direction. Covariances to first order: normal from the axial scatter, centre from the radial
/// scatter, each with n − 3 degrees of freedom.
///
/// # Errors
/// Every invalid number; otherwise why the centres show no axis: too few, one point, on a line, on the axis, far
/// from the nominal direction.
pub fn fit_circle(centers_mm: &[Vec3], expected: &ExpectedAxis) -> Result<AxisFit, Vec<SphereFault>> {
    let faults = check_centers(centers_mm.iter().copied());
    if !faults.is_empty() {
        return Err(faults);
    }
    let mut active: Vec<usize> = (0..centers_mm.len()).collect();
    let whole = Circle::of(centers_mm, &active, expected)?;
    let mut outliers: Vec<Outlier> = Vec::new();
    let mut circle = whole.clone();
    while let Some(outlier) = circle.worst(centers_mm, &active) {
        active.retain(|reading| *reading != outlier.reading);
        outliers.push(outlier);
        if outliers.len() == MOST {
            break;
        }
        match Circle::of(centers_mm, &active, expected) {
            Ok(without) => circle = without,
            Err(_) => break,
        }
    }
    Ok(whole.fit(centers_mm, expected, outliers))
}

/// A circle in space, with the values for its uncertainty.
#[derive(Clone)]
struct Circle {
    normal: Vec3,
    /// Directions in the plane.
    plane: [Vec3; 2],
    middle_mm: Vec3,
    center_mm: Vec3,
    radius_mm: f64,
    /// Inverse normal matrices: tilts of the normal towards both directions; centre along both, and radius.
    tilt_inverse: Matrix2<f64>,
    place_inverse: Matrix3<f64>,
    axial_sum_mm2: f64,
    radial_sum_mm2: f64,
}

impl Circle {
    fn of(centers_mm: &[Vec3], active: &[usize], expected: &ExpectedAxis) -> Result<Self, Vec<SphereFault>> {
        let points: Vec<Vec3> = active.iter().filter_map(|k| centers_mm.get(*k)).copied().collect();
        let [min, max] = READINGS;
        let count = points.len() as f64;
        if points.len() < min {
            return Err(vec![SphereFault::ReadingCount { count: points.len(), min, max }]);
        }
        let middle_mm = points.iter().fold(Vec3::zeros(), |sum, p| sum + p) / count;
        let spread_mm = points.iter().map(|p| (p - middle_mm).norm()).fold(0.0, f64::max);
        if spread_mm < MIN_SPREAD_MM {
            return Err(vec![SphereFault::SamePoint { spread_mm, min_mm: MIN_SPREAD_MM }]);
        }
        let scatter =
            points.iter().fold(Mat3::zeros(), |sum, p| sum + (p - middle_mm) * (p - middle_mm).transpose());
        let (values, vectors) = eigen(&scatter);
        let [scatter_mm, across_mm, along_mm] = values.map(|value| (value.max(0.0) / count).sqrt());
        if across_mm < MIN_WIDTH * along_mm || across_mm < MIN_FLATNESS * scatter_mm {
            return Err(vec![SphereFault::OnALine { across_mm, along_mm, scatter_mm }]);
        }
        let normal: Vec3 = vectors.column(0).into();
        let normal = if normal.dot(&expected.line.direction) < 0.0 { -normal } else { normal }.normalize();
        check_direction(normal, expected)?;
        let plane = across_pair(normal);
        let flat: Vec<[f64; 2]> =
            points.iter().map(|p| plane.map(|axis| axis.dot(&(p - middle_mm)))).collect();
        let no_circle = || vec![SphereFault::OnALine { across_mm, along_mm, scatter_mm }];
        let ([u, v], radius_mm, place_inverse) = flat_circle(&flat).ok_or_else(no_circle)?;
        if radius_mm < MIN_RADIUS_MM {
            return Err(vec![SphereFault::OnAxis { radius_mm, min_mm: MIN_RADIUS_MM }]);
        }
        let tilt =
            flat.iter().fold(Matrix2::zeros(), |sum, [u, v]| sum + Matrix2::new(u * u, u * v, u * v, v * v));
        let radial = |[a, b]: &[f64; 2]| (a - u) * (a - u) + (b - v) * (b - v);
        Ok(Self {
            normal,
            plane,
            middle_mm,
            center_mm: middle_mm + plane[0] * u + plane[1] * v,
            radius_mm,
            tilt_inverse: tilt.try_inverse().ok_or_else(no_circle)?,
            place_inverse,
            axial_sum_mm2: points.iter().map(|p| normal.dot(&(p - middle_mm)).powi(2)).sum(),
            radial_sum_mm2: flat.iter().map(|p| (radial(p).sqrt() - radius_mm).powi(2)).sum(),
        })
    }

    fn residual(&self, center_mm: Vec3) -> Residual {
        let [u, v] = self.plane.map(|axis| axis.dot(&(center_mm - self.center_mm)));
        Residual {
            axial_mm: self.normal.dot(&(center_mm - self.middle_mm)),
            radial_mm: (u * u + v * v).sqrt() - self.radius_mm,
            tangential_mm: None,
        }
    }

    /// The worst of the readings in the fit, if it is an outlier, axially or radially.
    fn worst(&self, centers_mm: &[Vec3], active: &[usize]) -> Option<Outlier> {
        let count = active.len();
        let freedom = count.checked_sub(3)?;
        let parts = || active.iter().filter_map(|&reading| Some((reading, *centers_mm.get(reading)?)));
        let axial = parts().map(|(reading, p)| {
            let flat = nalgebra::Vector2::from(self.plane.map(|axis| axis.dot(&(p - self.middle_mm))));
            let own = 1.0 / count as f64 + flat.dot(&(self.tilt_inverse * flat));
            deletion(reading, self.residual(p).axial_mm, own)
        });
        let radial = parts().map(|(reading, p)| {
            let [u, v] = self.plane.map(|axis| axis.dot(&(p - self.center_mm)));
            let row = circle_row(u, v);
            deletion(reading, self.residual(p).radial_mm, row.dot(&(self.place_inverse * row)))
        });
        // Two tests for each reading.
        let tried = 2 * count;
        let found = [
            worst(axial, self.axial_sum_mm2, freedom, 1, tried),
            worst(radial, self.radial_sum_mm2, freedom, 1, tried),
        ];
        found.into_iter().flatten().min_by(|a, b| a.probability.total_cmp(&b.probability))
    }

    fn fit(&self, centers_mm: &[Vec3], expected: &ExpectedAxis, outliers: Vec<Outlier>) -> AxisFit {
        let Screw { direction: nominal, point_mm: reference_mm } = expected.line;
        let across = expected.across();
        let along = (reference_mm - self.center_mm).dot(&nominal) / self.normal.dot(&nominal);
        let point_mm = self.center_mm + self.normal * along;
        let freedom = centers_mm.len() - 3;
        let covariance = (freedom > 0).then(|| {
            let tilt = self.tilt_inverse * (self.axial_sum_mm2 / freedom as f64);
            let circle = self.place_inverse * (self.radial_sum_mm2 / freedom as f64);
            let mut own = Matrix4::zeros();
            own.fixed_view_mut::<2, 2>(0, 0).copy_from(&tilt);
            own.fixed_view_mut::<2, 2>(2, 2).copy_from(&circle.fixed_view::<2, 2>(0, 0));
            // Derivatives of tilts and offsets at the reference point by the normal and the centre.
            let mut slopes = Matrix4::zeros();
            for k in 0..4 {
                let step = self.plane[k % 2];
                let (turn, shift) = if k < 2 { (step, step * along) } else { (Vec3::zeros(), step) };
                let shift = shift - self.normal * (shift.dot(&nominal) / self.normal.dot(&nominal));
                let turned = nominal.cross(&turn);
                let column = [
                    across[0].dot(&turned),
                    across[1].dot(&turned),
                    across[0].dot(&shift),
                    across[1].dot(&shift),
                ];
                slopes.set_column(k, &column.into());
            }
            slopes * own * slopes.transpose()
        });
        AxisFit {
            line: Screw { direction: self.normal, point_mm },
            across,
            tilt_rad: across.map(|axis| axis.dot(&shortest_turn_rad(nominal, self.normal))),
            offset_mm: across.map(|axis| axis.dot(&(point_mm - reference_mm))),
            covariance,
            degrees_of_freedom: freedom,
            balls: vec![Ball { ball: 0, center_mm: self.center_mm, radius_mm: self.radius_mm }],
            residuals: centers_mm.iter().map(|p| self.residual(*p)).collect(),
            outliers,
        }
    }
}

/// The effect of deleting a reading with this residual and leverage; none if the other readings do not determine
/// it.
fn deletion(reading: usize, residual_mm: f64, leverage: f64) -> Deletion {
    let free = 1.0 - leverage;
    if free < 1e-9 {
        return Deletion { reading, drop_mm2: 0.0, distance_mm: 0.0 };
    }
    Deletion { reading, drop_mm2: residual_mm * residual_mm / free, distance_mm: residual_mm.abs() / free }
}

/// Derivative of the radial distance of a point (u, v) from the centre, minus the radius, with opposite sign, by
/// centre and radius.
fn circle_row(u: f64, v: f64) -> Vector3<f64> {
    let distance = (u * u + v * v).sqrt().max(f64::MIN_POSITIVE);
    Vector3::new(u / distance, v / distance, 1.0)
}

/// Centre, radius and inverse normal matrix of the circle with the least radial distances; `None` if there is no
/// such circle.
fn flat_circle(points: &[[f64; 2]]) -> Option<([f64; 2], f64, Matrix3<f64>)> {
    // The linear fit of u² + v² = 2 a u + 2 b v + c gives the start.
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for [u, v] in points {
        let row = Vector3::new(2.0 * u, 2.0 * v, 1.0);
        normal += row * row.transpose();
        right += row * (u * u + v * v);
    }
    let start = normal.try_inverse()? * right;
    let (mut a, mut b) = (start.x, start.y);
    let mut radius = (start.z + a * a + b * b).max(0.0).sqrt();
    let sum = |a: f64, b: f64, radius: f64| -> f64 {
        points
            .iter()
            .map(|[u, v]| ((u - a) * (u - a) + (v - b) * (v - b)).sqrt() - radius)
            .map(|r| r * r)
            .sum()
    };
    let mut before = sum(a, b, radius);
    for _ in 0..STEPS {
        let (inverse, step) = circle_step(points, a, b, radius)?;
        // A step that does not help is halved until it vanishes.
        let mut share = 1.0;
        let better = loop {
            let after = sum(a + share * step.x, b + share * step.y, radius + share * step.z);
            if after < before {
                break Some(after);
            }
            share *= 0.5;
            if share < 1e-3 {
                break None;
            }
        };
        let Some(after) = better else {
            return (radius.is_finite() && radius <= Machine::MAX_LENGTH_MM).then_some((
                [a, b],
                radius,
                inverse,
            ));
        };
        (a, b, radius, before) = (a + share * step.x, b + share * step.y, radius + share * step.z, after);
    }
    let (inverse, _) = circle_step(points, a, b, radius)?;
    (radius.is_finite() && radius <= Machine::MAX_LENGTH_MM).then_some(([a, b], radius, inverse))
}

fn circle_step(points: &[[f64; 2]], a: f64, b: f64, radius: f64) -> Option<(Matrix3<f64>, Vector3<f64>)> {
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for [u, v] in points {
        let (u, v) = (u - a, v - b);
        let row = circle_row(u, v);
        normal += row * row.transpose();
        right += row * ((u * u + v * v).sqrt() - radius);
    }
    let inverse = normal.try_inverse()?;
    Some((inverse, inverse * right))
}
