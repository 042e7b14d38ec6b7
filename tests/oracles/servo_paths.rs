//! Paths through the kinematics of a machine, and whole programs, against closed forms and against each other.

use std::fmt::Write;
use std::ops::ControlFlow;

use trunnion::geometry::Vec3;
use trunnion::kinematics::{Kinematics, Setup, ToolPose};
use trunnion::machine::{Machine, Preset};
use trunnion::process::{Fault, ProgramSimulation, SimulationParameters, simulate as simulate_program};
use trunnion::servo::{
    AxisLetter, Circle, Detail, Drive, DrivePreset, DriveSet, FeedProfile, MatchingOptions, Resonance, Run,
    ServoFault, ServoPath, Simulation, Stability, ToolCommand, ToolPath, match_gains, simulate,
};
use trunnion::units::Feedrate;

use crate::set_ups::at_zero;
use AxisLetter::{A, B, C, X, Y, Z};

/// Positions of some 100 mm that have to be the same but for rounding \[mm\].
const ROUNDING_MM: f64 = 1e-12;
/// Directions that have to be the same but for rounding \[rad\].
const ROUNDING_RAD: f64 = 1e-12;

fn go_on() -> ControlFlow<()> {
    ControlFlow::Continue(())
}

fn machine(id: &str) -> Machine {
    Machine::new(Preset::by_id(id).expect("a preset").parts()).expect("a machine")
}

fn drives(linear_gain: f64, rotary_gain: f64) -> DriveSet {
    let linear = DrivePreset::by_id("reference-linear").expect("a preset").drive;
    let rotary = DrivePreset::by_id("reference-rotary").expect("a preset").drive;
    let mut set = DriveSet::default();
    for axis in [X, Y, Z] {
        set.set(axis, linear.with_position_gain(linear_gain));
    }
    for axis in [A, B, C] {
        set.set(axis, rotary.with_position_gain(rotary_gain));
    }
    set
}

fn along(machine: &Machine, path: &ToolPath, run: &Run, drives: &DriveSet) -> Result<Simulation, ServoFault> {
    let kinematics = Kinematics::new(machine, &Setup::default());
    let path = ServoPath::Tool { machine, kinematics: &kinematics, path, plane_normal: Some(Vec3::z()) };
    simulate(&path, run, drives, Detail::Trace, &go_on)
}

fn at(feed_mm_per_min: f64) -> Run {
    Run::at(Feedrate::from_mm_per_min(feed_mm_per_min))
}

#[test]
fn a_circle_through_the_kinematics_is_the_circle_of_two_axes() {
    /// Chords of 0.03 mm on a radius of 60 mm sag by 2 nm.
    const SAGITTA_MM: f64 = 1e-5;
    let mut set = drives(30.0, 30.0);
    set.set(Y, set.get(X).expect("a drive").with_position_gain(26.0));
    let two_axes = ServoPath::Circle(Circle::Linear { axes: [X, Y], radius_mm: 60.0 });
    let expected = simulate(&two_axes, &at(1800.0), &set, Detail::Summary, &go_on).expect("a run").contour;
    let path = ToolPath::ConeFrustum {
        center_mm: Vec3::zeros(),
        radius_mm: 60.0,
        half_apex_rad: 0.0,
        tilt_rad: 0.0,
    };
    let found = along(&machine("ac-table"), &path, &at(1800.0), &set).expect("a run").contour;
    assert!((found.min_mm - expected.min_mm).abs() < SAGITTA_MM, "{found:?} {expected:?}");
    assert!((found.max_mm - expected.max_mm).abs() < SAGITTA_MM, "{found:?} {expected:?}");
}

#[test]
fn a_held_tip_strays_by_the_difference_of_the_lags() {
    /// Second order of lag times angular speed, and the start of the motion.
    const SECOND_ORDER: f64 = 0.01;
    /// What equal lags leave of it: R (ω/K)²/2 = 1.8 µm of 107 µm.
    const EQUAL_LAGS: f64 = 0.017;
    // The table turns at 0.2 rad/s under a tip 80 mm from its centre: ω R (1/K_C − 1/K_XY).
    let path = ToolPath::TipHold {
        tip_mm: Vec3::new(80.0, 0.0, 0.0),
        rotary_rad: [[0.0, 0.0], [0.0, std::f64::consts::TAU]],
    };
    let feed_deg_per_min = 0.2_f64.to_degrees() * 60.0;
    let run = Run { laps: 1, ..at(feed_deg_per_min) };
    let machine = machine("ac-table");
    let unequal = along(&machine, &path, &run, &drives(30.0, 25.0)).expect("a run");
    let expected_mm = 0.2 * 80.0 * (1.0 / 25.0 - 1.0 / 30.0);
    let middle = unequal.trace.iter().filter(|point| (5.0..25.0).contains(&point.time_s));
    for point in middle {
        assert!((point.contour_mm.abs() / expected_mm - 1.0).abs() < SECOND_ORDER, "{point:?}");
    }
    let equal = along(&machine, &path, &run, &drives(30.0, 30.0)).expect("a run");
    assert!(equal.contour.rms_mm < EQUAL_LAGS * expected_mm, "{:?}", equal.contour);
    // The tool axis stays parallel to C, whatever C does.
    assert!(unequal.contour.axis_max_rad.expect("an axis") < ROUNDING_RAD);
}

#[test]
fn only_the_turning_of_the_axis_is_judged_along_its_own_course() {
    // The tip rests on the centre line of both rotary axes: A swings, and the axis runs late but on its course.
    let path = ToolPath::TipHold { tip_mm: Vec3::zeros(), rotary_rad: [[-0.5, 0.0], [0.5, 0.0]] };
    let run = Run { laps: 1, ..at(600.0) };
    let found = along(&machine("ac-table"), &path, &run, &drives(30.0, 30.0)).expect("a run");
    assert!(found.contour.max_abs_mm < ROUNDING_MM, "{:?}", found.contour);
    // Lag 10°/s / 30 = 5.8 mrad, yet the axis stays in the plane of its course and turns before its end.
    let axis_rad = found.contour.axis_rms_rad.expect("an axis");
    assert!(axis_rad < ROUNDING_RAD, "{axis_rad}");
}

#[test]
fn a_cone_frustum_moves_all_five_axes_and_its_error_grows_with_feed() {
    /// Of the error at twice the feed: unequal lags grow as the feed, twice, second order as its square, four times;
    /// the latter has a tenth of the error at the lower feed.
    const GROWTH: std::ops::Range<f64> = 2.0..2.4;
    let path = ToolPath::ConeFrustum {
        center_mm: Vec3::new(20.0, 10.0, 5.0),
        radius_mm: 40.0,
        half_apex_rad: 15_f64.to_radians(),
        tilt_rad: 30_f64.to_radians(),
    };
    let machine = machine("ac-table");
    let slow = along(&machine, &path, &at(500.0), &drives(30.0, 25.0)).expect("a run");
    let fast = along(&machine, &path, &at(1000.0), &drives(30.0, 25.0)).expect("a run");
    assert_eq!(slow.axes.len(), 5);
    let ratio = fast.contour.max_abs_mm / slow.contour.max_abs_mm;
    assert!(GROWTH.contains(&ratio), "{ratio}");
}

#[test]
fn a_path_that_cannot_be_run_is_refused_with_its_reason() {
    let machine = machine("ac-table");
    let set = drives(30.0, 30.0);
    let frustum = |half_apex_deg: f64| ToolPath::ConeFrustum {
        center_mm: Vec3::zeros(),
        radius_mm: 40.0,
        half_apex_rad: half_apex_deg.to_radians(),
        tilt_rad: 0.0,
    };
    assert!(matches!(
        along(&machine, &frustum(130.0), &at(500.0), &set),
        Err(ServoFault::Unreachable { .. })
    ));
    let far = ToolPath::TipHold { tip_mm: Vec3::zeros(), rotary_rad: [[0.0, 0.0], [3.0, 0.0]] };
    assert!(matches!(
        along(&machine, &far, &at(500.0), &set),
        Err(ServoFault::OutOfTravel { axis: 'A', .. })
    ));
    let still = ToolPath::TipHold { tip_mm: Vec3::zeros(), rotary_rad: [[0.0, 0.0], [0.0, 0.0]] };
    assert!(matches!(along(&machine, &still, &at(500.0), &set), Err(ServoFault::NoLength)));
    assert!(matches!(
        along(&machine, &frustum(10.0), &at(1e-4), &set),
        Err(ServoFault::TooManySamples { .. })
    ));
    let pole = ToolPath::Polyline {
        poses: [-0.2_f64, 0.2]
            .map(|tilt| ToolPose {
                tip_mm: Vec3::new(100.0 * tilt, 0.0, 0.0),
                axis: Vec3::new(tilt.sin(), 1e-3, tilt.cos()).normalize(),
            })
            .to_vec(),
    };
    assert!(matches!(along(&machine, &pole, &at(60_000.0), &set), Err(ServoFault::Jump { axis: 'C', .. })));
    let no_drive = along(&machine, &frustum(10.0), &at(500.0), &DriveSet::default());
    assert!(matches!(no_drive, Err(ServoFault::NoDrive { .. })));
    let mut swinging = set;
    swinging.set(Y, set.get(Y).expect("a drive").with_position_gain(6000.0));
    let unstable = along(&machine, &frustum(10.0), &at(500.0), &swinging);
    assert!(matches!(unstable, Err(ServoFault::Unstable { axis: Y, .. })), "{unstable:?}");
}

#[test]
fn a_tool_is_followed_until_it_has_arrived_however_slow_its_drives_are() {
    /// Share of the lag that is left after five time constants of the slowest pole, e⁻⁵ = 0.7 %.
    const LEFT: f64 = 0.01;
    let poses = [[0.0, 0.0], [40.0, 0.0], [40.0, 2.0]]
        .map(|[x, y]| ToolPose { tip_mm: Vec3::new(x, y, 0.0), axis: Vec3::z() })
        .to_vec();
    let program = b"G90 G21 G94 G17\nG0 X0 Y0 Z0 A0 C0\nG1 X40 F1200\nY2\nM30\n";
    for gain_per_s in [1.0, 5.0, 30.0, 150.0] {
        let set = drives(gain_per_s, gain_per_s);
        let along =
            along(&machine("ac-table"), &ToolPath::Polyline { poses: poses.clone() }, &at(1200.0), &set);
        let program = run_program(program, &SimulationParameters::new(set, at_zero())).expect("a run");
        for trace in [along.expect("a run").trace, program.outcome.trace] {
            let lag_mm = |slot: usize| trace.iter().map(move |point| point.following[slot].abs());
            let largest_mm = lag_mm(0).fold(0.0, f64::max);
            let last_mm =
                lag_mm(0).next_back().expect("a trace").max(lag_mm(1).next_back().expect("a trace"));
            assert!(last_mm < LEFT * largest_mm, "{gain_per_s}: {last_mm} mm of {largest_mm} mm are left");
        }
    }
}

fn straight(length_mm: f64) -> ToolPath {
    let pose = |x: f64| ToolPose { tip_mm: Vec3::new(x, 0.0, 0.0), axis: Vec3::z() };
    ToolPath::Polyline { poses: vec![pose(0.0), pose(length_mm)] }
}

#[test]
fn a_command_ends_where_its_path_ends() {
    let machine = machine("ac-table");
    let kinematics = Kinematics::new(&machine, &Setup::default());
    // Steps of 0.03 mm: the first ends between two samples, the second on one, the third within the first step.
    for length_mm in [10.005, 9.0, 1e-6] {
        let command = ToolCommand::new(&machine, &kinematics, &straight(length_mm), &at(1800.0), &go_on);
        let end_mm = *command.expect("a command").joints.x_mm.last().expect("samples");
        assert!((end_mm - length_mm).abs() < ROUNDING_MM, "{end_mm} is not {length_mm}");
    }
}

#[test]
fn a_straight_line_has_no_error_however_far_the_tool_is_behind() {
    /// The integral part overshoots the end by 0.33 % of the lag v/K.
    const OVERSHOOT: f64 = 3.4e-3;
    let machine = machine("ac-table");
    // Lags of 33, 200 and 3300 samples; the tool rests for tens of thousands.
    for (gain_per_s, period_s) in [(30.0, 1e-3), (5.0, 1e-3), (30.0, 1e-5)] {
        let run = Run { period_s, ..at(1800.0) };
        let set = drives(gain_per_s, gain_per_s);
        let found = along(&machine, &straight(9.0), &run, &set).expect("a run").contour;
        assert!(found.max_abs_mm <= OVERSHOOT * 30.0 / gain_per_s, "{gain_per_s} {period_s}: {found:?}");
    }
    // 33 000 samples are more than the foot is looked for: no answer rather than a wrong one.
    let run = Run { period_s: 1e-5, ..at(1800.0) };
    let lost = along(&machine, &straight(30.0), &run, &drives(3.0, 3.0));
    assert!(matches!(lost, Err(ServoFault::TooFarBehind { .. })), "{lost:?}");
}

#[test]
fn a_lap_of_a_few_samples_is_no_circle() {
    let machine = machine("ac-table");
    let set = drives(30.0, 30.0);
    // 2π mm a lap: 31 steps of 0.2 mm, 21 of 0.3 mm, none of 100 mm.
    for (feed, is_told) in [(12_000.0, true), (18_000.0, false), (6e6, false)] {
        let circles = [
            ServoPath::Circle(Circle::Linear { axes: [X, Y], radius_mm: 1.0 }),
            ServoPath::Circle(Circle::XC { radius_mm: 1.0, center_x_mm: 1e6 }),
        ];
        for circle in circles {
            let found = simulate(&circle, &at(feed), &set, Detail::Summary, &go_on);
            let is_refused = matches!(found, Err(ServoFault::TooFewSamples { .. }));
            assert_eq!(is_refused, !is_told, "{feed}: {found:?}");
        }
        let frustum = ToolPath::ConeFrustum {
            center_mm: Vec3::zeros(),
            radius_mm: 1.0,
            half_apex_rad: 0.0,
            tilt_rad: 0.0,
        };
        let found = along(&machine, &frustum, &at(feed), &set);
        assert_eq!(matches!(found, Err(ServoFault::TooFewSamples { .. })), !is_told, "{feed}: {found:?}");
    }
}

#[test]
fn proposed_gains_keep_the_margins_or_there_are_none() {
    let circle = ServoPath::Circle(Circle::XC { radius_mm: 60.0, center_x_mm: 100.0 });
    // A soft axis: 16 1/s is the limit of stability.
    let resonance = Some(Resonance { frequency_hz: 5.0, damping_ratio: 0.05 });
    let mut set = drives(0.5, 0.5);
    set.set(X, Drive { resonance, ..*set.get(X).expect("a drive") });
    let options = MatchingOptions { least_gain_margin: 20.0, ..MatchingOptions::default() };
    let found = match_gains(&circle, &at(1800.0), &set, &[0.01], &options, &go_on).expect("an answer");
    assert!(!found.gains.reached, "{found:?}");
    for (axis, gain_per_s) in found.gains.position_gain_per_s {
        let drive = set.get(axis).expect("a drive").with_position_gain(gain_per_s);
        let margin = Stability::of(&drive).expect("a stable loop").gain_margin.expect("a margin");
        assert!(margin >= options.least_gain_margin, "{axis}: {margin}");
    }
    let options = MatchingOptions { least_gain_margin: 1e6, ..options };
    let none = match_gains(&circle, &at(1800.0), &set, &[0.01], &options, &go_on);
    assert!(matches!(none, Err(ServoFault::NoGainWithinMargins { .. })), "{none:?}");
}

/// The circle of the linear axes as a program of short blocks, with TCP or without.
fn circle_program(tcp: bool, feed: f64) -> Vec<u8> {
    let mut text = String::from("G90 G21 G94 G17\n");
    text += if tcp { "G43.4 H1\n" } else { "" };
    text += "G0 X60 Y0 Z0 A0 C0\n";
    for k in 1..=7200_u32 {
        let phi = f64::from(k) * std::f64::consts::TAU / 3600.0;
        writeln!(text, "G1 X{:.6} Y{:.6} F{feed}", 60.0 * phi.cos(), 60.0 * phi.sin()).expect("text");
    }
    text.into_bytes()
}

fn run_program(text: &[u8], parameters: &SimulationParameters) -> Result<ProgramSimulation, Fault> {
    simulate_program(&machine("ac-table"), parameters, &text.to_vec(), &go_on)
}

#[test]
fn a_program_of_a_circle_has_the_error_of_the_circle() {
    /// Chords of 0.1 mm sag by 23 nm; the polygon's corners excite the loops a little.
    const CHORDS_MM: f64 = 1e-4;
    /// Chords of φ = 0.1° are shorter than their arcs by φ²/24: 3.2 µs in two laps.
    const CHORDS_S: f64 = 4e-6;
    let mut set = drives(30.0, 30.0);
    set.set(Y, set.get(X).expect("a drive").with_position_gain(26.0));
    let two_axes = ServoPath::Circle(Circle::Linear { axes: [X, Y], radius_mm: 60.0 });
    let expected = simulate(&two_axes, &at(1800.0), &set, Detail::Summary, &go_on).expect("a run").contour;
    for tcp in [true, false] {
        let parameters = SimulationParameters {
            plane_normal: Some(Vec3::z()),
            ..SimulationParameters::new(set, at_zero())
        };
        let found = run_program(&circle_program(tcp, 1800.0), &parameters).expect("a run");
        assert_eq!((found.motions, found.passes), (7200, 1));
        // Two laps at 30 mm/s.
        assert!(
            (found.duration_s - 4.0 * std::f64::consts::PI * 2.0).abs() < CHORDS_S,
            "{}",
            found.duration_s
        );
        let contour = found.outcome.contour;
        assert!((contour.max_mm - expected.max_mm).abs() < CHORDS_MM, "{contour:?} {expected:?}");
        assert!(contour.worst_line > 3, "{contour:?}");
    }
}

#[test]
fn a_program_that_leaves_the_travel_is_refused_as_a_path_is() {
    let parameters = SimulationParameters::new(drives(30.0, 30.0), at_zero());
    let swing = |word: &str| {
        let text = format!("G90 G21 G94 G17\nG0 X0 Y0 Z0 A0 C0\nG1 A{word} F6000\nM30\n");
        run_program(text.as_bytes(), &parameters)
    };
    // A of this machine goes to 120°.
    assert!(swing("-120").is_ok());
    let beyond = swing("-300");
    assert!(matches!(beyond, Err(Fault::Servo(ServoFault::OutOfTravel { axis: 'A', .. }))), "{beyond:?}");
}

#[test]
fn rapids_part_a_program_and_what_cannot_be_followed_is_counted() {
    let text =
        b"G90 G21 G94 G17\nG0 X0 Y0 Z0 A0 C0\nG1 X10 F1000\nG0 X0\nG1 X10\nG2 X20 Y10 R10\nG1 X30\nM30\n"
            .to_vec();
    let found = run_program(&text, &SimulationParameters::new(drives(30.0, 30.0), at_zero())).expect("a run");
    assert_eq!((found.motions, found.passes), (3, 3));
    assert_eq!(
        found
            .left_out
            .iter()
            .map(|kind| (kind.reason.name(), kind.count, kind.first_line))
            .collect::<Vec<_>>(),
        [("arc", 1, 6)]
    );
    assert!(found.outcome.following[0].is_some() && found.outcome.following[1].is_none());
    let no_feed = run_program(
        b"G0 X0 Y0 Z0 A0 C0\nG1 X10\n",
        &SimulationParameters::new(drives(30.0, 30.0), at_zero()),
    );
    assert!(
        matches!(no_feed, Err(Fault::NothingToSimulate { left_out: 1, first: Some((_, 2)) })),
        "{no_feed:?}"
    );
    let long = b"G0 X0 Y0 Z0 A0 C0\nG93 G1 X10 F0.0001\n".to_vec();
    let costly = run_program(&long, &SimulationParameters::new(drives(30.0, 30.0), at_zero()));
    assert!(matches!(costly, Err(Fault::TooCostly { .. })), "{costly:?}");
}

#[test]
fn exact_stops_take_the_error_out_of_corners() {
    /// Of the lag v/K that rounds a corner so much is left where the command comes to rest, with averages over
    /// T = v/a = 33 ms and a/j = 50 ms: the product of (1 − e^(−K T))/(K T); then the tool still comes nearer.
    const LEFT_AT_A_STOP: f64 = 0.33;
    let text = b"G90 G21 G94 G17\nG43.4 H1\nG0 X0 Y0 Z0 A0 C0\nG1 X20 F2000\nY20\nX0\nY0\nM30\n".to_vec();
    let parameters = SimulationParameters::new(drives(30.0, 30.0), at_zero());
    let rounded = run_program(&text, &parameters).expect("a run").outcome.contour;
    let profile = Some(FeedProfile { acceleration_mm_per_s2: 1000.0, jerk_mm_per_s3: 20_000.0 });
    let stopping = SimulationParameters { profile, ..parameters };
    let stopped = run_program(&text, &stopping).expect("a run").outcome.contour;
    // 33 mm/s round a corner with 1/K = 33 ms rounds it by some 0.3 mm.
    assert!((0.1..0.6).contains(&rounded.max_abs_mm), "{rounded:?}");
    assert!(stopped.max_abs_mm < LEFT_AT_A_STOP * rounded.max_abs_mm, "{stopped:?}");
}

#[test]
fn matching_finds_gains_and_feeds_that_keep_the_target() {
    /// One Kv for both axes, worked out twice [1/s].
    const GAIN_ROUNDING: f64 = 1e-12;
    /// Of the feed: the search ends within 2⁻¹² of an interval of 29 %.
    const FEED_RESOLUTION: f64 = 1e-3;
    let circle = ServoPath::Circle(Circle::XC { radius_mm: 60.0, center_x_mm: 100.0 });
    let options = MatchingOptions { feeds_mm_per_min: [100.0, 6000.0], ..MatchingOptions::default() };
    let set = drives(30.0, 25.0);
    let targets_mm = [0.01, 0.05];
    let found = match_gains(&circle, &at(1800.0), &set, &targets_mm, &options, &go_on).expect("an answer");
    assert!(found.gains.reached, "{found:?}");
    assert!(found.gains.simulation.contour.max_abs_mm <= 0.01);
    let [(X, x), (C, c)] = found.gains.position_gain_per_s[..] else { panic!("{found:?}") };
    assert!((x - c).abs() < GAIN_ROUNDING && x <= found.gains.largest_per_s, "{x} {c}");
    // 11.1 µm at K = 30; the second-order error falls as 1/(2K²) − c1/K: 10 µm need little more.
    assert!((30.0..35.0).contains(&x), "{x}");
    for (limits, set) in [
        (&found.limits_before, set),
        (&found.limits_after, {
            let mut matched = set;
            matched.set(X, set.get(X).expect("a drive").with_position_gain(x));
            matched.set(C, set.get(C).expect("a drive").with_position_gain(c));
            matched
        }),
    ] {
        for limit in limits {
            let feed = limit.feed.expect("a limit").mm_per_min();
            let error = |feed: f64| {
                simulate(&circle, &at(feed), &set, Detail::Summary, &go_on).expect("a run").contour.max_abs_mm
            };
            assert!(error(feed) <= limit.target_mm, "{limit:?}");
            assert!(error(feed * (1.0 + FEED_RESOLUTION)) > limit.target_mm, "{limit:?}");
        }
    }
    // −114 and +97 µm at 1800: 106 of them shrink with the feed, which allows 851 mm/min; were it 114, 787.
    let before = found.limits_before[1].feed.expect("a limit").mm_per_min();
    assert!((787.0..851.0).contains(&before), "{before}");
}
