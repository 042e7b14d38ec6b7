//! Axes from sphere centres whose truth is known, and the location errors that reproduce given lines.
#![expect(clippy::unwrap_used, reason = "a test may stop at what it did not expect")]

use nalgebra::{Rotation3, Unit, Vector4};
use trunnion::calibration::rotary_sphere::{
    AxisFit, ExpectedAxis, LocationFault, SphereFault, SphereReading, fit_circle, fit_rotation,
    location_errors,
};
use trunnion::geometry::{Screw, Vec3, angle_between};
use trunnion::kinematics::{Kinematics, Setup};
use trunnion::machine::{LocationError, Machine, MachineParts, PRESETS, Preset, Side};

/// Rounding of a fit of coordinates of some hundred [mm].
const ROUNDING_MM: f64 = 1e-10;
/// The same of a direction seen over a hundred millimetres [rad].
const ROUNDING_RAD: f64 = 1e-12;

/// A repeatable stream of numbers in [−1, 1).
fn stream(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 11) as f64) * 2.0_f64.powi(-52) - 1.0
    }
}

/// Normally distributed, of standard deviation 1: twelve uniform numbers.
fn normal(next: &mut impl FnMut() -> f64) -> f64 {
    (0..12).map(|_| next() * 0.5).sum()
}

fn vector(next: &mut impl FnMut() -> f64, size: f64) -> Vec3 {
    Vec3::from_fn(|_, _| next() * size)
}

fn noise(next: &mut impl FnMut() -> f64, sigma: f64) -> Vec3 {
    Vec3::from_fn(|_, _| normal(next) * sigma)
}

fn carried(line: &Screw, angle_rad: f64, p: Vec3) -> Vec3 {
    let turn = Rotation3::from_axis_angle(&Unit::new_normalize(line.direction), angle_rad);
    turn * (p - line.point_mm) + line.point_mm
}

/// A nominal line, and the real one near it: tilts [rad] and offsets [mm] known.
struct Truth {
    expected: ExpectedAxis,
    line: Screw,
    /// Both tilts, both offsets.
    values: [f64; 4],
}

fn truth(direction: Vec3, side: Side, next: &mut impl FnMut() -> f64) -> Truth {
    let expected = ExpectedAxis {
        line: Screw { direction: direction.normalize(), point_mm: vector(next, 200.0) },
        side,
    };
    let [a, b] = expected.across();
    assert!((a.cross(&b) - expected.line.direction).norm() < 1e-14);
    let values = [next() * 1e-3, next() * 1e-3, next() * 0.2, next() * 0.2];
    let tilt = Rotation3::new(a * values[0] + b * values[1]);
    let line = Screw {
        direction: tilt * expected.line.direction,
        point_mm: expected.line.point_mm + a * values[2] + b * values[3],
    };
    Truth { expected, line, values }
}

impl Truth {
    /// Balls at zero, off the axis by some 80 mm, and up to 150 mm along it.
    fn balls(&self, count: usize, next: &mut impl FnMut() -> f64) -> Vec<Vec3> {
        let [a, b] = self.expected.across();
        (0..count)
            .map(|_| {
                let angle = next() * std::f64::consts::PI;
                let radius = 80.0 + 40.0 * next();
                let across = a * (radius * angle.cos()) + b * (radius * angle.sin());
                self.line.point_mm + across + self.expected.line.direction * (150.0 * next())
            })
            .collect()
    }

    fn readings(
        &self,
        balls: &[Vec3],
        angles_rad: &[f64],
        mut off: impl FnMut() -> Vec3,
    ) -> Vec<SphereReading> {
        let sense = if self.expected.side == Side::Table { -1.0 } else { 1.0 };
        let reading = |ball: usize, at: Vec3, angle_rad: f64| {
            let center_mm = carried(&self.line, sense * angle_rad, at);
            SphereReading { ball, angle_rad, center_mm }
        };
        let mut readings = Vec::new();
        for (ball, at) in balls.iter().enumerate() {
            for angle in angles_rad {
                let mut next = reading(7 * ball + 2, *at, *angle);
                next.center_mm += off();
                readings.push(next);
            }
        }
        readings
    }

    fn found(&self, fit: &AxisFit) -> Vector4<f64> {
        let [a, b] = fit.tilt_rad;
        let [c, d] = fit.offset_mm;
        Vector4::new(a, b, c, d) - Vector4::from(self.values)
    }
}

fn sixteen(step: f64) -> Vec<f64> {
    (0..16).map(|k| f64::from(k) * step).collect()
}

const DIRECTIONS: [[f64; 3]; 6] =
    [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 1.0], [1.0, -2.0, 0.5]];

#[test]
fn without_noise_the_axis_is_found_to_the_last_digits() {
    let mut next = stream(1);
    for direction in DIRECTIONS {
        for side in [Side::Table, Side::Head] {
            let truth = truth(Vec3::from(direction), side, &mut next);
            let balls = truth.balls(3, &mut next);
            let readings = truth.readings(&balls, &sixteen(0.3), Vec3::zeros);
            let known = fit_rotation(&readings, &truth.expected).unwrap();
            let centers: Vec<Vec3> = readings[..16].iter().map(|r| r.center_mm).collect();
            let unknown = fit_circle(&centers, &truth.expected).unwrap();
            for fit in [&known, &unknown] {
                let off = truth.found(fit);
                assert!(off[0].abs() < ROUNDING_RAD && off[1].abs() < ROUNDING_RAD, "{direction:?} {off}");
                assert!(off[2].abs() < ROUNDING_MM && off[3].abs() < ROUNDING_MM, "{direction:?} {off}");
                assert!(angle_between(fit.line.direction, truth.line.direction) < ROUNDING_RAD);
                assert!(
                    (fit.line.point_mm - truth.line.point_mm).cross(&truth.line.direction).norm()
                        < ROUNDING_MM
                );
                let (axial, radial, tangential) = fit.rms_mm();
                assert!(
                    axial < ROUNDING_MM && radial < ROUNDING_MM && tangential.unwrap_or(0.0) < ROUNDING_MM
                );
                assert!(fit.outliers.is_empty());
            }
            assert_eq!(known.degrees_of_freedom, 3 * 48 - 9 - 4);
            assert_eq!((known.balls.len(), known.balls[2].ball), (3, 16));
            let radius = (balls[2] - truth.line.point_mm).cross(&truth.line.direction).norm();
            assert!((known.balls[2].radius_mm - radius).abs() < ROUNDING_MM);
        }
    }
}

/// How much the mean of squares of `draws` normalised errors may differ from what it should be: five standard
/// deviations of a chi-square with as many degrees.
fn band(draws: usize) -> f64 {
    5.0 * (2.0 / draws as f64).sqrt()
}

#[test]
fn the_errors_of_noisy_fits_scatter_as_their_uncertainties_say() {
    const DRAWS: usize = 600;
    /// Probing noise [mm].
    const SIGMA_MM: f64 = 0.003;
    let mut next = stream(2);
    let truth = truth(Vec3::z(), Side::Table, &mut next);
    let balls = truth.balls(2, &mut next);
    // two thirds of a turn: tilts and offsets correlate
    let angles = sixteen(0.28);
    let mut squares = [[0.0; 4]; 2];
    let mut together = 0.0;
    for _ in 0..DRAWS {
        let readings = truth.readings(&balls, &angles, || noise(&mut next, SIGMA_MM));
        let known = fit_rotation(&readings, &truth.expected).unwrap();
        let centers: Vec<Vec3> = readings[..16].iter().map(|r| r.center_mm).collect();
        let unknown = fit_circle(&centers, &truth.expected).unwrap();
        for (sums, fit) in squares.iter_mut().zip([&known, &unknown]) {
            let off = truth.found(fit);
            for (k, uncertainty) in fit.standard_uncertainties().unwrap().iter().enumerate() {
                sums[k] += (off[k] / uncertainty).powi(2) / DRAWS as f64;
            }
        }
        let off = truth.found(&known);
        together += off.dot(&(known.covariance.unwrap().try_inverse().unwrap() * off)) / DRAWS as f64;
    }
    // squares of Student's t of ν degrees have the mean ν/(ν − 2)
    for (sums, freedom) in squares.iter().zip([86.0, 13.0]) {
        let mean: f64 = freedom / (freedom - 2.0);
        for (k, sum) in sums.iter().enumerate() {
            assert!((sum / mean - 1.0).abs() < 1.3 * band(DRAWS), "parameter {k}: {sum} of {mean}");
        }
    }
    assert!((together / (4.0 * 86.0 / 84.0) - 1.0).abs() < band(4 * DRAWS), "{together}");
}

#[test]
fn readings_that_do_not_agree_are_listed_and_not_hidden() {
    let mut next = stream(3);
    let truth = truth(Vec3::x(), Side::Table, &mut next);
    let balls = truth.balls(2, &mut next);
    let mut readings = truth.readings(&balls, &sixteen(0.39), || noise(&mut next, 0.002));
    let clean = fit_rotation(&readings, &truth.expected).unwrap();
    assert!(clean.outliers.is_empty(), "{:?}", clean.outliers);
    readings[5].center_mm.y += 0.05;
    readings[20].center_mm.x -= 0.03;
    let known = fit_rotation(&readings, &truth.expected).unwrap();
    let listed: Vec<usize> = known.outliers.iter().map(|outlier| outlier.reading).collect();
    assert_eq!(listed, [5, 20]);
    assert!((known.outliers[0].distance_mm - 0.05).abs() < 0.01 && known.outliers[0].probability < 1e-6);
    assert_eq!(known.residuals.len(), 32);
    // they took part: the axis is not the one without them
    assert!((known.offset_mm[0] - clean.offset_mm[0]).abs() > 1e-4);
    let centers: Vec<Vec3> = readings[..16].iter().map(|r| r.center_mm).collect();
    let unknown = fit_circle(&centers, &truth.expected).unwrap();
    assert_eq!(unknown.outliers.first().map(|outlier| outlier.reading), Some(5));
}

#[test]
fn readings_that_show_no_axis_are_refused_by_facts() {
    let mut next = stream(4);
    let truth = truth(Vec3::z(), Side::Table, &mut next);
    let expected = truth.expected;
    let at = truth.balls(1, &mut next);
    let centers = |angles: &[f64]| -> Vec<Vec3> {
        truth.readings(&at, angles, Vec3::zeros).iter().map(|r| r.center_mm).collect()
    };
    let refused = |centers: &[Vec3]| fit_circle(centers, &expected).unwrap_err();
    assert!(matches!(refused(&[])[..], [SphereFault::ReadingCount { count: 0, min: 3, .. }]));
    assert!(matches!(refused(&centers(&[0.0, 1.0]))[..], [SphereFault::ReadingCount { count: 2, .. }]));
    assert!(matches!(refused(&centers(&[1.0; 6]))[..], [SphereFault::SamePoint { .. }]));
    assert!(matches!(refused(&centers(&[0.0, 1.0, 0.0, 1.0]))[..], [SphereFault::OnALine { .. }]));
    let line: Vec<Vec3> = (0..6).map(|k| Vec3::new(1.0, 2.0, 3.0) * f64::from(k)).collect();
    assert!(matches!(refused(&line)[..], [SphereFault::OnALine { .. }]));
    let mut bad = centers(&[0.0, 1.0, 2.0]);
    bad[1].y = f64::NAN;
    bad[2].x = 1e9;
    assert!(matches!(
        refused(&bad)[..],
        [
            SphereFault::Coordinate { reading: 1, component: 1, .. },
            SphereFault::Coordinate { reading: 2, component: 0, .. }
        ]
    ));
    let near: Vec<Vec3> = [0.0, 2.0, 4.0]
        .map(|angle| carried(&truth.line, angle, truth.line.point_mm + Vec3::x() * 0.5))
        .to_vec();
    assert!(
        matches!(refused(&near)[..], [SphereFault::OnAxis { radius_mm, .. }] if (radius_mm - 0.5).abs() < 1e-3)
    );
    let other = ExpectedAxis { line: Screw { direction: Vec3::x(), ..expected.line }, ..expected };
    assert!(matches!(
        fit_circle(&centers(&[0.0, 1.0, 2.0]), &other).unwrap_err()[..],
        [SphereFault::DirectionFar { angle_rad, .. }] if angle_rad > 1.5
    ));

    let refused = |readings: &[SphereReading]| fit_rotation(readings, &expected).unwrap_err();
    let readings = |angles: &[f64]| truth.readings(&at, angles, Vec3::zeros);
    let turn = std::f64::consts::TAU;
    assert!(matches!(
        refused(&readings(&[0.0, 1.0, 0.0, 1.0 + turn]))[..],
        [SphereFault::TooFewAngles { count: 2, min: 3 }]
    ));
    assert!(matches!(
        refused(&readings(&[0.5 * turn, -0.5 * turn, 0.0]))[..],
        [SphereFault::TooFewAngles { count: 2, .. }]
    ));
    let mut still = readings(&[0.0, 0.0, 0.0]);
    still.iter_mut().zip([0.0, 1.0, 2.0]).for_each(|(reading, angle)| reading.angle_rad = angle);
    assert!(matches!(refused(&still)[..], [SphereFault::SamePoint { .. }]));
    let mut bad = readings(&[0.0, 1.0, 2.0]);
    bad[0].angle_rad = f64::INFINITY;
    bad[2].center_mm.z = f64::NAN;
    assert_eq!(refused(&bad).len(), 2);
    let mut reversed = readings(&[0.0, 1.0, 2.0, 2.5]);
    for reading in &mut reversed {
        reading.angle_rad *= -1.0;
    }
    assert!(matches!(
        refused(&reversed)[..],
        [SphereFault::SenseReversed { as_stated_mm, reversed_mm }] if reversed_mm < 1e-9 && as_stated_mm > 1.0 && as_stated_mm.is_finite()
    ));
    let on_axis = [truth.line.point_mm + truth.line.direction * 70.0 + Vec3::x() * 0.2];
    assert!(matches!(
        refused(&truth.readings(&on_axis, &[0.0, 1.0, 2.0, 3.0], Vec3::zeros))[..],
        [SphereFault::OnAxis { .. }]
    ));
}

#[test]
fn two_spheres_on_the_axis_show_it_together_and_each_alone_does_not() {
    let mut next = stream(5);
    let truth = truth(Vec3::y(), Side::Table, &mut next);
    let along = |mm: f64| truth.line.point_mm + truth.line.direction * mm;
    let both = [along(-120.0) + Vec3::x() * 0.3, along(90.0) + Vec3::z() * 0.2];
    let fit = fit_rotation(&truth.readings(&both, &sixteen(0.39), Vec3::zeros), &truth.expected).unwrap();
    let off = truth.found(&fit);
    assert!(off[0].abs() < ROUNDING_RAD && off[3].abs() < ROUNDING_MM, "{off}");
}

/// A preset with points and errors of its own.
fn measured(preset: &Preset, next: &mut impl FnMut() -> f64) -> MachineParts {
    let mut parts = preset.parts();
    for axis in &mut parts.rotary_axes {
        axis.travel_deg = None;
        axis.point_mm += vector(next, 200.0);
        axis.location_error =
            LocationError { translation_mm: vector(next, 0.2), rotation_rad: vector(next, 1e-3) };
    }
    parts
}

/// The machine with these errors.
fn with(parts: &MachineParts, errors: [LocationError; 2]) -> Machine {
    let mut parts = parts.clone();
    for (axis, error) in parts.rotary_axes.iter_mut().zip(errors) {
        axis.location_error = error;
    }
    Machine::new(parts).unwrap()
}

/// A line near a nominal one, told by another of its points.
fn near(line: &Screw, next: &mut impl FnMut() -> f64) -> Screw {
    let direction = Rotation3::new(vector(next, 2e-3)) * line.direction;
    Screw { direction, point_mm: line.point_mm + vector(next, 0.3) + direction * (300.0 * next()) }
}

fn assert_same_line(found: &Screw, line: &Screw, what: &str) {
    /// [mm]
    const LINE_MM: f64 = 1e-9;
    const LINE: f64 = 1e-12;
    assert!((found.direction - line.direction).norm() < LINE, "{what}");
    let off = (found.point_mm - line.point_mm).cross(&line.direction).norm();
    assert!(off < LINE_MM, "{what}: {off}");
}

#[test]
fn a_machine_with_the_errors_of_lines_has_these_lines() {
    let mut next = stream(6);
    for preset in &PRESETS {
        for _ in 0..30 {
            let parts = measured(preset, &mut next);
            let machine = Machine::new(parts.clone()).unwrap();
            let nominal = machine.screws(false);
            let lines = [near(&nominal[0], &mut next), near(&nominal[1], &mut next)];
            for measured in [[true, true], [true, false], [false, true], [false, false]] {
                let chosen = [0, 1].map(|k| measured[k].then_some(lines[k]));
                let errors = location_errors(&machine, chosen).unwrap();
                let found = with(&parts, errors).screws(true);
                let axes = machine.rotary_axes();
                for k in 0..2 {
                    if measured[k] {
                        assert_same_line(&found[k], &lines[k], preset.id);
                    } else {
                        assert_eq!(errors[k], axes[k].location_error, "{} keeps its error", preset.id);
                    }
                }
                let alone = axes[0].side != axes[1].side || measured[0] != measured[1];
                for k in (0..2).filter(|&k| alone && measured[k]) {
                    let own = axes[k].direction;
                    assert!(errors[k].translation_mm.dot(&own).abs() < 1e-15);
                    assert!(errors[k].rotation_rad.dot(&own).abs() < 1e-15);
                }
            }
        }
    }
}

#[test]
fn the_parameters_of_a_trunnion_are_those_of_p4() {
    let mut next = stream(7);
    let mut parts = measured(Preset::by_id("ac-table").unwrap(), &mut next);
    let p4 = [
        LocationError {
            translation_mm: Vec3::new(0.012, -0.021, 0.034),
            rotation_rad: Vec3::new(41e-6, -63e-6, 29e-6),
        },
        LocationError { translation_mm: Vec3::y() * 0.015, rotation_rad: Vec3::y() * 27e-6 },
    ];
    let machine = with(&parts, p4);
    parts.rotary_axes.iter_mut().for_each(|axis| axis.location_error = LocationError::default());
    let nominal = Machine::new(parts).unwrap();
    let errors = location_errors(&nominal, machine.screws(true).map(Some)).unwrap();
    for (found, told) in errors.iter().zip(p4) {
        assert!((found.translation_mm - told.translation_mm).norm() < 1e-11, "{found:?}");
        assert!((found.rotation_rad - told.rotation_rad).norm() < 1e-13, "{found:?}");
    }
    // of C nothing but e_y and e_b
    let c = errors[1];
    let others = [c.translation_mm.x, c.translation_mm.z, c.rotation_rad.x, c.rotation_rad.z];
    assert_eq!(others.map(f64::to_bits), [0; 4]);
}

#[test]
fn spheres_on_a_real_table_give_the_machine_back() {
    let mut next = stream(8);
    for id in ["ac-table", "bc-table", "ab-table", "nutating-bc-table"] {
        let parts = measured(Preset::by_id(id).unwrap(), &mut next);
        let real = Machine::new(parts.clone()).unwrap();
        let kinematics = Kinematics::new(&real, &Setup::default());
        let nominal = with(&parts, [LocationError::default(); 2]);
        let lines = [0, 1].map(|axis| {
            let balls = [vector(&mut next, 150.0), vector(&mut next, 150.0) + Vec3::new(90.0, 90.0, 90.0)];
            let mut readings = Vec::new();
            for (ball, tip) in balls.iter().enumerate() {
                for angle_rad in sixteen(0.39) {
                    // the words that bring the probe to the ball are where the ball stands in the machine
                    let mut rotary_rad = [0.0; 2];
                    rotary_rad[axis] = angle_rad;
                    readings.push(SphereReading {
                        ball,
                        angle_rad,
                        center_mm: kinematics.linear_mm(*tip, rotary_rad),
                    });
                }
            }
            let fit = fit_rotation(&readings, &ExpectedAxis::of(&nominal.rotary_axes()[axis])).unwrap();
            assert_same_line(&fit.line, &real.screws(true)[axis], id);
            Some(fit.line)
        });
        let errors = location_errors(&nominal, lines).unwrap();
        for (found, line) in with(&parts, errors).screws(true).iter().zip(real.screws(true)) {
            assert_same_line(found, &line, id);
        }
    }
}

#[test]
fn lines_that_are_no_errors_of_the_axes_are_refused() {
    let machine = Machine::new(Preset::by_id("ac-table").unwrap().parts()).unwrap();
    let [a, c] = machine.screws(false);
    let refused = |lines: [Option<Screw>; 2]| location_errors(&machine, lines).unwrap_err();
    let nan = Screw { point_mm: Vec3::new(f64::NAN, 0.0, 0.0), ..a };
    let short = Screw { direction: Vec3::zeros(), ..c };
    assert_eq!(
        refused([Some(nan), Some(short)]),
        [LocationFault::NoLine { axis: 0 }, LocationFault::NoLine { axis: 1 }]
    );
    let reversed = Screw { direction: -a.direction, ..a };
    assert!(matches!(refused([Some(reversed), None])[..], [LocationFault::DirectionFar { axis: 0, .. }]));
    let far = Screw { point_mm: Vec3::new(25.0, 0.0, 0.0), ..c };
    assert!(matches!(
        refused([None, Some(far)])[..],
        [LocationFault::TooLarge { axis: 1, component: 0, value, .. }] if (value - 25.0).abs() < 1e-12
    ));
}
