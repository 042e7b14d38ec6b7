//! Laws of compensation in one pass, seen by an independent witness: rotation matrices, axes displaced by hand, the
//! cutters written out.
#![expect(
    clippy::panic,
    clippy::float_cmp,
    reason = "a test may stop at what it did not expect; what nobody added to is zero to the bit"
)]

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU64, Ordering};

use trunnion::geometry::Vec3;
use trunnion::kinematics::Setup;
use trunnion::machine::{LocationError, Machine, Tool};
use trunnion::motion::MotionKind;
use trunnion::process::{
    CcParameters, CcStep, CompensationParameters, CompensationReport, ContactSource, Fault, MemoryStepStore,
    MotionChange, NotModelledKind, ServoStep, SimulationParameters, WearParameters, WearStep, WornCutter,
    compensate, compensate_program, compensate_wear, simulate,
};
use trunnion::servo::{AxisLetter, DrivePreset, DriveSet};
use trunnion::side_by_side::OneAfterAnother;
use trunnion::units::Length;

use super::compensation::witness;
use crate::models::displaced::{errors, with_errors};
use crate::models::finishing::{
    FeedForm, Finishing, Form, ac_machine, blade, dome_near_pole, impeller_flank, tool,
};
use crate::models::set_ups::{at_zero, in_mm, with_tool};
use crate::models::witness::{Tables, scan};

/// Half a unit of four decimals on three axes, once for the words written, and half as much again for the normal that
/// words of four decimals give [mm].
const ROUNDED_MM: f64 = 1.5 * 0.866_025_404e-4;
/// What rounding leaves between the words of a tip and those of its contact [mm].
const WORDS_MM: f64 = 1.3e-4;
/// Half a unit of four decimals on two rotary axes [rad].
pub(crate) const TURNED_RAD: f64 = 0.75e-4 * std::f64::consts::PI / 180.0;
/// Two roundings against one: a unit of the last decimal, and a half for the rotary word that was rounded apart [mm].
const ROUNDED_TWICE_MM: f64 = 2.6e-4;
/// Records between steps are single precision (share).
const SINGLE: f64 = 2e-7;

/// The witness' machine with its axes displaced.
pub(crate) fn displaced(tables: &Tables, errors: [LocationError; 2]) -> Tables {
    let [first, second] = crate::models::displaced::displaced([tables.first, tables.second], errors);
    Tables { first, second, ..*tables }
}

fn parts(tool: Tool) -> [Finishing; 3] {
    [
        blade(ac_machine(), tool, 25, 3),
        impeller_flank(ac_machine(), tool, 30, 3),
        dome_near_pole(ac_machine(), tool, 41, 3),
    ]
}

pub(crate) fn with_setup(setup: Setup) -> CompensationParameters {
    CompensationParameters { program: in_mm(&setup), ..CompensationParameters::new(at_zero()) }
}

fn wear_step(part: &Finishing, worn: Tool) -> WearStep {
    WearStep::new(part.tool, WornCutter::Tool(worn))
}

fn cc_step(part: &Finishing, tolerance_um: f64) -> CcStep {
    CcStep { tolerance: Length::from_um(tolerance_um), ..CcStep::new(part.tool) }
}

pub(crate) type Outcome = (String, CompensationReport, Vec<MotionChange>);

pub(crate) fn run(
    machine: &Machine,
    parameters: &CompensationParameters,
    text: &str,
) -> Result<Outcome, Fault> {
    let (mut output, mut changes) = (Vec::new(), Vec::new());
    let (source, spool) = (text.as_bytes().to_vec(), MemoryStepStore::default());
    let go_on = || ControlFlow::Continue(());
    let report = compensate_program(
        machine,
        parameters,
        &source,
        &spool,
        &mut output,
        &mut changes,
        &OneAfterAnother,
        &go_on,
    )?;
    Ok((String::from_utf8(output).expect("text"), report, changes))
}

pub(crate) fn done(machine: &Machine, parameters: &CompensationParameters, text: &str) -> Outcome {
    run(machine, parameters, text).unwrap_or_else(|fault| panic!("{fault:?}\n{text}"))
}

/// Where a cutter with its tip here touches the surface with this normal, written out.
fn touched(tool: Tool, tip: Vec3, t: Vec3, n: Vec3) -> Vec3 {
    let (corner, core) = (tool.corner_radius().mm(), tool.core_radius().mm());
    let across = n - t * n.dot(&t);
    let m = if core > 0.0 { across.normalize() } else { Vec3::zeros() };
    tip - n * corner - m * core + t * corner
}

pub(crate) fn angle(a: Vec3, b: Vec3) -> f64 {
    a.cross(&b).norm().atan2(a.dot(&b))
}

#[test]
fn on_the_machine_as_it_is_the_worn_cutter_touches_every_point_that_was_meant() {
    for (nominal, actual) in
        [(tool(5.0, 5.0), tool(4.5, 4.5)), (tool(5.0, 1.0), tool(4.6, 0.8)), (tool(5.0, 5.0), tool(5.0, 5.0))]
    {
        for part in parts(nominal) {
            let machine = with_errors(&part.machine, errors());
            for form in [Form::ContactWords, Form::Tcp] {
                let text = part.program(form, FeedForm::PerMinute);
                let parameters = CompensationParameters {
                    wear: Some(wear_step(&part, actual)),
                    location_errors: true,
                    ..with_setup(part.setup)
                };
                let (output, report, changes) = done(&machine, &parameters, &text);
                let meant = witness(&part, form == Form::Tcp);
                let real = displaced(&meant, errors());
                let [source, written] = [&text, &output].map(|text| scan(text, meant.letters));
                assert_eq!([source.len(), written.len()], [part.points.len(); 2]);
                let (mut misses, mut tips, mut wears) = (0.0_f64, 0.0_f64, 0.0_f64);
                for ((point, before), after) in part.points.iter().zip(&source).zip(&written) {
                    let (tip, t) = meant.forward(before.q, before.angle);
                    let (written_tip, written_t) = real.forward(after.q, after.angle);
                    let (real_tip, real_t) = real.forward(before.q, before.angle);
                    let c = touched(nominal, tip, t, point.normal);
                    let written_c = touched(actual, written_tip, written_t, point.normal);
                    // Along the normal it is exact. Over the surface the contact slides with the turn of the axis, and
                    // the more the nearer the normal is to the axis: there the turn swings the side of a bull-nose.
                    let off = written_c - c;
                    let turned = angle(t, written_t);
                    let from_axis = {
                        let arm = c - tip;
                        (arm - t * arm.dot(&t)).norm().max(1e-3)
                    };
                    let core = |tool: Tool| tool.core_radius().mm();
                    let slide = turned
                        * (nominal.radius().mm() + core(nominal) / t.cross(&point.normal).norm())
                        + (core(nominal) - core(actual)).abs() * WORDS_MM / from_axis;
                    assert!(
                        off.dot(&point.normal).abs() <= ROUNDED_MM,
                        "{} {}: {off}",
                        part.name,
                        after.number
                    );
                    assert!(
                        off.norm() <= ROUNDED_MM + slide,
                        "{} {}: {off} {slide}",
                        part.name,
                        after.number
                    );
                    let cone = 2.0 * 2.0 * errors().map(|e| e.rotation_rad.norm()).iter().sum::<f64>();
                    let in_cone = angle(t, Vec3::z()) < cone;
                    assert!(turned <= TURNED_RAD || in_cone, "{} {}: {turned}", part.name, after.number);
                    let miss = real_tip - tip
                        + point.normal * {
                            let depth = |t: Vec3| {
                                let core = nominal.core_radius().mm();
                                nominal.corner_radius().mm() * (1.0 - t.dot(&point.normal))
                                    + core * t.cross(&point.normal).norm()
                            };
                            depth(t) - depth(real_t)
                        };
                    misses = misses.max(miss.norm());
                    tips = tips.max((real_tip - tip).norm());
                    wears = wears.max(
                        (touched(nominal, tip, t, point.normal) - touched(actual, tip, t, point.normal))
                            .dot(&point.normal)
                            .abs(),
                    );
                }
                let budget = &report.budget;
                let location = report.location_errors.as_ref().expect("a step");
                // Contact words of four decimals tell the normal to this.
                let share = 3e-5;
                assert!(
                    (budget.location_errors.before_mm - misses).abs() < ROUNDED_MM + share * misses,
                    "{misses}"
                );
                assert!((location.max_tip.mm() - tips).abs() < 1e-9, "{} {tips}", location.max_tip.mm());
                assert!(
                    (budget.wear.before_mm - wears).abs() < ROUNDED_MM,
                    "{} {wears}",
                    budget.wear.before_mm
                );
                assert!(budget.rounding.after_mm <= ROUNDED_MM && budget.rounding.before_mm == 0.0);
                assert!([budget.location_errors.after_mm, budget.wear.after_mm] == [0.0; 2]);
                assert_eq!(location.motions_posted, part.points.len() as u64);
                assert!(location.has_errors && changes.len() as u64 == report.changes.motions_changed);
                println!(
                    "{} R{} -> R{} {form:?}: tip {:.1} µm, contact {misses:.4}, turn {:.3}°, held {}, axis {:.1} -> {:.2} µrad, wear {:.1} µm",
                    part.name,
                    nominal.radius().mm(),
                    actual.radius().mm(),
                    location.max_tip.um(),
                    location.max_turn.deg(),
                    location.held_at_pole,
                    location.max_axis.rad() * 1e6,
                    location.max_axis_left.rad() * 1e6,
                    wears * 1e3
                );
            }
        }
    }
}

#[test]
fn all_steps_at_once_are_the_steps_one_after_the_other() {
    let (nominal, actual) = (tool(5.0, 5.0), tool(4.75, 4.75));
    for part in parts(nominal) {
        let machine = with_errors(&part.machine, errors());
        for form in [Form::ContactWords, Form::Tcp, Form::NormalTable] {
            let text = part.program(form, FeedForm::PerMinute);
            let location = CompensationParameters { location_errors: true, ..with_setup(part.setup) };
            let (posted, _, _) = done(&machine, &location, &text);
            let worn = WearParameters {
                program: in_mm(&part.setup),
                ..WearParameters::new(nominal, WornCutter::Tool(actual), at_zero())
            };
            let mut apart = Vec::new();
            let go_on = || ControlFlow::Continue(());
            compensate_wear(&machine, &worn, &posted.into_bytes(), &mut apart, &go_on).expect("a program");
            let apart = String::from_utf8(apart).expect("text");
            let both = CompensationParameters { wear: Some(wear_step(&part, actual)), ..location.clone() };
            let (moved, moved_report, _) = done(&machine, &both, &text);
            if form != Form::NormalTable {
                let [apart, at_once] = [&apart, &moved].map(|text| scan(text, ['A', 'C']));
                assert_eq!(apart.len(), at_once.len());
                for (apart, at_once) in apart.iter().zip(&at_once) {
                    let off = (apart.q - at_once.q).amax();
                    assert!(off <= ROUNDED_TWICE_MM, "{} {}: {off}", part.name, apart.number);
                    assert!((apart.angle[0] - at_once.angle[0]).abs() < 1e-9);
                    assert!((apart.angle[1] - at_once.angle[1]).abs() < 1e-9);
                }
            }
            // The contact's path behind them is the step of its own, byte for byte.
            let all = CompensationParameters { cc: Some(cc_step(&part, 4.0)), ..both.clone() };
            let (output, report, changes) = done(&machine, &all, &text);
            let cc = CcParameters {
                tolerance: Length::from_um(4.0),
                program: in_mm(&part.setup),
                ..CcParameters::new(actual, at_zero())
            };
            let mut behind = Vec::new();
            let own = compensate(&machine, &cc, &moved.clone().into_bytes(), &mut behind, &go_on)
                .expect("a program");
            assert_eq!(output.as_bytes(), behind);
            assert_eq!(report.cc.as_ref(), Some(&own));
            assert_eq!(report.blocks_out, own.blocks_out);
            assert_eq!(report.wear, moved_report.wear);
            assert_eq!(report.location_errors, moved_report.location_errors);
            let inserted: u64 = changes.iter().map(|change| u64::from(change.blocks_out) - 1).sum();
            assert_eq!(report.blocks_in + inserted, report.blocks_out);
            assert_eq!(
                report.budget.interpolation.before_line,
                own.before.worst_line.filter(|_| own.before.max_mm > 0.0)
            );
            for (ours, theirs) in [
                (report.budget.interpolation.before_mm, own.before.max_mm),
                (report.budget.interpolation.after_mm, own.after.max_mm),
            ] {
                assert!((ours - theirs).abs() <= SINGLE * theirs, "{ours} {theirs}");
            }
            for change in &changes {
                assert!(change.location_errors_mm > 0.0 || form == Form::Tcp);
                assert_eq!(change.cc_mm > 0.0, change.blocks_out > 1);
            }
            if form == Form::ContactWords {
                let real = displaced(&witness(&part, false), errors());
                let worn = Tables { corner: actual.corner_radius().mm(), core: 0.0, ..real };
                let verdicts = worn.judge(&moved, &output, 100);
                assert!(verdicts.iter().all(|verdict| verdict.after <= 0.004 + 1e-8));
                let largest = |value: fn(&crate::models::witness::Verdict) -> f64| {
                    verdicts.iter().map(value).fold(0.0, f64::max)
                };
                let before = largest(|verdict| verdict.before);
                assert!((report.budget.interpolation.before_mm - before).abs() < 2e-3 * before);
                let after = largest(|verdict| verdict.after);
                assert!((report.budget.interpolation.after_mm - after).abs() < 2e-3 * after);
            }
        }
    }
}

#[test]
fn nothing_to_do_gives_the_bytes_back_and_nothing_asked_is_refused() {
    for part in parts(tool(5.0, 1.0)) {
        for (form, feed) in [
            (Form::ContactWords, FeedForm::PerMinute),
            (Form::Plain, FeedForm::InverseTime),
            (Form::Tcp, FeedForm::PerMinute),
            (Form::NormalTable, FeedForm::PerMinute),
        ] {
            let text = part.program(form, feed).replace("N40 ", "N40 (a comment) ");
            for subset in 1..8_u32 {
                let named = |bit: u32| subset & (1 << bit) != 0;
                let parameters = CompensationParameters {
                    wear: named(0).then(|| wear_step(&part, part.tool)),
                    location_errors: named(1),
                    cc: named(2).then(|| cc_step(&part, 5000.0)),
                    ..with_setup(part.setup)
                };
                let (output, report, changes) = done(&part.machine, &parameters, &text);
                assert!(output == text, "{} {form:?} {subset}", part.name);
                assert_eq!(changes, []);
                assert_eq!((report.blocks_in, report.changes.motions_changed), (report.blocks_out, 0));
                assert_eq!(
                    [report.wear.is_some(), report.location_errors.is_some(), report.cc.is_some()],
                    [0, 1, 2].map(named)
                );
                let lists = |kind| report.budget.not_modelled.iter().any(|entry| entry.kind == kind);
                assert_eq!(lists(NotModelledKind::Wear), !named(0));
                assert_eq!(lists(NotModelledKind::LocationErrors), !named(1));
                assert_eq!(lists(NotModelledKind::Interpolation), !named(2));
                assert!(lists(NotModelledKind::Drives) && lists(NotModelledKind::Thermal));
            }
            let none = with_setup(part.setup);
            assert!(matches!(run(&part.machine, &none, &text), Err(Fault::NothingAsked)));
        }
    }
}

#[test]
fn axes_that_a_vector_or_a_word_of_its_own_form_carries_along_get_no_word() {
    let parameters = CompensationParameters { location_errors: true, ..with_setup(Setup::default()) };
    let head =
        "%_N_A_MPF\nG90 G71 G17 G54\nTRAORI\nG0 X0 Y0 Z10.0000 A10.0000 C0\nG1 G94 X5.0000 F1000\nG91\n";
    for block in ["Y1.0000\nA3=0 B3=0 C3=1\nX1.0000\n", "X=IC(1)\nY1.0000\nA=IC(2) X1.0000\n"] {
        let text = format!("{head}{block}TRAFOOF\nM30\n");
        let (output, report, _) = done(&ac_machine(), &parameters, &text);
        assert_eq!(output, text);
        assert!(report.steps.is_empty());
    }
}

#[test]
fn a_later_step_hides_nothing_of_an_earlier_one() {
    for part in parts(tool(5.0, 5.0)) {
        let machine = with_errors(&part.machine, errors());
        let text = part.program(Form::Plain, FeedForm::PerMinute);
        let contact = ContactSource::FeedPlane;
        let moving = CompensationParameters {
            wear: Some(WearStep { contact, ..wear_step(&part, tool(4.8, 4.8)) }),
            location_errors: true,
            ..with_setup(part.setup)
        };
        let cc =
            CompensationParameters { cc: Some(CcStep { contact, ..cc_step(&part, 4.0) }), ..moving.clone() };
        let servo = CompensationParameters { servo: Some(ServoStep::new(drives())), ..cc.clone() };
        let [(_, alone, first), (_, with_cc, then), (_, with_servo, last)] =
            [&moving, &cc, &servo].map(|parameters| done(&machine, parameters, &text));
        // The wear stays where the contact is only assumed, and the budget says so behind every step.
        assert!(alone.budget.wear.after_mm > 0.0, "{}", part.name);
        for (report, changes) in [(&with_cc, &then), (&with_servo, &last)] {
            for (moved, later) in [
                (alone.budget.wear.before_mm, report.budget.wear.before_mm),
                (alone.budget.wear.after_mm, report.budget.wear.after_mm),
                (alone.budget.location_errors.before_mm, report.budget.location_errors.before_mm),
                (alone.budget.location_errors.after_mm, report.budget.location_errors.after_mm),
                (alone.budget.rounding.after_mm, report.budget.rounding.after_mm),
            ] {
                assert!((moved - later).abs() <= SINGLE * moved, "{}: {moved} {later}", part.name);
            }
            assert_eq!(first.len(), changes.len());
            for (moved, later) in first.iter().zip(changes) {
                let [moved, later] = [moved, later].map(|change| change.error.after.wear_mm);
                assert!((moved - later).abs() <= SINGLE * moved, "{}: {moved} {later}", part.name);
            }
        }
    }
}

fn drives() -> DriveSet {
    let mut drives = DriveSet::default();
    for axis in [AxisLetter::X, AxisLetter::Y, AxisLetter::Z] {
        drives.set(axis, DrivePreset::by_id("reference-linear").expect("a preset").drive);
    }
    for axis in [AxisLetter::A, AxisLetter::C] {
        drives.set(axis, DrivePreset::by_id("reference-rotary").expect("a preset").drive);
    }
    drives
}

#[test]
fn servo_lag_is_that_of_the_written_program_by_lines_of_the_upload() {
    let part = blade(ac_machine(), tool(5.0, 5.0), 25, 2);
    let machine = with_errors(&part.machine, errors());
    let text = part.program(Form::ContactWords, FeedForm::PerMinute);
    let bare = CompensationParameters {
        wear: Some(wear_step(&part, tool(4.8, 4.8))),
        location_errors: true,
        cc: Some(cc_step(&part, 3.0)),
        ..with_setup(part.setup)
    };
    let with_drives = CompensationParameters { servo: Some(ServoStep::new(drives())), ..bare.clone() };
    let (plain, plain_report, plain_changes) = done(&machine, &bare, &text);
    let (output, report, changes) = done(&machine, &with_drives, &text);
    assert_eq!(plain, output);
    assert!(report.blocks_out > report.blocks_in);
    let parameters = SimulationParameters {
        program: in_mm(&part.setup),
        ..SimulationParameters::new(drives(), at_zero())
    };
    let simulated =
        simulate(&machine, &parameters, &output.clone().into_bytes(), &|| ControlFlow::Continue(()))
            .expect("a run");
    let contour = simulated.outcome.contour;
    assert!((report.budget.servo.after_mm - contour.max_abs_mm).abs() <= SINGLE * contour.max_abs_mm);
    // Numbered source blocks carry their line: the upload's line of the worst is that of the last N word before it.
    let worst = usize::try_from(contour.worst_line).expect("a line");
    let number =
        output.lines().take(worst).filter_map(|line| line.split(' ').next()?.strip_prefix('N')).last();
    let upload =
        text.lines().position(|line| line.split(' ').next().and_then(|n| n.strip_prefix('N')) == number);
    assert_eq!(report.budget.servo.after_line, upload.map(|index| index as u64 + 1));
    // Single precision apart, drives change nothing else.
    assert_eq!(plain_changes.len(), changes.len());
    for (plain, change) in plain_changes.iter().zip(&changes) {
        assert_eq!((plain.line, plain.blocks_out, plain.kind), (change.line, change.blocks_out, change.kind));
        assert!((plain.sum_mm() - change.sum_mm()).abs() <= SINGLE * plain.sum_mm());
        assert!(change.error.after.servo_mm > 0.0 || change.kind != MotionKind::Linear);
        assert_eq!(plain.error.after.servo_mm, 0.0);
    }
    assert_eq!(plain_report.cc, report.cc);
    let sum = |change: &MotionChange| change.error.after.sum_mm();
    let largest = changes.iter().map(sum).fold(0.0, f64::max);
    assert!((report.budget.sum.after_mm - largest).abs() < 1e-12);
    assert!(
        report
            .budget
            .worst
            .windows(2)
            .all(|pair| pair[0].error.after.sum_mm() >= pair[1].error.after.sum_mm())
    );
    assert!((report.budget.worst[0].error.after.sum_mm() - largest).abs() < 1e-12);
    // A program too long for the drives is compensated all the same, and the budget says so.
    let short = ServoStep { max_samples: 100, ..ServoStep::new(drives()) };
    let (again, report, _) = done(&machine, &CompensationParameters { servo: Some(short), ..bare }, &text);
    assert_eq!(again, output);
    assert!(report.budget.not_modelled.iter().any(|entry| entry.kind == NotModelledKind::ServoRefused));
    assert_eq!(report.budget.servo.after_mm, 0.0);
}

#[test]
fn lines_are_the_uploads_where_a_block_with_f_alone_came_in_between_the_steps() {
    let machine = with_errors(&ac_machine(), [LocationError::default(); 2]);
    let text = "G90 G21 G94\nG1 X10.000 Y0.000 Z20.000 A-30.000 C0.000 U10.000 V-4.330 W22.500 F720.\n\
                C15.000 U9.000 V-4.330 W22.500\nG91 G28 Z0\nG90 G0 X10.000 Y0.000 Z20.000 A-30.000 C0.000\n\
                G1 Z20.500 U10.000 V-4.330 W23.000\nX30.000 Y10.000 A-45.000 C40.000 U30.000 V5.670 W23.000\n\
                X31.000 U31.000 V5.670 W23.000\nM30\n";
    let parameters = CompensationParameters {
        wear: Some(WearStep::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.5, 4.5)))),
        cc: Some(CcStep::new(tool(5.0, 5.0))),
        ..CompensationParameters::new(at_zero())
    };
    let (output, report, changes) = done(&machine, &parameters, text);
    assert!(output.contains("\nF720.\nG91 G28 Z0\n"), "{output}");
    let cc = report.cc.expect("a step");
    assert_eq!(cc.before.worst_line, Some(7), "{output}");
    let divided: Vec<u64> =
        changes.iter().filter(|change| change.blocks_out > 1).map(|change| change.line).collect();
    assert_eq!(divided, [3, 7]);
    assert_eq!(report.budget.interpolation.before_line, Some(7));
    assert_eq!(report.blocks_out, output.lines().count() as u64);
    // Every motion at feed with a contact is there by its line of the upload.
    let lines: Vec<u64> = changes.iter().map(|change| change.line).collect();
    assert_eq!(lines, [2, 3, 6, 7, 8]);
}

#[test]
fn other_tools_are_posted_anew_too_but_not_moved_for_wear() {
    let machine = with_errors(&ac_machine(), errors());
    let pass = |z: f64| {
        let (start, end) = (format!("{z:.4}"), format!("{:.4}", z + 4.0));
        format!(
            "G0 X0.0000 Y0.0000 Z{start} A-30.0000 C40.0000\nG1 X10.0000 Y2.0000 Z{end} A-31.0000 F800\nX20.0000 A-35.0000 C45.0000\n"
        )
    };
    let text = format!("G90 G21 G94\nT1 M6\n{}T2 M6\n{}M30\n", pass(20.0), pass(30.0));
    let location = CompensationParameters { location_errors: true, ..CompensationParameters::new(at_zero()) };
    let (posted, _, _) = done(&machine, &location, &text);
    let step = WearStep {
        contact: ContactSource::FeedPlane,
        ..WearStep::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.5, 4.5)))
    };
    let program = with_tool(1);
    let (output, _, changes) =
        done(&machine, &CompensationParameters { wear: Some(step), program, ..location }, &text);
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    let [source, posted, output] = [&text, &posted, &output].map(|text| lines(text));
    assert_eq!(posted[6..], output[6..]);
    assert_ne!(posted[6..9], source[6..9]);
    for line in 2..5 {
        assert_ne!(posted[line], output[line]);
    }
    let worn: Vec<u64> =
        changes.iter().filter(|change| change.wear_mm > 0.0).map(|change| change.line).collect();
    assert_eq!(worn, [3, 4, 5]);
    assert_eq!(changes.len(), 6);
}

#[test]
fn the_stop_signal_is_heard_in_every_step() {
    let part = blade(ac_machine(), tool(5.0, 5.0), 15, 2);
    let machine = with_errors(&part.machine, errors());
    let text = part.program(Form::ContactWords, FeedForm::PerMinute).into_bytes();
    let parameters = CompensationParameters {
        wear: Some(wear_step(&part, tool(4.8, 4.8))),
        location_errors: true,
        cc: Some(cc_step(&part, 5.0)),
        servo: Some(ServoStep::new(drives())),
        ..with_setup(part.setup)
    };
    let stopped_after = |calls: u64| {
        let asked = AtomicU64::new(0);
        let stop = || {
            let stops = asked.fetch_add(1, Ordering::Relaxed) >= calls;
            if stops { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let (spool, mut output) = (MemoryStepStore::default(), Vec::new());
        let sides = &OneAfterAnother;
        let result =
            compensate_program(&machine, &parameters, &text, &spool, &mut output, &mut (), sides, &stop);
        (result.map(|_| ()), asked.load(Ordering::Relaxed))
    };
    let (done, asked) = stopped_after(u64::MAX);
    assert!(done.is_ok() && asked > 20, "{done:?} {asked}");
    for calls in 0..asked {
        let (stopped, asked) = stopped_after(calls);
        assert!(matches!(stopped, Err(Fault::Cancelled)), "{calls}: {stopped:?}");
        // Each of the two hands that work side by side may ask once more.
        assert!((calls + 1..=calls + 3).contains(&asked), "{calls}: {asked}");
    }
}
