//! The uncertainty budget of a ball-bar run against second methods: covariance from the readings of the machine of
//! chained bodies, and the identification repeated with every input changed.

use std::f64::consts::PI;

use nalgebra::{DMatrix, DVector};
use trunnion::calibration::{
    BallBarRun, BallBarTest, BarDirection, ErrorParameter, Identified, InputUncertainties, Observed, Reading,
    SetupError, UncertaintyBudget, UncertaintySource, Unknown, identify, uncertainty_budget,
};
use trunnion::geometry::Vec3;
use trunnion::machine::{LocationError, Machine, Preset};

use crate::bar_machine::{AxisErrors, BarMachine, Seeded};

const A: usize = 0;
const C: usize = 1;
/// C's reference point from A's [mm].
const C_FROM_A_MM: [f64; 3] = [2.0, 0.3, -50.0];
/// Ratio of standard uncertainties: the second methods differ in the second order of the changes, and in the rounding
/// of difference quotients.
const AGREE: f64 = 0.01;

fn machine() -> Machine {
    let mut parts = Preset::by_id("ac-table").expect("a preset").parts();
    parts.rotary_axes[A].point_mm = Vec3::zeros();
    parts.rotary_axes[C].point_mm = Vec3::from(C_FROM_A_MM);
    Machine::new(parts).expect("a machine")
}

const SETUP_MM: [f64; 2] = [0.004, -0.006];
const ERRORS: AxisErrors = [[12e-3, -21e-3, 34e-3, 41e-6, -63e-6, 29e-6], [0.0, 15e-3, 0.0, 0.0, 27e-6, 0.0]];

/// Readings of the chained bodies [mm], by test.
fn readings_mm(
    machine: &Machine,
    run: &BallBarRun,
    errors: &AxisErrors,
    setup_mm: [f64; 2],
) -> Vec<Vec<f64>> {
    run.tests
        .iter()
        .map(|test| {
            let bodies = BarMachine::new(machine, test.tool_length_mm);
            let axis = &machine.rotary_axes()[test.axis];
            let bar = test.bar.unit(axis.letter, axis.direction);
            let angles = test.readings().iter().map(|reading| reading.angle_rad);
            angles
                .map(|angle| {
                    bodies.reading(errors, setup_mm, run.bar_length_mm, bar, test.ball_mm, test.axis, angle)
                })
                .collect()
        })
        .collect()
}

/// A run with 0.3 µm of noise.
fn noisy_run(machine: &Machine) -> BallBarRun {
    let test = |axis, bar, ball: [f64; 3]| {
        let (from, to) = if axis == C { (0, 360) } else { (-90, 90) };
        let readings = (from..=to)
            .step_by(10)
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
    let (c_ball, a_ball) = ([150.0, 20.0, 60.0], [30.0, 10.0, 160.0]);
    let mut run = BallBarRun {
        bar_length_mm: 100.0,
        offset_per_test: true,
        instrument_uncertainty_mm: Some(0.5e-3),
        setup_error: SetupError::Known(SETUP_MM),
        tests: vec![
            test(C, BarDirection::Radial, c_ball),
            test(C, BarDirection::Axial, c_ball),
            test(A, BarDirection::Radial, a_ball),
            test(A, BarDirection::Axial, a_ball),
        ],
    };
    let exact = readings_mm(machine, &run, &ERRORS, SETUP_MM);
    let mut noise = Seeded(7);
    for (test, exact) in run.tests.iter_mut().zip(exact) {
        change(test, |index, reading| reading.length_change_mm = exact[index] + 0.3e-3 * noise.normal());
    }
    run
}

fn change(test: &mut BallBarTest, mut each: impl FnMut(usize, &mut Reading)) {
    if let Observed::Readings(readings) = &mut test.observed {
        readings.iter_mut().enumerate().for_each(|(index, reading)| each(index, reading));
    }
}

const INPUTS: InputUncertainties =
    InputUncertainties { setup_error_mm: Some(1e-3), ball_mm: Some(0.5), bar_length_mm: Some(0.2) };

fn standard(budget: &UncertaintyBudget, source: UncertaintySource, index: usize) -> f64 {
    let at = UncertaintySource::ALL.iter().position(|one| *one == source).expect("a source");
    budget.parts[at].as_ref().expect("a part").covariance[(index, index)].sqrt()
}

fn values(found: &Identified) -> Vec<f64> {
    let value = |unknown: &Unknown| match unknown {
        Unknown::Error(parameter) => parameter.value(&found.errors),
        Unknown::SetupError(component) => found.setup_error_mm[*component],
    };
    found.unknowns.iter().map(value).collect()
}

/// Changes a run by a number of standard uncertainties.
type Change<'a> = dyn Fn(&mut BallBarRun, f64) + 'a;

/// Standard uncertainty of every unknown if each of these changes of the run, up and down, is one independent input.
fn by_repeating(machine: &Machine, run: &BallBarRun, changes: &[&Change<'_>]) -> Vec<f64> {
    let identified = |change: &dyn Fn(&mut BallBarRun, f64), sign: f64| {
        let mut run = run.clone();
        change(&mut run, sign);
        values(&identify(machine, &run).expect("a fit"))
    };
    let mut squares = vec![0.0; 8];
    for change in changes {
        let (up, down) = (identified(change, 1.0), identified(change, -1.0));
        for (square, (up, down)) in squares.iter_mut().zip(up.iter().zip(&down)) {
            *square += (0.5 * (up - down)).powi(2);
        }
    }
    squares.into_iter().map(f64::sqrt).collect()
}

fn assert_source(budget: &UncertaintyBudget, source: UncertaintySource, expected: &[f64]) {
    let largest = expected.iter().copied().fold(0.0, f64::max);
    for (index, expected) in expected.iter().enumerate() {
        let found = standard(budget, source, index);
        // A share that is nearly zero is compared with the largest.
        assert!(
            (found - expected).abs() <= AGREE * expected.max(1e-3 * largest),
            "{source:?}, unknown {index}: {found:e} is not {expected:e}"
        );
    }
}

#[test]
fn every_source_of_the_budget_agrees_with_a_second_method() {
    let machine = machine();
    let run = noisy_run(&machine);
    let budget = uncertainty_budget(&machine, &run, &INPUTS).expect("a budget");
    assert_eq!(budget.unknowns.len(), 8);

    let setup = |component: usize| {
        move |run: &mut BallBarRun, sign: f64| {
            let mut known = SETUP_MM;
            known[component] += sign * 1e-3;
            run.setup_error = SetupError::Known(known);
        }
    };
    let (x, y) = (setup(0), setup(1));
    assert_source(&budget, UncertaintySource::SetupError, &by_repeating(&machine, &run, &[&x, &y]));

    // The tests of one axis have the same ball.
    let moved = |axis: usize, component: usize| {
        move |run: &mut BallBarRun, sign: f64| {
            for test in run.tests.iter_mut().filter(|test| test.axis == axis) {
                test.ball_mm[component] += sign * 0.5;
            }
        }
    };
    let balls: Vec<_> = [A, C].into_iter().flat_map(|axis| (0..3).map(move |k| moved(axis, k))).collect();
    let balls: Vec<&Change<'_>> = balls.iter().map(|ball| ball as _).collect();
    assert_source(&budget, UncertaintySource::Ball, &by_repeating(&machine, &run, &balls));

    let longer = |run: &mut BallBarRun, sign: f64| run.bar_length_mm += sign * 0.2;
    assert_source(&budget, UncertaintySource::BarLength, &by_repeating(&machine, &run, &[&longer]));

    let wave = |index: usize, is_sine: bool| {
        move |run: &mut BallBarRun, sign: f64| {
            change(&mut run.tests[index], |_, reading| {
                let (sin, cos) = reading.angle_rad.sin_cos();
                reading.length_change_mm += sign * 0.5e-3 * if is_sine { sin } else { cos };
            });
        }
    };
    let waves: Vec<_> = (0..4).flat_map(|test| [wave(test, false), wave(test, true)]).collect();
    let waves: Vec<&Change<'_>> = waves.iter().map(|wave| wave as _).collect();
    assert_source(&budget, UncertaintySource::Instrument, &by_repeating(&machine, &run, &waves));
}

/// The errors found, as the chained bodies take them.
fn as_bodies(errors: &[LocationError; 2]) -> AxisErrors {
    errors.map(|error| {
        let (shift, turn) = (error.translation_mm, error.rotation_rad);
        [shift.x, shift.y, shift.z, turn.x, turn.y, turn.z]
    })
}

/// A column without the mean of each test: what one offset per test leaves.
fn centred(by_test: &[Vec<f64>]) -> Vec<f64> {
    by_test
        .iter()
        .flat_map(|values| {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter().map(move |value| value - mean)
        })
        .collect()
}

#[test]
fn the_scatter_of_the_readings_is_that_of_the_normal_equations() {
    /// Step of difference quotients [mm, rad].
    const STEP: f64 = 1e-4;
    let machine = machine();
    let run = noisy_run(&machine);
    let found = identify(&machine, &run).expect("a fit");
    assert!(found.outliers.is_empty());
    let budget = uncertainty_budget(&machine, &run, &INPUTS).expect("a budget");

    let errors = as_bodies(&found.errors);
    let model = |errors: &AxisErrors| centred(&readings_mm(&machine, &run, errors, SETUP_MM));
    let columns: Vec<DVector<f64>> = found
        .unknowns
        .iter()
        .map(|unknown| {
            let Unknown::Error(ErrorParameter { axis, component }) = *unknown else {
                panic!("the set-up error is known")
            };
            let moved = |by: f64| {
                let mut errors = errors;
                errors[axis][component] += by;
                DVector::from_vec(model(&errors))
            };
            (moved(STEP) - moved(-STEP)) / (2.0 * STEP)
        })
        .collect();
    let design = DMatrix::from_columns(&columns);
    let measured: Vec<Vec<f64>> = run
        .tests
        .iter()
        .map(|test| test.readings().iter().map(|reading| reading.length_change_mm).collect())
        .collect();
    let residuals = DVector::from_vec(centred(&measured)) - DVector::from_vec(model(&errors));
    let degrees = residuals.len() - 8 - 4;
    assert_eq!(budget.degrees_of_freedom, degrees);
    let variance = residuals.norm_squared() / degrees as f64;
    let covariance = (design.transpose() * &design).try_inverse().expect("an inverse") * variance;
    let expected: Vec<f64> = covariance.diagonal().iter().map(|variance| variance.sqrt()).collect();
    assert_source(&budget, UncertaintySource::Readings, &expected);

    // E_X0C = A.e_x + Δz·A.e_b − Δy·A.e_c, Δ from A's reference point to C's; C.e_x is not fitted.
    let at = |axis: usize, component: usize| {
        let wanted = Unknown::Error(ErrorParameter { axis, component });
        found.unknowns.iter().position(|unknown| *unknown == wanted).expect("an unknown")
    };
    let mut share = DVector::zeros(8);
    share[at(A, 0)] = 1.0;
    share[at(A, 4)] = C_FROM_A_MM[2];
    share[at(A, 5)] = -C_FROM_A_MM[1];
    let expected = (share.transpose() * &covariance * &share)[(0, 0)].sqrt();
    let readings = budget.parts[0].as_ref().expect("the readings");
    let error = readings.absolute.iter().find(|error| error.axis == C && error.component == 0);
    let found = error.and_then(|error| error.variance).expect("E_X0C").sqrt();
    assert!((found / expected - 1.0).abs() < AGREE, "{found:e} is not {expected:e}");
}

#[test]
fn a_source_that_is_not_stated_has_no_part() {
    let machine = machine();
    let mut run = noisy_run(&machine);
    run.instrument_uncertainty_mm = None;
    let budget = uncertainty_budget(&machine, &run, &InputUncertainties::default()).expect("a budget");
    let known: Vec<bool> = budget.parts.iter().map(Option::is_some).collect();
    assert_eq!(known, [true, false, false, false, false]);

    // Eccentricities alone leave no degree of freedom.
    for test in &mut run.tests {
        test.observed = Observed::Eccentricity([0.01, -0.02]);
    }
    let budget = uncertainty_budget(&machine, &run, &INPUTS).expect("a budget");
    assert_eq!(budget.degrees_of_freedom, 0);
    let known: Vec<bool> = budget.parts.iter().map(Option::is_some).collect();
    assert_eq!(known, [false, false, true, true, true]);
}
