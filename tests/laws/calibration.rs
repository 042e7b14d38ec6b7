//! Calibration: what holds for every plan of tests.

use proptest::prelude::*;
use trunnion::calibration::{
    BallBarRun, BallBarTest, BarDirection, Identified, Observed, Reading, SetupError, expected_readings,
    identify,
};
use trunnion::geometry::Vec3;
use trunnion::machine::{LocationError, Machine, PRESETS};

fn machine(index: usize) -> Machine {
    Machine::new(PRESETS[index % PRESETS.len()].parts()).expect("a machine")
}

fn ball_bar_test(axis: usize, bar: usize, ball_mm: [f64; 3], tool_length_mm: f64) -> BallBarTest {
    let readings = (-9..=9)
        .map(|k| Reading { angle_rad: f64::from(k) * std::f64::consts::PI / 18.0, length_change_mm: 0.0 })
        .collect();
    BallBarTest {
        axis,
        bar: BarDirection::ALL[bar % 3],
        ball_mm: Vec3::from(ball_mm),
        tool_length_mm,
        reading_uncertainty: 1.0,
        observed: Observed::Readings(readings),
    }
}

/// Both axes in every direction, and one test more where it is given.
fn plan(extra: Option<BallBarTest>) -> BallBarRun {
    let mut tests = Vec::new();
    for axis in 0..2 {
        for bar in 0..3 {
            tests.push(ball_bar_test(axis, bar, [150.0, 20.0, 60.0], 180.0));
            tests.push(ball_bar_test(axis, bar, [30.0, 90.0, 160.0], 300.0));
        }
    }
    tests.extend(extra);
    BallBarRun {
        bar_length_mm: 100.0,
        offset_per_test: true,
        instrument_uncertainty_mm: None,
        setup_error: SetupError::Known([0.0; 2]),
        tests,
    }
}

/// Readings of a machine without errors, disturbed alternately by ±1 µm: the scatter is the same whatever the plan.
fn disturbed(machine: &Machine, mut run: BallBarRun) -> BallBarRun {
    let expected = expected_readings(machine, &run, &[LocationError::default(); 2], [0.0; 2]).expect("a run");
    for (test, values) in run.tests.iter_mut().zip(expected) {
        if let Observed::Readings(readings) = &mut test.observed {
            for (number, (reading, value)) in readings.iter_mut().zip(values).enumerate() {
                reading.length_change_mm = value + if number % 2 == 0 { 1e-3 } else { -1e-3 };
            }
        }
    }
    run
}

/// Variances for noise of 1, whatever this run's residuals are.
fn unit_variances(run: &BallBarRun, found: &Identified) -> Vec<f64> {
    let covariance = found.covariance.as_ref().expect("many readings");
    let squares = found.residual_rms_mm.powi(2) * run.readings() as f64;
    let noise = squares / found.degrees_of_freedom as f64;
    (0..covariance.nrows()).map(|index| covariance[(index, index)] / noise).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn a_further_test_never_makes_an_error_less_certain(
        preset in 0..PRESETS.len(), axis in 0..2_usize, bar in 0..3_usize,
        x in -200.0..200.0, y in -200.0..200.0, z in -50.0..200.0,
    ) {
        /// The fits end at slightly different places, where slopes differ by parts in a million.
        const SAME: f64 = 1.0 + 1e-5;
        let machine = machine(preset);
        let before = disturbed(&machine, plan(None));
        let after = disturbed(&machine, plan(Some(ball_bar_test(axis, bar, [x, y, z], 250.0))));
        let (fewer, more) = (identify(&machine, &before).expect("a fit"), identify(&machine, &after).expect("a fit"));
        for (fewer, more) in unit_variances(&before, &fewer).iter().zip(unit_variances(&after, &more)) {
            prop_assert!(more <= fewer * SAME, "{more} after {fewer}");
        }
    }

    #[test]
    fn weights_count_by_their_ratio_alone(preset in 0..PRESETS.len(), power in -5..5_i32) {
        let machine = machine(preset);
        let run = disturbed(&machine, plan(None));
        let mut scaled = run.clone();
        for test in &mut scaled.tests {
            test.reading_uncertainty = 2.0_f64.powi(power);
        }
        prop_assert_eq!(identify(&machine, &scaled), identify(&machine, &run));
    }
}

#[test]
fn a_test_told_to_be_noisy_pulls_less() {
    let machine = machine(0);
    let mut run = disturbed(&machine, plan(None));
    let errors = |run: &BallBarRun| identify(&machine, run).expect("a fit").errors;
    let mut others = run.clone();
    others.tests.remove(0);
    let of_the_others = errors(&others);
    // One test whose readings grow by 4 µm with the angle, as no location error makes them; no outliers.
    if let Observed::Readings(readings) = &mut run.tests[0].observed {
        for reading in readings {
            reading.length_change_mm += 0.004 * reading.angle_rad.sin().abs();
        }
    }
    let pulled = |run: &BallBarRun| {
        let pairs = errors(run).into_iter().zip(of_the_others);
        pairs.map(|(here, there)| (here.translation_mm - there.translation_mm).norm()).fold(0.0, f64::max)
    };
    let trusted = pulled(&run);
    run.tests[0].reading_uncertainty = 30.0;
    let doubted = pulled(&run);
    assert!(doubted < 0.05 * trusted, "{doubted} mm, and {trusted} mm when it is trusted");
}
