//! Whole programs that others wrote, compensated in one pass for a machine with location errors.
#![expect(clippy::print_stdout, reason = "tells what it measured")]

use std::fs;
use std::ops::ControlFlow;

use nalgebra::{Rotation3, Unit};
use trunnion::geometry::Vec3;
use trunnion::machine::{Machine, RotaryLetter, Tool};
use trunnion::motion::Interpolation;
use trunnion::process::{
    CcStep, CompensationParameters, CompensationReport, ContactSource, Fault, MemoryStepStore, WearStep,
    WornCutter, compensate_program,
};
use trunnion::side_by_side::OneAfterAnother;
use trunnion::units::Length;

use crate::displaced::{Line, displaced, errors, with_errors};
use crate::set_ups::at_zero;
use crate::tables::tables;
use crate::{every_file, shared_file};
use trunnion::process::ProgramSetup;

/// Half a unit of three decimals on three axes, or of four in inches [mm].
const ROUNDED_MM: f64 = 0.0025;
/// The printed layers' own decimals against their way points [mm], and ours.
const PRINTED_MM: f64 = 0.0012 + 0.001;

fn ball(radius_mm: f64) -> Tool {
    let radius = Length::from_mm(radius_mm);
    Tool::new(radius, radius).expect("a ball")
}

fn run(
    machine: &Machine,
    parameters: &CompensationParameters,
    program: &[u8],
) -> Result<(Vec<u8>, CompensationReport), Fault> {
    let mut output = Vec::new();
    let (source, spool) = (program.to_vec(), MemoryStepStore::default());
    let go_on = || ControlFlow::Continue(());
    let report = compensate_program(
        machine,
        parameters,
        &source,
        &spool,
        &mut output,
        &mut (),
        &OneAfterAnother,
        &go_on,
    )?;
    Ok((output, report))
}

fn say(name: &str, report: &CompensationReport) {
    let budget = &report.budget;
    println!(
        "{name}: {} -> {} blocks, {} changed",
        report.blocks_in, report.blocks_out, report.changes.motions_changed
    );
    for (name, line) in [
        ("interpolation", budget.interpolation),
        ("location errors", budget.location_errors),
        ("wear", budget.wear),
        ("rounding", budget.rounding),
        ("sum", budget.sum),
    ] {
        println!(
            "  {name}: {:.2} -> {:.2} µm at {:?} {:?}",
            line.before_mm * 1e3,
            line.after_mm * 1e3,
            line.before_line,
            line.after_line
        );
    }
    println!("  axis: {:.1} -> {:.1} µrad", budget.axis_before_rad * 1e6, budget.axis_after_rad * 1e6);
    if let Some(location) = &report.location_errors {
        println!(
            "  posted {}, turned {}, largest turn {:.3}° at {:?}, held {}",
            location.motions_posted,
            location.motions_turned,
            location.max_turn.deg(),
            location.max_turn_line,
            location.held_at_pole
        );
    }
    for entry in &budget.not_modelled {
        if entry.count.is_some() {
            println!("  not modelled: {} × {:?} at {:?}", entry.kind.name(), entry.count, entry.first_line);
        }
    }
}

/// Words of a block that has all five.
fn five(line: &str) -> Option<[f64; 5]> {
    let mut words = [None; 5];
    for word in line.split(' ') {
        if let Some(k) = ["X", "Y", "Z", "B", "C"].iter().position(|letter| word.starts_with(letter)) {
            words[k] = word[1..].parse().ok();
        }
    }
    let [Some(x), Some(y), Some(z), Some(b), Some(c)] = words else { return None };
    Some([x, y, z, b, c])
}

#[test]
fn the_printed_layers_meet_their_way_points_on_a_machine_with_errors() {
    let name = "programs/5axis/zhangty_simple_curve_bc_machine.gcode";
    let (Some(path), Some(points)) =
        (shared_file(name), shared_file("programs/5axis/zhangty_simple_curve_waypoints.txt"))
    else {
        return;
    };
    let program = fs::read(path).expect("a file");
    let machine = with_errors(&tables([RotaryLetter::B, RotaryLetter::C], true), errors());
    let parameters =
        CompensationParameters { location_errors: true, ..CompensationParameters::new(at_zero()) };
    let (output, report) = run(&machine, &parameters, &program).unwrap_or_else(|fault| panic!("{fault:?}"));
    say(name, &report);
    let lines: [Line; 2] = displaced([(Vec3::y(), Vec3::zeros()), (Vec3::z(), Vec3::zeros())], errors());
    let turned = |line: Line, deg: f64, p: Vec3| {
        Rotation3::from_axis_angle(&Unit::new_normalize(line.0), deg.to_radians()) * (p - line.1) + line.1
    };
    let points: Vec<Vec3> = fs::read_to_string(points)
        .expect("a file")
        .lines()
        .filter_map(|line| {
            let numbers: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            (numbers.len() == 6).then(|| Vec3::new(numbers[0], numbers[1], numbers[2] + 40.5))
        })
        .collect();
    // A word that stands where it did is not repeated by us either: everything is modal.
    let mut modal = [f64::NAN; 5];
    let (mut met, mut worst, mut worst_nominal) = (0, 0.0_f64, 0.0_f64);
    let source = String::from_utf8_lossy(&program).into_owned();
    let output = String::from_utf8(output).expect("text");
    assert_eq!(source.lines().count(), output.lines().count());
    for (before, after) in source.lines().zip(output.lines()) {
        let Some(nominal) = five(before).filter(|_| before.starts_with("G1 ") && before.contains(" E"))
        else {
            continue;
        };
        let words = five(after).unwrap_or(modal);
        modal = words;
        let tip = |[x, y, z, b, c]: [f64; 5]| turned(lines[1], -c, turned(lines[0], -b, Vec3::new(x, y, z)));
        worst = worst.max((tip(words) - points[met]).norm());
        worst_nominal = worst_nominal.max((tip(nominal) - points[met]).norm());
        met += 1;
    }
    println!(
        "{met} way points: {:.2} µm as printed, {:.2} µm as posted anew",
        worst_nominal * 1e3,
        worst * 1e3
    );
    assert!(met > 41_000 && met == points.len());
    assert!(worst <= PRINTED_MM && worst_nominal > 0.03, "{worst} {worst_nominal}");
    assert!((report.budget.location_errors.before_mm - worst_nominal).abs() < PRINTED_MM);
}

#[test]
fn the_impeller_gets_all_steps_at_once() {
    let Some(path) = shared_file("programs/5axis/linuxcnc_impeller_xyzac_tcp_g93.ngc") else { return };
    let program = fs::read(path).expect("a file");
    let machine = with_errors(&tables([RotaryLetter::A, RotaryLetter::C], false), errors());
    let contact = ContactSource::FeedPlane;
    let parameters = CompensationParameters {
        wear: Some(WearStep { contact, ..WearStep::new(ball(3.0), WornCutter::Tool(ball(2.85))) }),
        location_errors: true,
        cc: Some(CcStep { contact, tolerance: Length::from_um(5.0), ..CcStep::new(ball(3.0)) }),
        program: ProgramSetup { interpolation: Some(Interpolation::Tcp), ..at_zero() },
        ..CompensationParameters::new(at_zero())
    };
    let (_, report) = run(&machine, &parameters, &program).unwrap_or_else(|fault| panic!("{fault:?}"));
    say("impeller", &report);
    assert!(report.changes.motions_changed > 4000);
    assert!(report.budget.rounding.after_mm <= ROUNDED_MM);
    assert!(report.budget.interpolation.after_mm <= 0.005);
    // X Y Z are places of the workpiece: the control knows where its axes are, and only the axis was off.
    assert!(report.budget.axis_before_rad > 5e-5);
    assert_eq!(report.location_errors.expect("a step").max_tip, Length::ZERO);
}

#[test]
fn every_program_is_compensated_or_refused_and_comes_back_where_nothing_is_wrong() {
    let Some(folder) = shared_file("programs") else { return };
    let perfect = [RotaryLetter::A, RotaryLetter::B].map(|first| tables([first, RotaryLetter::C], false));
    let location = CompensationParameters { location_errors: true, ..CompensationParameters::new(at_zero()) };
    let contact = ContactSource::FeedPlane;
    let wear =
        |worn_mm| Some(WearStep { contact, ..WearStep::new(ball(5.0), WornCutter::Tool(ball(worn_mm))) });
    let cc = |tolerance_um| {
        Some(CcStep { contact, tolerance: Length::from_um(tolerance_um), ..CcStep::new(ball(5.0)) })
    };
    let all = CompensationParameters { wear: wear(4.8), cc: cc(10.0), ..location.clone() };
    let nothing = CompensationParameters { wear: wear(5.0), cc: cc(10_000.0), ..location.clone() };
    let (mut written, mut refused) = ([0; 3], [0; 3]);
    for path in every_file(&folder) {
        let program = fs::read(&path).expect("a file");
        for machine in &perfect {
            let real = with_errors(machine, errors());
            for (k, (machine, parameters)) in
                [(&real, &location), (&real, &all), (machine, &nothing)].into_iter().enumerate()
            {
                match run(machine, parameters, &program) {
                    Ok((output, report)) => {
                        let name = path.display();
                        assert!(report.budget.rounding.after_mm <= ROUNDED_MM, "{name}");
                        assert!(k < 2 || output == program || report.blocks_out > report.blocks_in, "{name}");
                        written[k] += 1;
                    }
                    Err(
                        fault @ (Fault::VerificationFailed { .. } | Fault::Unwritable { .. } | Fault::Io(_)),
                    ) => panic!("{}: {fault}", path.display()),
                    Err(_) => refused[k] += 1,
                }
            }
        }
    }
    println!("location errors, all, nothing: written {written:?}, refused {refused:?}");
    // Most move three axes only, without a word of where the rotary axes stand: nothing of them can be moved.
    assert!(written[0] > 0 && written[2] > 60, "{written:?} {refused:?}");
}
