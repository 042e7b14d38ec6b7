//! Fit with known angles: rigid rotation of any number of spheres about one axis.

use nalgebra::{Matrix3x4, Matrix4, Vector4};

use super::axis_fit::{
    AxisFit, Ball, ExpectedAxis, MIN_RADIUS_MM, MIN_SPREAD_MM, Residual, SphereReading, check_centers,
    check_direction,
};
use super::outliers::{Deletion, MOST, worst};
use super::symmetric::eigen;
use super::{Outlier, SphereFault};
use crate::calibration::angles::different_angles;
use crate::geometry::{Mat3, Screw, Vec3, across, rotation_from_vector, shortest_turn_rad};
use crate::machine::{Machine, Side};

/// Number of different angles that an axis needs.
const MIN_ANGLES: usize = 3;
/// Angles nearer than this are the same angle \[rad\].
const SAME_ANGLE_RAD: f64 = 1e-6;
/// Two tilts, two offsets.
const UNKNOWNS: usize = 4;
/// A combination is not determined if its eigenvalue is below this share of the largest one of the scaled normal
/// matrix.
const RANK_SHARE: f64 = 1e-12;
/// Most steps of the least squares. A few are enough.
const STEPS: usize = 60;

/// The axis about which spheres turned by known angles, in mm and rad.
///
/// Least squares of all coordinates of the rigid model `c = p + R(d, ∓θ)(b − p)`, − for a table axis (a positive
/// word turns it physically by −θ), + for a head. The unknowns are two tilts of d, two offsets of p, and the
/// position b of every sphere at zero, which is eliminated exactly. Gauss–Newton from the nominal axis. Covariance
/// from all residuals to first order, with 3n − 3m − 4 degrees of freedom for n readings of m spheres.
///
/// # Errors
/// Every invalid number; otherwise why the readings show no axis: fewer than three readings or angles, a sphere
/// that did not move or is on the axis, unknowns not determined, a direction far from the nominal one, angles in
/// the opposite direction.
pub fn fit_rotation(
    readings: &[SphereReading],
    expected: &ExpectedAxis,
) -> Result<AxisFit, Vec<SphereFault>> {
    check(readings)?;
    let mut active: Vec<usize> = (0..readings.len()).collect();
    let stated = Rotation::of(readings, &active, expected, 1.0);
    let reversed = Rotation::of(readings, &active, expected, -1.0);
    if let Ok(reversed) = reversed {
        let rms_mm = |sum_mm2: f64| (sum_mm2 / readings.len() as f64).sqrt();
        // Without a fit as stated: the residual of the nominal axis.
        let as_stated_mm2 =
            stated.as_ref().map_or_else(|_| nominal_sum_mm2(readings, expected), |stated| stated.sum_mm2);
        if reversed.sum_mm2 < as_stated_mm2 {
            return Err(vec![SphereFault::SenseReversed {
                as_stated_mm: rms_mm(as_stated_mm2),
                reversed_mm: rms_mm(reversed.sum_mm2),
            }]);
        }
    }
    let whole = stated?;
    let mut outliers: Vec<Outlier> = Vec::new();
    let mut rotation = whole.clone();
    while let Some(outlier) = rotation.worst(readings, &active) {
        active.retain(|reading| *reading != outlier.reading);
        outliers.push(outlier);
        if outliers.len() == MOST {
            break;
        }
        match Rotation::of(readings, &active, expected, 1.0) {
            Ok(without) => rotation = without,
            Err(_) => break,
        }
    }
    Ok(whole.fit(readings, expected, outliers))
}

fn check(readings: &[SphereReading]) -> Result<(), Vec<SphereFault>> {
    let mut faults = check_centers(readings.iter().map(|reading| reading.center_mm));
    let max_rad = Machine::MAX_TRAVEL_DEG.to_radians();
    for (reading, SphereReading { angle_rad, .. }) in readings.iter().enumerate() {
        let angle_rad = *angle_rad;
        if !(-max_rad..=max_rad).contains(&angle_rad) {
            faults.push(SphereFault::Angle { reading, angle_rad, max_rad });
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let count = different_angles(readings.iter().map(|reading| reading.angle_rad), SAME_ANGLE_RAD);
    if count < MIN_ANGLES {
        return Err(vec![SphereFault::TooFewAngles { count, min: MIN_ANGLES }]);
    }
    let middle = readings.iter().fold(Vec3::zeros(), |sum, r| sum + r.center_mm) / readings.len() as f64;
    let spread_mm = readings.iter().map(|r| (r.center_mm - middle).norm()).fold(0.0, f64::max);
    if spread_mm < MIN_SPREAD_MM {
        return Err(vec![SphereFault::SamePoint { spread_mm, min_mm: MIN_SPREAD_MM }]);
    }
    Ok(())
}

/// A rotation of spheres about an axis, with the values for its uncertainty.
#[derive(Clone)]
struct Rotation {
    axis: Screw,
    across: [Vec3; 2],
    /// From kinematic to physical angle: +1 or −1.
    sense: f64,
    balls: Vec<Place>,
    /// Inverse of the normal matrix of tilts and offsets [1/mm², rad and mm].
    inverse: Matrix4<f64>,
    sum_mm2: f64,
}

/// The position of a sphere.
#[derive(Clone, Copy)]
struct Place {
    ball: usize,
    /// Position at zero, relative to the axis' point \[mm\].
    at_zero_mm: Vec3,
    readings: usize,
}

/// A reading prepared for the sums.
struct Turned {
    /// Index of its sphere.
    place: usize,
    center_mm: Vec3,
    /// Physical angle \[rad\].
    angle_rad: f64,
}

impl Rotation {
    fn of(
        readings: &[SphereReading],
        active: &[usize],
        expected: &ExpectedAxis,
        sense: f64,
    ) -> Result<Self, Vec<SphereFault>> {
        let sense = if expected.side == Side::Table { -sense } else { sense };
        let (turned, names) = turned(active.iter().filter_map(|k| readings.get(*k)), sense);
        let middle_mm =
            turned.iter().fold(Vec3::zeros(), |sum, t| sum + t.center_mm) / turned.len().max(1) as f64;
        // Tilts are expressed as displacements at this distance, so that the unknowns have similar sizes.
        let reach_mm = turned.iter().map(|t| (t.center_mm - middle_mm).norm()).fold(MIN_SPREAD_MM, f64::max);
        let across = expected.across();
        let mut axis = expected.line;
        let (mut balls, mut sum_mm2) = places(&axis, &turned, &names);
        for _ in 0..STEPS {
            let (normal, right) = normal_equations(&axis, &turned, &balls, &across, reach_mm);
            let Some(step) = normal.try_inverse().map(|inverse| inverse * right) else { break };
            let mut share = 1.0;
            // A step that does not help is halved until it vanishes.
            let better = loop {
                let tried = stepped(&axis, &(step * share), &across, reach_mm);
                let (balls, after) = places(&tried, &turned, &names);
                if after < sum_mm2 {
                    break Some((tried, balls, after));
                }
                share *= 0.5;
                if share < 1e-3 {
                    break None;
                }
            };
            let Some(next) = better else { break };
            (axis, balls, sum_mm2) = next;
        }
        let radius_mm = balls.iter().map(|ball| ball.radius_mm(&axis)).fold(0.0, f64::max);
        if names.len() == 1 && radius_mm < MIN_RADIUS_MM {
            return Err(vec![SphereFault::OnAxis { radius_mm, min_mm: MIN_RADIUS_MM }]);
        }
        let (normal, _) = normal_equations(&axis, &turned, &balls, &across, reach_mm);
        let rank = rank(&normal);
        let Some(scaled) = normal.try_inverse().filter(|_| rank == UNKNOWNS) else {
            return Err(vec![SphereFault::Undetermined { rank, unknowns: UNKNOWNS }]);
        };
        check_direction(axis.direction, expected)?;
        let scale = Matrix4::from_diagonal(&Vector4::new(1.0 / reach_mm, 1.0 / reach_mm, 1.0, 1.0));
        Ok(Self { axis, across, sense, balls, inverse: scale * scaled * scale, sum_mm2 })
    }

    /// Index of a sphere in the list, which is in the order of the names.
    fn index(&self, ball: usize) -> Option<usize> {
        self.balls.binary_search_by_key(&ball, |place| place.ball).ok()
    }

    fn place(&self, ball: usize) -> Option<&Place> {
        self.balls.get(self.index(ball)?)
    }

    /// Measured minus fitted, as a vector \[mm\] and by components.
    fn residual(&self, reading: &SphereReading) -> Option<(Vec3, Residual)> {
        let place = self.place(reading.ball)?;
        let model = self.axis.turn(self.sense * reading.angle_rad, place.at_zero_mm);
        let off = reading.center_mm - self.axis.point_mm - model;
        let d = self.axis.direction;
        let outward = across(model, d);
        let outward = if outward.norm() > 0.0 { outward.normalize() } else { Vec3::zeros() };
        let residual = Residual {
            axial_mm: d.dot(&off),
            radial_mm: outward.dot(&off),
            tangential_mm: Some(d.cross(&outward).dot(&off)),
        };
        Some((off, residual))
    }

    fn freedom(&self) -> usize {
        let readings: usize = self.balls.iter().map(|place| place.readings).sum();
        (3 * readings).saturating_sub(3 * self.balls.len() + UNKNOWNS)
    }

    /// The worst of the readings in the fit, if it is an outlier.
    fn worst(&self, readings: &[SphereReading], active: &[usize]) -> Option<Outlier> {
        let means = mean_slopes(
            active.iter().filter_map(|k| readings.get(*k)).filter_map(|reading| {
                let index = self.index(reading.ball)?;
                Some((index, self.sense * reading.angle_rad))
            }),
            &self.axis,
            &self.balls,
            &self.across,
        );
        let deletions = active.iter().filter_map(|&index| {
            let reading = readings.get(index)?;
            let (off, _) = self.residual(reading)?;
            let ball = self.index(reading.ball)?;
            let (place, mean) = self.balls.get(ball).zip(means.get(ball))?;
            let angle_rad = self.sense * reading.angle_rad;
            let slope =
                slopes(&self.axis, place, angle_rad, &self.across) - self.axis.rotation(angle_rad) * mean;
            let own = Mat3::identity() / place.readings as f64 + slope * self.inverse * slope.transpose();
            let distance = (Mat3::identity() - own).try_inverse()? * off;
            // A reading that the others do not determine cannot be judged.
            let judged = place.readings > 1 && distance.norm().is_finite();
            judged.then(|| Deletion {
                reading: index,
                drop_mm2: off.dot(&distance),
                distance_mm: distance.norm(),
            })
        });
        worst(deletions, self.sum_mm2, self.freedom(), 3, active.len())
    }

    fn fit(&self, readings: &[SphereReading], expected: &ExpectedAxis, outliers: Vec<Outlier>) -> AxisFit {
        let freedom = self.freedom();
        let Screw { direction, point_mm } = self.axis;
        AxisFit {
            line: self.axis,
            across: self.across,
            tilt_rad: self
                .across
                .map(|axis| axis.dot(&shortest_turn_rad(expected.line.direction, direction))),
            offset_mm: self.across.map(|axis| axis.dot(&(point_mm - expected.line.point_mm))),
            covariance: (freedom > 0).then(|| self.inverse * (self.sum_mm2 / freedom as f64)),
            degrees_of_freedom: freedom,
            balls: self
                .balls
                .iter()
                .map(|place| Ball {
                    ball: place.ball,
                    center_mm: point_mm + direction * direction.dot(&place.at_zero_mm),
                    radius_mm: place.radius_mm(&self.axis),
                })
                .collect(),
            residuals: readings.iter().filter_map(|reading| Some(self.residual(reading)?.1)).collect(),
            outliers,
        }
    }
}

impl Place {
    fn radius_mm(&self, axis: &Screw) -> f64 {
        across(self.at_zero_mm, axis.direction).norm()
    }
}

/// Readings with physical angles, and the names of their spheres in order.
fn turned<'a>(readings: impl Iterator<Item = &'a SphereReading>, sense: f64) -> (Vec<Turned>, Vec<usize>) {
    let chosen: Vec<&SphereReading> = readings.collect();
    let mut names: Vec<usize> = chosen.iter().map(|reading| reading.ball).collect();
    names.sort_unstable();
    names.dedup();
    let turned = chosen
        .iter()
        .map(|reading| Turned {
            place: names.binary_search(&reading.ball).unwrap_or(0),
            center_mm: reading.center_mm,
            angle_rad: sense * reading.angle_rad,
        })
        .collect();
    (turned, names)
}

/// The sum of squares of the nominal axis with the angles as stated \[mm²\].
fn nominal_sum_mm2(readings: &[SphereReading], expected: &ExpectedAxis) -> f64 {
    let sense = if expected.side == Side::Table { -1.0 } else { 1.0 };
    let (turned, names) = turned(readings.iter(), sense);
    places(&expected.line, &turned, &names).1
}

/// The position of every sphere at zero, from its readings for this axis, and the remaining sum of squares \[mm²\].
fn places(axis: &Screw, turned: &[Turned], names: &[usize]) -> (Vec<Place>, f64) {
    let mut balls: Vec<Place> =
        names.iter().map(|ball| Place { ball: *ball, at_zero_mm: Vec3::zeros(), readings: 0 }).collect();
    for t in turned {
        if let Some(place) = balls.get_mut(t.place) {
            place.at_zero_mm += axis.turn(-t.angle_rad, t.center_mm - axis.point_mm);
            place.readings += 1;
        }
    }
    for place in &mut balls {
        place.at_zero_mm /= place.readings.max(1) as f64;
    }
    let sum_mm2 =
        turned.iter().filter_map(|t| Some(off_mm(axis, t, balls.get(t.place)?).norm_squared())).sum();
    (balls, sum_mm2)
}

/// Measured minus fitted \[mm\].
fn off_mm(axis: &Screw, t: &Turned, place: &Place) -> Vec3 {
    t.center_mm - axis.point_mm - axis.turn(t.angle_rad, place.at_zero_mm)
}

/// Derivatives of the model's centre by tilts about, and offsets along, both directions, with the sphere at zero
/// held \[mm/rad, mm/mm\].
fn slopes(axis: &Screw, place: &Place, angle_rad: f64, across: &[Vec3; 2]) -> Matrix3x4<f64> {
    let turned = axis.turn(angle_rad, place.at_zero_mm);
    let tilt = |w: Vec3| w.cross(&turned) - axis.turn(angle_rad, w.cross(&place.at_zero_mm));
    let offset = |e: Vec3| e - axis.turn(angle_rad, e);
    let [first, second] = *across;
    Matrix3x4::from_columns(&[tilt(first), tilt(second), offset(first), offset(second)])
}

/// The mean slopes of every sphere, turned back to zero: the part that the sphere's own position takes up.
fn mean_slopes(
    readings: impl Iterator<Item = (usize, f64)>,
    axis: &Screw,
    balls: &[Place],
    across: &[Vec3; 2],
) -> Vec<Matrix3x4<f64>> {
    let mut means = vec![Matrix3x4::zeros(); balls.len()];
    for (index, angle_rad) in readings {
        if let Some((mean, place)) = means.get_mut(index).zip(balls.get(index)) {
            let back = axis.rotation(-angle_rad);
            *mean += back * slopes(axis, place, angle_rad, across) / place.readings.max(1) as f64;
        }
    }
    means
}

/// Normal matrix and right side of the least squares, with tilts as displacements at `reach_mm` and spheres
/// eliminated.
fn normal_equations(
    axis: &Screw,
    turned: &[Turned],
    balls: &[Place],
    across: &[Vec3; 2],
    reach_mm: f64,
) -> (Matrix4<f64>, Vector4<f64>) {
    let scale = Matrix4::from_diagonal(&Vector4::new(1.0 / reach_mm, 1.0 / reach_mm, 1.0, 1.0));
    let means = mean_slopes(turned.iter().map(|t| (t.place, t.angle_rad)), axis, balls, across);
    let (mut normal, mut right) = (Matrix4::zeros(), Vector4::zeros());
    for t in turned {
        if let Some((place, mean)) = balls.get(t.place).zip(means.get(t.place)) {
            let own = slopes(axis, place, t.angle_rad, across) - axis.rotation(t.angle_rad) * mean;
            let own = own * scale;
            normal += own.transpose() * own;
            right += own.transpose() * off_mm(axis, t, place);
        }
    }
    (normal, right)
}

fn stepped(axis: &Screw, step: &Vector4<f64>, across: &[Vec3; 2], reach_mm: f64) -> Screw {
    let [first, second] = *across;
    let turn = rotation_from_vector((first * step[0] + second * step[1]) / reach_mm);
    Screw {
        direction: (turn * axis.direction).normalize(),
        point_mm: axis.point_mm + first * step[2] + second * step[3],
    }
}

/// Number of combinations of the unknowns that the readings determine.
fn rank(normal: &Matrix4<f64>) -> usize {
    let sizes: [f64; 4] = std::array::from_fn(|k| normal[(k, k)].max(0.0).sqrt().max(f64::MIN_POSITIVE));
    let scaled = Matrix4::from_fn(|i, j| normal[(i, j)] / sizes[i] / sizes[j]);
    let (values, _) = eigen(&scaled);
    values.iter().filter(|value| **value > RANK_SHARE * values[UNKNOWNS - 1]).count()
}
