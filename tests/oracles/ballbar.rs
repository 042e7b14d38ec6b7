//! Ball-bar identification against the values and closed forms of the shared notation §5 and against a second machine
//! made of chained bodies.

use std::f64::consts::PI;

use trunnion::calibration::{
    BallBarRun, BallBarTest, BarDirection, ErrorParameter, FurtherRun, Identified, Observed, Reading,
    RunWarning, SetupError, SpindleStep, Unknown, expected_readings, identify,
};
use trunnion::geometry::Vec3;
use trunnion::kinematics::{Kinematics, Setup};
use trunnion::machine::{LocationError, Machine, MachineParts, PRESETS, Preset, Squareness};

use crate::bar_machine::{AxisErrors, BarMachine, Seeded};

/// Values given to nine significant digits [µm].
const NINE_DIGITS_UM: f64 = 6e-8;
/// What a fit without noise must give back [µm, µrad].
const RECOVERED: f64 = 1e-6;
const A: usize = 0;
const C: usize = 1;

fn ac_table(c_from_a_mm: [f64; 3]) -> Machine {
    let mut parts = Preset::by_id("ac-table").expect("a preset").parts();
    parts.rotary_axes[A].point_mm = Vec3::zeros();
    parts.rotary_axes[C].point_mm = Vec3::from(c_from_a_mm);
    Machine::new(parts).expect("a machine")
}

/// 4 × what P4 does: C and A, radial and axial.
fn plan(c_ball: [f64; 3], a_ball: [f64; 3], step_deg: u16) -> Vec<BallBarTest> {
    let test = |axis, bar, ball: [f64; 3]| {
        let (from, to) = if axis == C { (0, 360) } else { (-90, 90) };
        let readings = (from..=to)
            .step_by(usize::from(step_deg))
            .map(|angle| Reading { angle_rad: f64::from(angle) * PI / 180.0, length_change_mm: 0.0 })
            .collect();
        BallBarTest {
            axis,
            bar,
            ball_mm: Vec3::from(ball),
            tool_length_mm: 0.0,
            reading_uncertainty: 1.0,
            observed: Observed::Readings(readings),
        }
    };
    vec![
        test(C, BarDirection::Radial, c_ball),
        test(C, BarDirection::Axial, c_ball),
        test(A, BarDirection::Radial, a_ball),
        test(A, BarDirection::Axial, a_ball),
    ]
}

fn run_of(tests: Vec<BallBarTest>, setup_error: SetupError) -> BallBarRun {
    BallBarRun {
        bar_length_mm: 100.0,
        offset_per_test: true,
        instrument_uncertainty_mm: None,
        setup_error,
        tests,
    }
}

fn errors_of(errors: &AxisErrors) -> [LocationError; 2] {
    errors.map(|[x, y, z, a, b, c]| LocationError {
        translation_mm: Vec3::new(x, y, z),
        rotation_rad: Vec3::new(a, b, c),
    })
}

/// P4's eight: `(δx δy δz, δyCA)` in µm, `(α βAY γ, βAC)` in µrad.
fn p4(shift_um: [f64; 4], turn_urad: [f64; 4]) -> AxisErrors {
    let [dx, dy, dz, dy_ca] = shift_um.map(|um| um * 1e-3);
    let [alpha, beta, gamma, beta_ac] = turn_urad.map(|urad| urad * 1e-6);
    [[dx, dy, dz, alpha, beta, gamma], [0.0, dy_ca, 0.0, 0.0, beta_ac, 0.0]]
}

/// Fills a run's readings by the machine of chained bodies.
fn measured(machine: &Machine, mut run: BallBarRun, errors: &AxisErrors, setup_mm: [f64; 2]) -> BallBarRun {
    for test in &mut run.tests {
        let bodies = BarMachine::new(machine, test.tool_length_mm);
        let axis = &machine.rotary_axes()[test.axis];
        let bar = test.bar.unit(axis.letter, axis.direction);
        if let Observed::Readings(readings) = &mut test.observed {
            for reading in readings {
                reading.length_change_mm = bodies.reading(
                    errors,
                    setup_mm,
                    run.bar_length_mm,
                    bar,
                    test.ball_mm,
                    test.axis,
                    reading.angle_rad,
                );
            }
        }
    }
    run
}

/// The value of each unknown in µm or µrad.
fn natural(value: f64, unknown: Unknown) -> f64 {
    match unknown {
        Unknown::Error(parameter) if parameter.is_angle() => value * 1e6,
        Unknown::Error(_) | Unknown::SetupError(_) => value * 1e3,
    }
}

fn worst_difference(found: &Identified, errors: &AxisErrors, setup_mm: [f64; 2]) -> f64 {
    let truth = errors_of(errors);
    let of_errors = ErrorParameter::every().map(|parameter| {
        natural(parameter.value(&found.errors) - parameter.value(&truth), Unknown::Error(parameter)).abs()
    });
    let of_setup = (0..2).map(|k| (found.setup_error_mm[k] - setup_mm[k]).abs() * 1e3);
    of_errors.chain(of_setup).fold(0.0, f64::max)
}

#[test]
fn readings_are_the_values_of_the_notation() {
    let machine = ac_table([2.0, 0.3, -50.0]);
    let errors = errors_of(&p4([12.0, -21.0, 34.0, 15.0], [41.0, -63.0, 29.0, 27.0]));
    let mut tests = plan([150.0, 20.0, 60.0], [30.0, 10.0, 160.0], 90);
    for test in &mut tests {
        if let Observed::Readings(readings) = &mut test.observed {
            // The start, and for A the smallest set that a run takes.
            for reading in readings.iter_mut() {
                reading.length_change_mm = 0.0;
            }
        }
    }
    let readings = expected_readings(&machine, &run_of(tests, SetupError::Unknown), &errors, [0.004, -0.006])
        .expect("a run");
    let expected_um: [(usize, usize, f64); 6] = [
        (0, 1, 8.632_224_53),
        (0, 2, 17.964_517_7),
        (0, 3, 9.333_007_96),
        (1, 1, 11.650_680_9),
        (2, 2, 50.090_200_1),
        (3, 2, -4.676_640_05),
    ];
    for (test, reading, expected) in expected_um {
        let value = readings[test][reading] * 1e3;
        assert!((value - expected).abs() < NINE_DIGITS_UM, "test {test}, reading {reading}: {value} µm");
    }
}

#[test]
fn readings_are_those_of_the_chained_bodies_on_every_machine() {
    /// Coordinates of 300 mm and their rounding [mm].
    const SAME_MM: f64 = 2e-12;
    let mut seeded = Seeded(7);
    for preset in PRESETS {
        let machine = Machine::new(preset.parts()).expect("a machine");
        let errors: AxisErrors = std::array::from_fn(|_| {
            std::array::from_fn(|k| seeded.uniform() * if k < 3 { 0.1 } else { 5e-4 })
        });
        let mut tests = Vec::new();
        for axis in 0..2 {
            for bar in BarDirection::ALL {
                let readings = (0..12)
                    .map(|k| Reading { angle_rad: f64::from(k) * 0.5 - 1.3, length_change_mm: 0.0 })
                    .collect();
                tests.push(BallBarTest {
                    axis,
                    bar,
                    ball_mm: Vec3::new(120.0, -40.0, 80.0),
                    tool_length_mm: 210.0,
                    reading_uncertainty: 1.0,
                    observed: Observed::Readings(readings),
                });
            }
        }
        let run = run_of(tests, SetupError::Unknown);
        let setup_mm = [0.02, -0.03];
        let ours = expected_readings(&machine, &run, &errors_of(&errors), setup_mm).expect("a run");
        let theirs = measured(&machine, run, &errors, setup_mm);
        for (test, values) in theirs.tests.iter().zip(&ours) {
            for (reading, value) in test.readings().iter().zip(values) {
                let off = (reading.length_change_mm - value).abs();
                assert!(off < SAME_MM, "{}: {off:e} mm", preset.id);
            }
        }
    }
}

#[test]
fn every_machine_gives_its_errors_back_without_noise() {
    let mut seeded = Seeded(11);
    for preset in PRESETS {
        let parts: MachineParts = preset.parts();
        let machine = Machine::new(parts).expect("a machine");
        // Only what places the lines can come back.
        let sought = trunnion::calibration::placing_parameters(&machine);
        let mut errors: AxisErrors = [[0.0; 6]; 2];
        for parameter in &sought {
            errors[parameter.axis][parameter.component] =
                seeded.uniform() * if parameter.is_angle() { 5e-4 } else { 0.1 };
        }
        let setup_mm = [0.015, -0.02];
        let mut tests = Vec::new();
        for axis in 0..2 {
            for bar in BarDirection::ALL {
                for (ball, tool_length_mm) in [([150.0, 20.0, 60.0], 180.0), ([30.0, 90.0, 160.0], 320.0)] {
                    let readings = (-9..=9)
                        .map(|k| Reading { angle_rad: f64::from(k) * PI / 18.0, length_change_mm: 0.0 })
                        .collect();
                    tests.push(BallBarTest {
                        axis,
                        bar,
                        ball_mm: Vec3::from(ball),
                        tool_length_mm,
                        reading_uncertainty: 1.0,
                        observed: Observed::Readings(readings),
                    });
                }
            }
        }
        let run = run_of(tests, SetupError::Known(setup_mm));
        let run = measured(&machine, run, &errors, setup_mm);
        let found = identify(&machine, &run).unwrap_or_else(|fault| panic!("{}: {fault:?}", preset.id));
        assert!(found.blind.is_empty(), "{}: {:?}", preset.id, found.blind);
        let off = worst_difference(&found, &errors, setup_mm);
        assert!(off < RECOVERED, "{}: off by {off:e} µm or µrad", preset.id);
        assert!(found.residual_rms_mm < 1e-11, "{}: {:e} mm", preset.id, found.residual_rms_mm);
    }
}

#[test]
fn the_spindle_step_finds_the_setup_error() {
    let machine = ac_table([2.0, 0.3, -50.0]);
    let errors = p4([100.0, -80.0, 90.0, 60.0], [500.0, -400.0, 300.0, 450.0]);
    let setup_mm: [f64; 2] = [0.05, -0.03];
    let readings = (0..4)
        .map(|quarter| {
            let angle_rad = f64::from(quarter) * PI / 2.0;
            let (sin, cos) = angle_rad.sin_cos();
            let x = 100.0 + (cos * setup_mm[0] - sin * setup_mm[1]) - setup_mm[0];
            let y = (sin * setup_mm[0] + cos * setup_mm[1]) - setup_mm[1];
            Reading { angle_rad, length_change_mm: x.hypot(y) - 100.0 }
        })
        .collect();
    let step = SetupError::Spindle(SpindleStep { bar: Vec3::x(), readings });
    let run = run_of(plan([150.0, 0.0, 60.0], [150.0, 0.0, 160.0], 10), step);
    let found = identify(&machine, &measured(&machine, run, &errors, setup_mm)).expect("a fit");
    assert_eq!((found.rank, found.counted), (10, 10));
    assert!(found.blind.is_empty(), "{:?}", found.blind);
    let off = worst_difference(&found, &errors, setup_mm);
    assert!(off < RECOVERED, "off by {off:e} µm or µrad");
}

#[test]
fn without_the_setup_error_two_of_ten_stay_hidden_and_are_named() {
    let machine = ac_table([2.0, 0.3, -50.0]);
    let errors = p4([12.0, -21.0, 34.0, 15.0], [41.0, -63.0, 29.0, 27.0]);
    let setup_mm = [0.004, -0.006];
    let run = run_of(plan([150.0, 20.0, 60.0], [30.0, 10.0, 160.0], 10), SetupError::Unknown);
    let found = identify(&machine, &measured(&machine, run, &errors, setup_mm)).expect("a fit");
    assert_eq!((found.rank, found.counted), (8, 10));
    // What is reported for δx and δy is the difference to the set-up error.
    assert!((found.errors[A].translation_mm.x - (0.012 - 0.004)).abs() < 1e-9);
    assert!((found.errors[A].translation_mm.y - (-0.021 + 0.006)).abs() < 1e-9);
    assert!((found.errors[C].translation_mm.y - 0.015).abs() < 1e-9);
    let mut hidden: Vec<Vec<Unknown>> =
        found.blind.iter().map(|blind| blind.parts.iter().map(|part| part.0).collect()).collect();
    hidden.sort();
    let translation = |component| Unknown::Error(ErrorParameter { axis: A, component });
    assert_eq!(hidden, [[translation(0), Unknown::SetupError(0)], [translation(1), Unknown::SetupError(1)]]);
    for blind in &found.blind {
        assert_eq!(blind.separated_by, Some(FurtherRun::SpindleStep));
        // Both move together, by the same amount.
        assert!((blind.parts[0].1 - blind.parts[1].1).abs() < 1e-9, "{blind:?}");
    }
    let names: Vec<_> = found
        .absolute
        .iter()
        .filter(|error| !error.identifiable)
        .map(|error| (error.axis, error.component))
        .collect();
    assert_eq!(names, [(A, 1), (C, 0), (C, 1)], "E_Y0A, E_X0C and E_Y0C carry the difference");
}

#[test]
fn absolute_errors_are_those_of_the_notation() {
    let machine = ac_table([2.0, 0.3, -50.0]);
    let errors = p4([12.0, -21.0, 34.0, 15.0], [41.0, -63.0, 29.0, 27.0]);
    let run = run_of(plan([150.0, 20.0, 60.0], [30.0, 10.0, 160.0], 10), SetupError::Known([0.0; 2]));
    let found = identify(&machine, &measured(&machine, run, &errors, [0.0; 2])).expect("a fit");
    // E_X0C = δx + βJz − γJy, E_Y0C = δy + δyCA + γJx − αJz, in µm; J = (2, 0.3, −50).
    let e_x0c = 12.0 + (-63.0 * -50.0 - 29.0 * 0.3) * 1e-3;
    let e_y0c = -21.0 + 15.0 + (29.0 * 2.0 - 41.0 * -50.0) * 1e-3;
    let expected = [
        (A, 1, -21.0),
        (A, 2, 34.0),
        (A, 4, -63.0),
        (A, 5, 29.0),
        (C, 0, e_x0c),
        (C, 1, e_y0c),
        (C, 3, 41.0),
        (C, 4, -63.0 + 27.0),
    ];
    assert_eq!(found.absolute.len(), expected.len());
    for (error, (axis, component, value)) in found.absolute.iter().zip(expected) {
        assert_eq!((error.axis, error.component), (axis, component));
        let per_unit = if component < 3 { 1e3 } else { 1e6 };
        assert!((error.value * per_unit - value).abs() < RECOVERED, "{error:?} is not {value}");
        assert!(error.identifiable);
    }
}

#[test]
fn uncertainties_of_the_good_plan_are_those_of_the_notation() {
    /// The notation gives two or three digits; the noise of one draw is known to 2 % with 1430 readings.
    const DIGITS: f64 = 0.006;
    let machine = ac_table([0.0; 3]);
    let mut run = run_of(plan([150.0, 0.0, 60.0], [150.0, 0.0, 160.0], 1), SetupError::Known([0.0; 2]));
    run.offset_per_test = false;
    // 360 readings a test: C from 0 to 359°, A from −90 to 90° in 360 steps; noise of exactly 1 µm rms.
    let mut seeded = Seeded(3);
    for test in &mut run.tests {
        let axis = test.axis;
        test.observed = Observed::Readings(
            (0..360)
                .map(|k| {
                    let angle = if axis == C { f64::from(k) } else { -90.0 + f64::from(k) * 180.0 / 359.0 };
                    let length_change_mm = seeded.normal() * 1e-3;
                    Reading { angle_rad: angle * PI / 180.0, length_change_mm }
                })
                .collect(),
        );
    }
    let found = identify(&machine, &run).expect("a fit");
    assert!((found.condition_number - 6.0).abs() < 0.05, "condition {}", found.condition_number);
    let covariance = found.covariance.as_ref().expect("many readings");
    let spread =
        found.residual_rms_mm * 1e3 * (run.readings() as f64 / found.degrees_of_freedom as f64).sqrt();
    // In the order A e_x e_y e_z e_a e_b e_c, C e_y e_b.
    let expected = [0.046, 0.102, 0.151, 0.50, 0.69, 0.47, 0.130, 0.75];
    for (index, (unknown, expected)) in found.unknowns.iter().zip(expected).enumerate() {
        let sigma = natural(covariance[(index, index)].sqrt(), *unknown) / spread;
        assert!((sigma - expected).abs() < DIGITS, "{unknown:?}: {sigma} is not {expected}");
    }
}

/// First-order closed forms of the notation §5 for J = (Jx, Jy, Jz), in mm and rad.
#[expect(clippy::too_many_arguments, reason = "the letters of the formulas")]
fn closed_form(
    c_radial: [f64; 2],
    c_axial: [f64; 2],
    a_radial: [f64; 2],
    a_axial: [f64; 2],
    j: [f64; 3],
    c_ball: [f64; 3],
    a_ball: [f64; 3],
    e: [f64; 2],
) -> [f64; 8] {
    let [x, y, z] = c_ball;
    let p: [f64; 3] = std::array::from_fn(|k| j[k] + a_ball[k]);
    let across = x * x + y * y;
    let alpha = -(x * c_axial[1] + y * c_axial[0]) / across;
    let sum = (x * c_axial[0] - y * c_axial[1]) / across;
    let arm = p[1] * p[1] + p[2] * p[2];
    let gamma = (p[2] * a_axial[0] + p[1] * a_axial[1]) / arm;
    let beta = (p[1] * a_axial[0] - p[2] * a_axial[1]) / arm;
    let dy = e[1] - a_radial[0] - p[0] * gamma;
    let dz = -a_radial[1] + p[0] * beta;
    let dx = e[0] - c_radial[0] - z * sum - j[2] * beta + j[1] * gamma;
    let dy_ca = e[1] - c_radial[1] - dy + (z + j[2]) * alpha - j[0] * gamma;
    [dx, dy, dz, alpha, beta, gamma, dy_ca, sum - beta]
}

fn eccentric(axis: usize, bar: BarDirection, ball: [f64; 3], pair_um: [f64; 2]) -> BallBarTest {
    BallBarTest {
        axis,
        bar,
        ball_mm: Vec3::from(ball),
        tool_length_mm: 0.0,
        reading_uncertainty: 1.0,
        observed: Observed::Eccentricity(pair_um.map(|um| um * 1e-3)),
    }
}

#[test]
fn eccentricities_alone_give_what_the_closed_form_gives() {
    /// A shift v turned away swings the bar aside by |(1 − R)v|², 2v²(1 − cos θ): over a bar of 100 mm a shift of 70 µm
    /// adds 0.05 µm to the first harmonic, 0.3 µrad over the 160 mm of the A ball; the closed form leaves it out
    /// [µm, µrad].
    const SECOND_ORDER: f64 = 0.5;
    let (j, c_ball, a_ball, e) =
        ([2.0, 0.3, -50.0], [150.0, 20.0, 60.0], [30.0, 10.0, 160.0], [0.004, -0.006]);
    let rows_um = [[6.7, 16.4], [-2.0, 2.6], [9.9, -69.1], [4.5, 14.0]];
    let tests = vec![
        eccentric(C, BarDirection::Radial, c_ball, rows_um[0]),
        eccentric(C, BarDirection::Axial, c_ball, rows_um[1]),
        eccentric(A, BarDirection::Radial, a_ball, rows_um[2]),
        eccentric(A, BarDirection::Axial, a_ball, rows_um[3]),
    ];
    let found = identify(&ac_table(j), &run_of(tests, SetupError::Known(e))).expect("a fit");
    let mm = rows_um.map(|row| row.map(|um| um * 1e-3));
    let expected = closed_form(mm[0], mm[1], mm[2], mm[3], j, c_ball, a_ball, e);
    for (unknown, expected) in found.unknowns.iter().zip(expected) {
        let Unknown::Error(parameter) = unknown else { panic!("{unknown:?}") };
        let off = natural(parameter.value(&found.errors) - expected, *unknown).abs();
        assert!(off < SECOND_ORDER, "{unknown:?} is off by {off}");
    }
    assert_eq!(found.degrees_of_freedom, 0);
    assert!(found.covariance.is_none(), "eight numbers leave nothing to judge eight unknowns by");
    // P4 Table 1 in kind: linear compensation leaves the axial rows, all of it leaves the set-up error.
    for (test, row_um) in rows_um.iter().enumerate() {
        let eccentricities = &found.eccentricities[test];
        let um = |pair: Option<[f64; 2]>| pair.expect("determined").map(|mm| mm * 1e3);
        let (before, linear, all) = (
            um(eccentricities.before_mm),
            um(eccentricities.after_linear_mm),
            um(eccentricities.after_all_mm),
        );
        for k in 0..2 {
            assert!((before[k] - row_um[k]).abs() < 1e-9, "test {test}: {before:?}");
        }
        let left = match test {
            0 => [4.0, -6.0],
            2 => [-6.0, 0.0],
            _ => [0.0, 0.0],
        };
        for k in 0..2 {
            assert!((all[k] - left[k]).abs() < SECOND_ORDER, "test {test}: {all:?}");
            if test % 2 == 1 {
                assert!((linear[k] - before[k]).abs() < SECOND_ORDER, "test {test}: {linear:?}");
            }
        }
    }
}

#[test]
fn eccentricities_of_readings_are_the_closed_form_of_the_errors() {
    /// Second order of errors of tens of µm and µrad over a bar of 100 mm [µm].
    const SECOND_ORDER_UM: f64 = 0.05;
    let (j, c_ball, a_ball) = ([2.0, 0.3, -50.0], [150.0, 20.0, 60.0], [30.0, 10.0, 160.0]);
    let machine = ac_table(j);
    let errors = p4([12.0, -21.0, 34.0, 15.0], [41.0, -63.0, 29.0, 27.0]);
    let setup_mm = [0.004, -0.006];
    let run = run_of(plan(c_ball, a_ball, 10), SetupError::Known(setup_mm));
    let found = identify(&machine, &measured(&machine, run, &errors, setup_mm)).expect("a fit");
    let pairs: Vec<[f64; 2]> =
        found.eccentricities.iter().map(|one| one.before_mm.expect("determined")).collect();
    let back = closed_form(pairs[0], pairs[1], pairs[2], pairs[3], j, c_ball, a_ball, setup_mm);
    let truth = [0.012, -0.021, 0.034, 41e-6, -63e-6, 29e-6, 0.015, 27e-6];
    for ((unknown, back), truth) in found.unknowns.iter().zip(back).zip(truth) {
        let off = natural(back - truth, *unknown).abs();
        assert!(off < 20.0 * SECOND_ORDER_UM, "{unknown:?}: {off}");
    }
    let all = found.eccentricities[0].after_all_mm.expect("determined");
    assert!((all[0] * 1e3 - 4.0).abs() < SECOND_ORDER_UM && (all[1] * 1e3 + 6.0).abs() < SECOND_ORDER_UM);
}

#[test]
fn a_ball_on_the_a_axis_leaves_its_tilts_open_and_a_run_that_shows_them_is_named() {
    let machine = ac_table([0.0, 0.0, -50.0]);
    let tests = plan([150.0, 0.0, 60.0], [30.0, 0.0, 50.0], 10);
    let run = run_of(tests, SetupError::Known([0.0; 2]));
    let errors = p4([5.0, 6.0, 7.0, 8.0], [0.0; 4]);
    let found = identify(&machine, &measured(&machine, run, &errors, [0.0; 2])).expect("a fit");
    assert!(found.rank < 8, "rank {}", found.rank);
    let open: Vec<_> =
        found.unknowns.iter().zip(&found.undetermined).filter(|(_, open)| **open).map(|(u, _)| *u).collect();
    assert!(open.contains(&Unknown::Error(ErrorParameter { axis: A, component: 5 })), "{open:?}");
    for blind in &found.blind {
        assert!(matches!(blind.separated_by, Some(FurtherRun::Test { .. })), "{blind:?}");
    }
}

#[test]
fn outliers_are_left_out_and_listed() {
    let machine = ac_table([2.0, 0.3, -50.0]);
    let errors = p4([12.0, -21.0, 34.0, 15.0], [41.0, -63.0, 29.0, 27.0]);
    let run = run_of(plan([150.0, 20.0, 60.0], [30.0, 10.0, 160.0], 5), SetupError::Known([0.0; 2]));
    let mut run = measured(&machine, run, &errors, [0.0; 2]);
    let mut seeded = Seeded(5);
    let mut spoilt = Vec::new();
    for (index, test) in run.tests.iter_mut().enumerate() {
        if let Observed::Readings(readings) = &mut test.observed {
            for (number, reading) in readings.iter_mut().enumerate() {
                reading.length_change_mm += seeded.normal() * 3e-4;
                // One in seven, all the same way: an average would follow them.
                if number % 7 == 3 {
                    reading.length_change_mm += 0.04;
                    spoilt.push((index, number));
                }
            }
        }
    }
    let found = identify(&machine, &run).expect("a fit");
    let listed: Vec<_> = found.outliers.iter().map(|outlier| (outlier.test, outlier.reading)).collect();
    assert_eq!(listed, spoilt);
    assert!(found.warnings.iter().any(|warning| matches!(warning, RunWarning::OutliersLeftOut { .. })));
    // Six standard uncertainties of 0.3 µm noise on some 170 readings [µm, µrad].
    let off = worst_difference(&found, &errors, [0.0; 2]);
    assert!(off < 3.0, "off by {off}");
}

#[test]
fn a_test_that_scatters_more_than_the_others_is_not_taken_for_outliers() {
    /// Three standard uncertainties, of which the scatter of all 220 readings understates those of a test that has all
    /// of it in 37 by √(220/37).
    const SIGMAS: f64 = 7.4;
    let machine = ac_table([2.0, 0.3, -50.0]);
    let errors = p4([12.0, -21.0, 34.0, 15.0], [41.0, -63.0, 29.0, 27.0]);
    let run = run_of(plan([150.0, 20.0, 60.0], [30.0, 10.0, 160.0], 5), SetupError::Known([0.0; 2]));
    let clean = measured(&machine, run, &errors, [0.0; 2]);
    let truth = errors_of(&errors);
    for noisy in 0..4 {
        let mut run = clean.clone();
        let mut seeded = Seeded(23);
        for (index, test) in run.tests.iter_mut().enumerate() {
            let sigma_mm = if index == noisy { 9e-3 } else { 3e-4 };
            if let Observed::Readings(readings) = &mut test.observed {
                for reading in readings.iter_mut() {
                    reading.length_change_mm += seeded.normal() * sigma_mm;
                }
            }
        }
        let found = identify(&machine, &run).expect("a fit");
        assert!(found.outliers.is_empty(), "test {noisy}: {} left out", found.outliers.len());
        let covariance = found.covariance.as_ref().expect("many readings");
        for (index, parameter) in trunnion::calibration::placing_parameters(&machine).iter().enumerate() {
            let off = (parameter.value(&found.errors) - parameter.value(&truth)).abs();
            let sigmas = off / covariance[(index, index)].sqrt();
            assert!(sigmas < SIGMAS, "test {noisy}: {parameter:?} is off by {sigmas} sigma");
        }
    }
}

#[test]
fn a_test_given_twice_counts_as_one_of_half_the_variance() {
    /// Rounding of a fit of some 150 readings [µm, µrad].
    const ROUNDING: f64 = 1e-6;
    let machine = ac_table([2.0, 0.3, -50.0]);
    let errors = p4([12.0, -21.0, 34.0, 15.0], [41.0, -63.0, 29.0, 27.0]);
    let run = run_of(plan([150.0, 20.0, 60.0], [30.0, 10.0, 160.0], 10), SetupError::Known([0.0; 2]));
    let mut once = measured(&machine, run, &errors, [0.0; 2]);
    // A second C radial test elsewhere, so that the two do not agree.
    let mut other = once.tests[0].clone();
    other.ball_mm.x = -90.0;
    once.tests.push(other);
    let mut seeded = Seeded(17);
    for test in &mut once.tests {
        if let Observed::Readings(readings) = &mut test.observed {
            for reading in readings.iter_mut() {
                reading.length_change_mm += seeded.normal() * 1e-3;
            }
        }
    }
    let unweighted = identify(&machine, &once).expect("a fit");
    let mut twice = once.clone();
    twice.tests.push(once.tests[0].clone());
    once.tests[0].reading_uncertainty = 0.5_f64.sqrt();
    let [weighted, twice] = [&once, &twice].map(|run| identify(&machine, run).expect("a fit"));
    let apart = |a: &Identified, b: &Identified| {
        ErrorParameter::every()
            .map(|parameter| {
                natural(parameter.value(&a.errors) - parameter.value(&b.errors), Unknown::Error(parameter))
                    .abs()
            })
            .fold(0.0, f64::max)
    };
    assert!(apart(&weighted, &twice) < ROUNDING, "{}", apart(&weighted, &twice));
    assert!(apart(&weighted, &unweighted) > 1e3 * ROUNDING, "the weight counts");
}

#[test]
fn what_makes_a_run_doubtful_is_asked_about() {
    let machine = Machine::new(Preset::by_id("ac-table").expect("a preset").parts()).expect("a machine");
    let mut run = run_of(plan([150.0, 0.0, 60.0], [150.0, 0.0, 160.0], 10), SetupError::Known([0.0; 2]));
    let mut change = |test: usize, change: &dyn Fn(&mut Vec<Reading>)| {
        if let Observed::Readings(readings) = &mut run.tests[test].observed {
            change(readings);
        }
    };
    change(0, &|readings| readings.truncate(8));
    change(1, &|readings| readings[4].angle_rad = readings[3].angle_rad);
    change(2, &|readings| readings.push(Reading { angle_rad: 3.0, length_change_mm: 0.0 }));
    // There and back.
    change(3, &|readings| readings.extend(readings.clone().into_iter().rev()));
    let found = identify(&machine, &run).expect("a fit");
    let asked: Vec<(&str, usize)> = found
        .warnings
        .iter()
        .filter_map(|warning| match warning {
            RunWarning::SingleSweep { test } => Some(("one way", *test)),
            RunWarning::SmallArc { test, arc_deg } if (arc_deg - 70.0).abs() < 1e-9 => Some(("arc", *test)),
            RunWarning::DuplicateAngle { test, reading: 4, .. } => Some(("twice", *test)),
            RunWarning::OutsideTravel { test, readings: 1 } => Some(("outside", *test)),
            RunWarning::SuspiciouslySmall { .. } => None,
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(
        asked,
        [("arc", 0), ("one way", 0), ("one way", 1), ("twice", 1), ("one way", 2), ("outside", 2)]
    );
}

#[test]
fn readings_that_are_wrong_the_same_way_do_not_hide_each_other() {
    /// Of 160 values one is beyond this by chance once in ten thousand times.
    const SIGMAS: f64 = 5.0;
    let machine = ac_table([2.0, 0.3, -50.0]);
    let errors = p4([12.0, -21.0, 34.0, 15.0], [41.0, -63.0, 29.0, 27.0]);
    let clean = run_of(plan([150.0, 20.0, 60.0], [30.0, 10.0, 160.0], 5), SetupError::Known([0.0; 2]));
    let clean = measured(&machine, clean, &errors, [0.0; 2]);
    for seed in 0..20 {
        let (mut run, mut seeded) = (clean.clone(), Seeded(seed));
        let mut spoilt = Vec::new();
        for (index, test) in run.tests.iter_mut().enumerate() {
            if let Observed::Readings(readings) = &mut test.observed {
                for (number, reading) in readings.iter_mut().enumerate() {
                    reading.length_change_mm += seeded.normal() * 1e-3;
                    // One in five at random places, fifty times the noise: in every third of such runs the fit follows
                    // them so far that none stands out.
                    if seeded.uniform() < -0.6 {
                        reading.length_change_mm += 0.05;
                        spoilt.push((index, number));
                    }
                }
            }
        }
        let found = identify(&machine, &run).expect("a fit");
        let listed: Vec<_> = found.outliers.iter().map(|outlier| (outlier.test, outlier.reading)).collect();
        assert_eq!(listed, spoilt, "seed {seed}");
        // What was left out is many where it is more than a fifth of a test.
        let many = |test: usize| {
            let left_out = spoilt.iter().filter(|(index, _)| *index == test).count();
            5 * left_out > run.tests[test].readings().len()
        };
        let asked = |test: usize| {
            let of_test = |warning: &RunWarning| matches!(warning, RunWarning::ManyOutliers { test: of, .. } if *of == test);
            found.warnings.iter().any(of_test)
        };
        assert!((0..4).all(|test| many(test) == asked(test)), "seed {seed}: {:?}", found.warnings);
        let covariance = found.covariance.as_ref().expect("many readings");
        let truth = errors_of(&errors);
        for (index, unknown) in found.unknowns.iter().enumerate() {
            let Unknown::Error(parameter) = unknown else { panic!("{unknown:?}") };
            let off = (parameter.value(&found.errors) - parameter.value(&truth)).abs();
            let sigmas = off / covariance[(index, index)].sqrt();
            assert!(sigmas < SIGMAS, "seed {seed}: {parameter:?} is off by {sigmas} sigma");
        }
    }
}

/// The ball is programmed from the C centre, so W stands there (`o = p_C`): what the bar reads follows from the forward
/// kinematics of the machine with its errors alone.
#[test]
fn squareness_counts_as_in_the_forward_kinematics() {
    const ERRORS: AxisErrors = [[0.03, -0.05, 0.02, 1e-4, -2e-4, 3e-4], [0.0, 0.04, 0.0, 0.0, 2e-4, 0.0]];
    let mut parts = Preset::by_id("ac-table").expect("a preset").parts();
    parts.rotary_axes[A].point_mm = Vec3::new(310.0, -250.0, -420.0);
    parts.rotary_axes[C].point_mm = Vec3::new(305.0, -270.0, -500.0);
    parts.squareness = Squareness { e_c0y_rad: 8e-5, e_b0z_rad: -6e-5, e_a0z_rad: 4e-5 };
    let nominal = Machine::new(parts.clone()).expect("a machine");
    for (axis, error) in parts.rotary_axes.iter_mut().zip(errors_of(&ERRORS)) {
        axis.location_error = error;
    }
    let real = Machine::new(parts).expect("a machine");
    let work_offset_mm = nominal.rotary_axes()[C].point_mm;
    let setup = |apply_errors| Setup { work_offset_mm, tool_length_mm: 0.0, apply_errors };
    let (control, truth) = (Kinematics::new(&nominal, &setup(false)), Kinematics::new(&real, &setup(true)));
    let mut run = run_of(plan([150.0, 20.0, 60.0], [30.0, 10.0, 160.0], 10), SetupError::Known([0.0; 2]));
    for test in &mut run.tests {
        let axis = &nominal.rotary_axes()[test.axis];
        let bar_mm = test.bar.unit(axis.letter, axis.direction) * run.bar_length_mm;
        // Where the ball stands over the table when RTCP holds it at its place.
        let held_mm = |angle_rad: f64| {
            let mut rotary_rad = [0.0; 2];
            rotary_rad[test.axis] = angle_rad;
            truth.tip_mm(control.linear_mm(test.ball_mm, rotary_rad), rotary_rad)
        };
        if let Observed::Readings(readings) = &mut test.observed {
            for reading in readings {
                let moved_mm = held_mm(reading.angle_rad) - held_mm(0.0);
                reading.length_change_mm = (moved_mm + bar_mm).norm() - run.bar_length_mm;
            }
        }
    }
    let found = identify(&nominal, &run).expect("a fit");
    let off = worst_difference(&found, &ERRORS, [0.0; 2]);
    assert!(off < RECOVERED, "off by {off}");
}

#[test]
fn an_instrument_uncertainty_does_not_average_away() {
    let machine = ac_table([0.0; 3]);
    let tests = plan([150.0, 0.0, 60.0], [150.0, 0.0, 160.0], 1);
    let mut run = run_of(tests, SetupError::Known([0.0; 2]));
    run.instrument_uncertainty_mm = Some(0.001);
    let found = identify(&machine, &run).expect("a fit");
    let covariance = found.covariance.as_ref().expect("an instrument");
    // δx is seen by one test, the C radial one: a systematic eccentricity of 1 µm there is 1 µm of δx, plus what the
    // tilts learnt from the axial tests (1 µm over 150 mm, times z = 60) bring in.
    let sigma_um = covariance[(0, 0)].sqrt() * 1e3;
    let expected_um = (1.0 + (60.0_f64 / 150.0).powi(2)).sqrt();
    assert!((sigma_um - expected_um).abs() < 0.01, "{sigma_um} µm is not {expected_um}");
}

#[test]
fn over_many_draws_the_truth_lies_where_the_covariance_says() {
    /// Shares of a normal distribution within one and within three standard deviations.
    const ONE_SIGMA: f64 = 0.6827;
    const THREE_SIGMA: f64 = 0.9973;
    // `TRUNNION_THOROUGH_TESTS=1` draws more.
    let draws: u32 = if std::env::var_os("TRUNNION_THOROUGH_TESTS").is_some() { 1000 } else { 300 };
    // Four standard deviations of the share that this many draws give.
    let near = |share: f64| 4.0 * (share * (1.0 - share) / f64::from(draws)).sqrt();
    let machine = ac_table([2.0, 0.3, -50.0]);
    let bodies = BarMachine::new(&machine, 0.0);
    let mut seeded = Seeded(2026);
    let mut within = vec![[0u32; 2]; 8];
    let mut squares = 0.0;
    for _ in 0..draws {
        let errors = p4(
            std::array::from_fn(|_| seeded.uniform() * 100.0),
            std::array::from_fn(|_| seeded.uniform() * 500.0),
        );
        let setup_mm = [seeded.uniform() * 0.02, seeded.uniform() * 0.02];
        let mut run = run_of(plan([150.0, 20.0, 60.0], [30.0, 10.0, 160.0], 10), SetupError::Known(setup_mm));
        for test in &mut run.tests {
            let axis = &machine.rotary_axes()[test.axis];
            let bar = test.bar.unit(axis.letter, axis.direction);
            if let Observed::Readings(readings) = &mut test.observed {
                for reading in readings {
                    reading.length_change_mm = bodies.reading(
                        &errors,
                        setup_mm,
                        100.0,
                        bar,
                        test.ball_mm,
                        test.axis,
                        reading.angle_rad,
                    ) + seeded.normal() * 1e-3;
                }
            }
        }
        let found = identify(&machine, &run).expect("a fit");
        let truth = errors_of(&errors);
        let covariance = found.covariance.clone().expect("many readings");
        let off = nalgebra::DVector::from_iterator(
            8,
            found.unknowns.iter().map(|unknown| match unknown {
                Unknown::Error(parameter) => parameter.value(&found.errors) - parameter.value(&truth),
                Unknown::SetupError(_) => f64::NAN,
            }),
        );
        for (index, within) in within.iter_mut().enumerate() {
            let sigmas = off[index].abs() / covariance[(index, index)].sqrt();
            within[0] += u32::from(sigmas <= 1.0);
            within[1] += u32::from(sigmas <= 3.0);
        }
        squares += off.dot(&covariance.cholesky().expect("positive").solve(&off));
    }
    for (index, [one, three]) in within.into_iter().enumerate() {
        let (one, three) = (f64::from(one) / f64::from(draws), f64::from(three) / f64::from(draws));
        assert!((one - ONE_SIGMA).abs() < near(ONE_SIGMA), "unknown {index}: {one} within one sigma");
        assert!(three > THREE_SIGMA - near(THREE_SIGMA), "unknown {index}: {three} within three sigma");
    }
    // All eight together: the quadratic form's mean is 8 (chi square), a little more for the estimated noise; its
    // variance is twice that for one draw.
    let spread = (16.0 / f64::from(draws)).sqrt();
    let mean = squares / f64::from(draws);
    assert!((mean - 8.1).abs() < 4.0 * spread, "mean quadratic form {mean}");
}
