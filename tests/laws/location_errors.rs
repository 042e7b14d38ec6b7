//! Laws of posting a program anew for a machine with location errors, seen by an independent witness.
#![expect(
    clippy::panic,
    clippy::float_cmp,
    reason = "a test may stop; words that were copied are the same to the bit"
)]

use std::fmt::Write;

use proptest::prelude::*;
use trunnion::geometry::Vec3;
use trunnion::kinematics::{Joints, Kinematics, Setup};
use trunnion::machine::{Machine, MachineParts, RotaryAxis, Squareness, Travel};
use trunnion::process::{
    CompensationParameters, ContactSource, Fault, LineFaultKind, NotModelledKind, WearStep, WornCutter,
};
use trunnion::program::Dialect;

use super::compensation::witness;
use super::machines::{any_machine, preset_machine, setup};
use super::one_pass::{TURNED_RAD, angle, displaced, done, run, with_setup};
use crate::models::displaced::{errors, with_errors};
use crate::models::finishing::{ac_machine, blade, tool};
use crate::models::set_ups::at_zero;
use crate::models::witness::{Tables, scan};
use trunnion::process::ProgramSetup;

#[test]
fn a_table_that_turns_with_the_tool_upright_still_turns() {
    let machine = with_errors(&ac_machine(), errors());
    let text = "G90 G21 G94\nG0 X40.0000 Y5.0000 Z20.0000 A0.0000 C0.0000\nG1 X42.0000 F800\nC90.0000\nX44.0000 Y6.0000\n\
                C400.0000\nA0.0020 C401.0000\nA20.0000\nA0.0030 C402.0000\nC500.0000\nM30\n";
    let location = CompensationParameters { location_errors: true, ..CompensationParameters::new(at_zero()) };
    let (output, report, _) = done(&machine, &location, text);
    let part = blade(ac_machine(), tool(5.0, 5.0), 3, 1);
    let meant = Tables { offset: Vec3::zeros(), ..witness(&part, false) };
    let real = displaced(&meant, errors());
    let [source, written] = [text, &output].map(|text| scan(text, meant.letters));
    assert_eq!(source.len(), written.len());
    let cone = Kinematics::new(&machine, &Setup::default()).pole_cone_rad();
    let mut held = 0;
    let correction = |k: usize| written[k].angle[1] - source[k].angle[1];
    for (k, (before, after)) in source.iter().zip(&written).enumerate() {
        let ((tip, t), (real_tip, real_t)) =
            (meant.forward(before.q, before.angle), real.forward(after.q, after.angle));
        assert!((tip - real_tip).norm() <= 0.866_025_404e-4 * 1.1, "{}", after.number);
        let upright = before.angle[0].abs() < 0.01;
        held += u64::from(upright);
        assert!(angle(t, real_t) <= if upright { cone } else { TURNED_RAD }, "{}", after.number);
        if upright {
            let last = (0..k).rev().find(|k| source[*k].angle[0] > 1.0).map_or(0.0, correction);
            assert!((correction(k) - last).abs() < 1e-9, "{output}");
        }
    }
    let report = report.location_errors.expect("a step");
    assert_eq!((report.held_at_pole, report.motions_posted), (held, 9));
    assert!(report.max_axis_left.rad() <= cone && report.max_axis_left.rad() > TURNED_RAD);
}

#[test]
fn under_tool_centre_point_control_rotary_words_alone_are_posted_in_every_dialect() {
    let machine = with_errors(&ac_machine(), errors());
    let programs = [
        (
            Dialect::Siemens,
            "N10 G90 G71 G94\nN20 TRAORI\nN30 G1 X=10.0000 Y=0.0000 Z=20.0000 A=-30.0000 C=40.0000 F800\n\
             N40 X12.0000 A-32.0000 C45.0000\nN50 G0 Z90.0000\nN60 M30\n",
        ),
        (
            Dialect::Heidenhain,
            "0 BEGIN PGM T MM\n1 M128\n2 L X+10.0000 Y+0.0000 Z+20.0000 A-30.0000 C+40.0000 R0 F800\n\
             3 L X+12.0000 A-32.0000 C+45.0000\n4 L Z+90.0000 FMAX\n5 END PGM T MM\n",
        ),
        (
            Dialect::Iso,
            "G90 G21 G94 G49\nG43.4 H1\nG1 X10.0000 Y0.0000 Z20.0000 A-30.0000 C40.0000 F800\n\
             X12.0000 A-32.0000 C45.0000\nG0 Z90.0000\nM30\n",
        ),
    ];
    let [meant, real] = [false, true]
        .map(|apply_errors| Kinematics::new(&machine, &Setup { apply_errors, ..Setup::default() }));
    for (dialect, text) in programs {
        let location = CompensationParameters {
            location_errors: true,
            program: ProgramSetup { dialect: Some(dialect), ..at_zero() },
            ..CompensationParameters::new(at_zero())
        };
        let (output, report, changes) = done(&machine, &location, text);
        assert_eq!((report.dialect, changes.len()), (dialect, 3), "{output}");
        assert!(
            report.budget.not_modelled.iter().any(|entry| entry.kind == NotModelledKind::ControlCalibration)
        );
        for (index, (before, after)) in text.lines().zip(output.lines()).enumerate() {
            if ![2, 3].contains(&index) {
                assert_eq!(before, after);
                continue;
            }
            let words = |line: &str| {
                let word = |letter: char| -> f64 {
                    let found = line.split(' ').find(|word| word.starts_with(letter)).expect("a word");
                    found[1..].trim_start_matches('=').parse().expect("a number")
                };
                ([word('A').to_radians(), word('C').to_radians()], word('X'))
            };
            let ((nominal, x), (posted, same)) = (words(before), words(after));
            assert!(x == same && angle(meant.axis(nominal), real.axis(posted)) <= TURNED_RAD, "{after}");
            // All other bytes are where they were.
            let others = |line: &str| {
                line.split(' ')
                    .filter(|word| !word.starts_with(['A', 'C']))
                    .map(str::to_owned)
                    .collect::<Vec<_>>()
            };
            assert_eq!(others(before), others(after));
            assert_ne!(before, after);
        }
    }
    // A vector points the tool on any machine; behind words that were turned it would be found from elsewhere.
    let location = CompensationParameters {
        location_errors: true,
        program: ProgramSetup { dialect: Some(Dialect::Siemens), ..at_zero() },
        ..CompensationParameters::new(at_zero())
    };
    let vectors = "G90 G71 G94\nTRAORI\nG1 X0.0000 Y0.0000 Z20.0000 A3=0.1 B3=0.2 C3=0.95 F800\n\
                   X5.0000 A3=0.11 B3=0.21 C3=0.95\nM30\n";
    let (output, _, changes) = done(&machine, &location, vectors);
    assert_eq!((output.as_str(), changes.len()), (vectors, 0));
    let mixed = vectors.replace("TRAORI\n", "TRAORI\nG1 X0.0000 Y0.0000 Z20.0000 A-30.0000 C40.0000 F800\n");
    let Err(Fault::Lines(faults)) = run(&machine, &location, &mixed) else { panic!("a mixed program") };
    assert_eq!(faults.kept[0].line, 4, "{faults:?}");
}

#[test]
fn words_with_a_sense_of_their_own_lead_where_plain_ones_do() {
    let machine = with_errors(&ac_machine(), errors());
    let siemens = |machine: &Machine, text: &str, location_errors: bool| {
        let wear = WearStep::new(tool(5.0, 5.0), WornCutter::Tool(tool(5.0, 5.0)));
        let wear = Some(WearStep { contact: ContactSource::FeedPlane, ..wear });
        let parameters = CompensationParameters {
            wear: wear.filter(|_| !location_errors),
            location_errors,
            program: ProgramSetup { dialect: Some(Dialect::Siemens), ..at_zero() },
            ..CompensationParameters::new(at_zero())
        };
        done(machine, &parameters, text).0
    };
    let head = "G90 G71 G94\nG0 X0.0000 Y0.0000 Z20.0000 A=-30.0000 C=40.0000\n";
    let plain = format!(
        "{head}G1 X10.0000 Y3.0000 Z21.0000 F800\nX15.0000 A-35.0000 C43.0000\nX0.0000 Y4.0000\nM30\n"
    );
    let own = format!(
        "{head}G1 X=IC(10.0000) Y3.0000 Z=IC(1.0000) F800\nG91 X5.0000 A=AC(-35.0000) C3.0000\nX=AC(0.0000) Y1.0000\nM30\n"
    );
    assert_eq!(siemens(&ac_machine(), &own, false), own);
    assert_eq!(siemens(&ac_machine(), &own, true), own);
    let (by_plain, by_own) = (siemens(&machine, &plain, true), siemens(&machine, &own, true));
    let plain_places: Vec<[f64; 5]> = places(&by_plain);
    let own_places = places(&by_own);
    assert_eq!((plain_places.len(), own_places.len()), (4, 4), "{by_own}");
    for (a, b) in plain_places.iter().flatten().zip(own_places.iter().flatten()) {
        assert!((a - b).abs() < 1.01e-4, "{by_plain}\n{by_own}");
    }
}

/// Where X Y Z A C stand behind every block with one of them, by a reading of its own.
fn places(text: &str) -> Vec<[f64; 5]> {
    let (mut at, mut incremental, mut found) = ([0.0; 5], false, Vec::new());
    for line in text.lines() {
        let mut moved = false;
        for word in line.split(' ') {
            incremental = if word == "G91" { true } else { incremental && word != "G90" };
            let Some(k) = ["X", "Y", "Z", "A", "C"].iter().position(|letter| word.starts_with(letter)) else {
                continue;
            };
            let value = word[1..].trim_start_matches('=').trim_end_matches(')');
            let (counts, value) = match (value.strip_prefix("IC("), value.strip_prefix("AC(")) {
                (Some(value), _) => (true, value),
                (_, Some(value)) => (false, value),
                _ => (incremental, value),
            };
            let value: f64 = value.parse().expect("a number");
            at[k] = if counts { at[k] + value } else { value };
            moved = true;
        }
        found.extend(moved.then_some(at));
    }
    found
}

fn refused_at(machine: &Machine, text: &str) -> Vec<(u64, LineFaultKind)> {
    let parameters =
        CompensationParameters { location_errors: true, ..CompensationParameters::new(at_zero()) };
    match run(machine, &parameters, text) {
        Err(Fault::Lines(faults)) => faults.kept.into_iter().map(|fault| (fault.line, fault.kind)).collect(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_cannot_be_posted_anew_is_refused_by_line() {
    let machine = with_errors(&ac_machine(), errors());
    let start =
        "G90 G21 G94 G17 G54\nG0 X0.000 Y0.000 Z20.000 A-30.000 C0.000\nG1 X10.000 Y2.000 Z21.000 F800\n";
    for (block, line) in [
        ("/X20.000 A-35.000", 4),
        ("G81 X20.000 R30.000", 4),
        ("M98 P100", 4),
        ("X#1", 4),
        ("G2 X60.000 Y52.000 I50.000 J0.000", 4),
        ("G55\nX0.000 Y0.000 Z20.000 A-30.000 C0.000", 5),
    ] {
        let found = refused_at(&machine, &format!("{start}{block}\nM30\n"));
        assert_eq!(found[0].0, line, "{found:?}");
    }
    // Feed before all five axes are known.
    assert_eq!(
        refused_at(&machine, "G90 G21 G94\nG1 X0.000 Y0.000 F800\nG0 Z2.000 A0.000 C0.000\nM30\n")[0].0,
        2
    );
    // At the end of a travel there is no room for a correction.
    let mut parts = MachineParts {
        name: String::new(),
        rotary_axes: machine.rotary_axes().to_vec(),
        linear_travel_mm: [None; 3],
        squareness: Squareness::default(),
        interpolation_period_s: 0.002,
    };
    parts.rotary_axes[0].travel_deg = Some(Travel { min: -30.0, max: 30.0 });
    let narrow = Machine::new(parts).expect("a machine");
    let text = "G90 G21 G94\nG0 X0.000 Y0.000 Z20.000 A-29.000 C0.000\nG1 A30.000 C180.000 F800\nA-30.000 C0.000\nM30\n";
    let found = refused_at(&narrow, text);
    assert!(
        found.iter().all(|(_, kind)| matches!(kind, LineFaultKind::OutOfTravel { axis: 'A', .. })),
        "{found:?}"
    );
}

#[test]
fn increments_inches_and_absent_words_are_posted_as_absolute_millimetres_are() {
    let machine = with_errors(&ac_machine(), errors());
    let location = CompensationParameters { location_errors: true, ..CompensationParameters::new(at_zero()) };
    let absolute = "G90 G21 G94\nG0 X0.0000 Y0.0000 Z20.0000 A-30.0000 C0.0000\nG1 X10.0000 Y2.0000 Z21.0000 A-30.0000 C0.0000 F800\nX20.0000 A-35.0000 C5.0000\nX30.0000 Y5.0000 Z19.0000\nM30\n";
    let increments = "G90 G21 G94\nG0 X0.0000 Y0.0000 Z20.0000 A-30.0000 C0.0000\nG91 G1 X10.0000 Y2.0000 Z1.0000 F800\nX10.0000 A-5.0000 C5.0000\nX10.0000 Y3.0000 Z-2.0000\nM30\n";
    let (by_words, report, _) = done(&machine, &location, absolute);
    assert_eq!(report.location_errors.expect("a step").motions_posted, 4);
    let places = scan(&by_words, ['A', 'C']);
    let (by_steps, _, _) = done(&machine, &location, increments);
    let word = |line: &str, letter: char| -> f64 {
        line.split(' ').find_map(|word| word.strip_prefix(letter)?.parse().ok()).unwrap_or(0.0)
    };
    let (mut q, mut turn) = (places[0].q, places[0].angle);
    for (line, wanted) in by_steps.lines().skip(2).zip(&places[1..]) {
        for (k, letter) in ['X', 'Y', 'Z'].into_iter().enumerate() {
            q[k] += word(line, letter);
        }
        turn = [turn[0] + word(line, 'A'), turn[1] + word(line, 'C')];
        assert!((q - wanted.q).amax() < 1.01e-4, "{by_steps}\n{by_words}");
        assert!((turn[0] - wanted.angle[0]).abs() < 1.01e-4 && (turn[1] - wanted.angle[1]).abs() < 1.01e-4);
    }
    // Words that do not change keep their bytes, rotary words that stand are not repeated.
    assert!(!by_words.lines().nth(4).expect("a block").contains('A'), "{by_words}");
    assert_eq!(by_words.lines().next(), Some("G90 G21 G94"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn every_pose_is_kept_on_every_machine(
        machine in prop_oneof![preset_machine(true), any_machine()],
        setup in setup(),
        points in proptest::collection::vec(([-100.0..100.0_f64, -100.0..100.0, -100.0..100.0], [-40.0..40.0_f64, -170.0..170.0]), 2..12),
    ) {
        let free = Machine::new(MachineParts {
            name: String::new(),
            rotary_axes: machine.rotary_axes().iter().map(|axis| RotaryAxis { travel_deg: None, ..axis.clone() }).collect(),
            linear_travel_mm: [None; 3],
            squareness: *machine.squareness(),
            interpolation_period_s: 0.002,
        }).expect("a machine");
        let letters = free.rotary_axes().each_ref().map(|axis| axis.letter.as_char());
        let mut text = String::from("G90 G21 G94 T1 M6\n");
        for (k, ([x, y, z], [first, second])) in points.iter().enumerate() {
            let code = if k == 0 { "G0" } else { "G1" };
            let [a, b] = letters;
            writeln!(text, "{code} X{x:.4} Y{y:.4} Z{z:.4} {a}{first:.4} {b}{second:.4} F900").expect("text");
        }
        let parameters = CompensationParameters { location_errors: true, ..with_setup(setup) };
        let outcome = run(&free, &parameters, &text);
        if let Err(Fault::Lines(faults)) = &outcome {
            // The real axes may not reach what the nominal ones do.
            prop_assert!(faults.kept.iter().all(|fault| matches!(fault.kind, LineFaultKind::OutOfReach { .. })), "{faults:?}");
            return Ok(());
        }
        let (output, report, _) = outcome.map_err(|fault| TestCaseError::fail(format!("{fault:?}\n{text}")))?;
        let [meant, real] = [false, true].map(|apply_errors| Kinematics::new(&free, &Setup { apply_errors, ..setup }));
        let [source, written] = [&text, &output].map(|text| scan(text, letters));
        let pose = |kinematics: &Kinematics, line: &crate::models::witness::Line| {
            let [first, second] = free.rotary_axes();
            let rotary_rad = [first.angle_rad(line.angle[0]), second.angle_rad(line.angle[1])];
            kinematics.forward(&Joints { linear_mm: line.q, rotary_rad })
        };
        let cone = real.pole_cone_rad();
        for (before, after) in source.iter().zip(&written) {
            let (wanted, found) = (pose(&meant, before), pose(&real, after));
            prop_assert!((wanted.tip_mm - found.tip_mm).norm() <= 1.1 * 0.866_025_404e-4 + 1e-9);
            let turned = angle(wanted.axis, found.axis);
            prop_assert!(turned <= TURNED_RAD || turned <= 2.0 * cone, "{turned}");
            let report = report.location_errors.as_ref().expect("a step");
            prop_assert!(turned <= report.max_axis_left.rad() + 1e-12);
            if report.held_at_pole == 0 && turned > TURNED_RAD {
                prop_assert!(turned <= real.tilt_rad() + TURNED_RAD, "beyond reach: {turned}");
            }
        }
    }
}
