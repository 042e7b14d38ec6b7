//! The servo model against the values of the reference drive, closed forms of the frequency response and a
//! brute-force integration of the drive's equations.

use std::ops::ControlFlow;

use trunnion::servo::{
    AxisLetter, AxisServo, Circle, CircleCommand, Detail, Drive, DrivePreset, DriveSet, Resonance, Run,
    Simulation, poles, simulate_circle, stable_poles,
};
use trunnion::units::Feedrate;

/// Values given to nine significant digits are met to half a unit of the last.
const NINE_DIGITS: f64 = 5.5e-9;
/// P2's sample period [s].
const PERIOD_S: f64 = 0.001;

fn go_on() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn reference_x() -> Drive {
    DrivePreset::by_id("reference-linear").expect("a preset").drive
}

fn reference_c() -> Drive {
    DrivePreset::by_id("reference-rotary").expect("a preset").drive
}

fn close(value: f64, expected: f64, relative: f64) {
    let off = (value - expected).abs() / expected.abs();
    assert!(off <= relative, "{value} is not {expected}: off by {off:e}");
}

fn xc(gain_x: f64, gain_c: f64, feed_mm_per_min: f64) -> Simulation {
    let mut drives = DriveSet::default();
    drives.set(AxisLetter::X, reference_x().with_position_gain(gain_x));
    drives.set(AxisLetter::C, reference_c().with_position_gain(gain_c));
    let run = Run::at(Feedrate::from_mm_per_min(feed_mm_per_min));
    let circle = Circle::XC { radius_mm: 60.0, center_x_mm: 100.0 };
    let command = CircleCommand::new(circle, &run).expect("a circle");
    simulate_circle(&command, &drives, Detail::Summary, &go_on).expect("a stable run")
}

#[test]
fn the_poles_of_the_rigid_axis_are_those_of_the_reference() {
    let expected = [-8.365_008_27, -40.284_128_6, -114.239_662, -4_750.011_63];
    for (pole, expected) in poles(&reference_x()).iter().zip(expected) {
        close(pole.re, expected, NINE_DIGITS);
        assert!(pole.im.abs() < 1e-9, "{pole}");
    }
}

/// Where the loop begins to swing, by bisection on the poles.
fn gain_limit(drive: &Drive) -> f64 {
    let (mut low, mut high) = (1.0, 1e5);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if stable_poles(&drive.with_position_gain(middle)).is_ok() { low = middle } else { high = middle }
    }
    low
}

#[test]
fn the_position_gain_at_which_the_loop_swings_is_that_of_the_reference() {
    close(gain_limit(&reference_x()), 4_953.718_86, NINE_DIGITS);
    let resonance = Some(Resonance { frequency_hz: 60.0, damping_ratio: 0.05 });
    close(gain_limit(&Drive { resonance, ..reference_x() }), 192.406_307, NINE_DIGITS);
}

#[test]
fn the_response_to_a_sine_on_a_ramp_is_that_of_the_reference() {
    let mut servo = AxisServo::new(&reference_x(), PERIOD_S, 0.0).expect("a step");
    let command: Vec<f64> = (0..=1000)
        .map(|k| {
            let t = f64::from(k) * PERIOD_S;
            5.0 * (12.0 * t).sin() + 20.0 * t
        })
        .collect();
    let mut positions = Vec::new();
    servo.follow(&command, &mut positions);
    close(positions[100], 4.818_909_39, NINE_DIGITS);
    close(positions[500], 6.335_741_30, NINE_DIGITS);
    close(positions[1000], 15.415_843_7, NINE_DIGITS);
}

#[test]
fn the_circle_of_p2_has_the_radius_errors_of_the_reference() {
    let matched = xc(30.0, 30.0, 1800.0);
    close(matched.contour.min_mm * 1e3, -11.106_107_3, NINE_DIGITS);
    close(matched.contour.max_mm * 1e3, -2.271_959_35, NINE_DIGITS);
    let unequal = xc(30.0, 25.0, 1800.0);
    close(unequal.contour.min_mm * 1e3, -114.421_536, NINE_DIGITS);
    close(unequal.contour.max_mm * 1e3, 97.148_611_9, NINE_DIGITS);
}

#[test]
fn the_oval_lies_as_p2_draws_it() {
    let slow_c = xc(30.0, 25.0, 1800.0).oval.expect("an oval").major_axis_rad.to_degrees();
    let slow_x = xc(25.0, 30.0, 1800.0).oval.expect("an oval").major_axis_rad.to_degrees();
    // given to a tenth of a degree
    assert!((slow_c - 134.9).abs() <= 0.05, "{slow_c}");
    assert!((slow_x - 47.8).abs() <= 0.05, "{slow_x}");
}
