//! Whole programs that others wrote, moved for a worn cutter and read again.

use std::fs;
use std::ops::ControlFlow;

use trunnion::machine::{Machine, RotaryLetter, Tool};
use trunnion::motion::Interpolation;
use trunnion::process::{ContactSource, Fault, WearParameters, WearReport, WornCutter, compensate_wear};
use trunnion::units::Length;

use crate::set_ups::at_zero;
use crate::tables::tables;
use crate::{every_file, shared_file};
use trunnion::process::ProgramSetup;

/// Half a unit of three decimals on three axes, or of four in inches [mm].
const ROUNDED_MM: f64 = 0.0025;

fn tool(radius_mm: f64, corner_mm: f64) -> Tool {
    Tool::new(Length::from_mm(radius_mm), Length::from_mm(corner_mm)).expect("a tool")
}

fn run(
    machine: &Machine,
    parameters: &WearParameters,
    program: &[u8],
) -> Result<(Vec<u8>, WearReport), Fault> {
    let mut output = Vec::new();
    let source = program.to_vec();
    let report = compensate_wear(machine, parameters, &source, &mut output, &|| ControlFlow::Continue(()))?;
    Ok((output, report))
}

#[test]
fn the_impeller_and_the_printed_layers_are_moved_whole() {
    let ball = |radius_mm| WornCutter::Tool(tool(radius_mm, radius_mm));
    for (name, letters, reversed, interpolation, radius_mm) in [
        (
            "programs/5axis/linuxcnc_impeller_xyzac_tcp_g93.ngc",
            [RotaryLetter::A, RotaryLetter::C],
            false,
            Some(Interpolation::Tcp),
            3.0,
        ),
        (
            "programs/5axis/zhangty_simple_curve_bc_machine.gcode",
            [RotaryLetter::B, RotaryLetter::C],
            true,
            None,
            0.4,
        ),
    ] {
        let Some(path) = shared_file(name) else { return };
        let program = fs::read(path).expect("a file");
        let nominal = tool(radius_mm, radius_mm);
        let parameters = WearParameters {
            program: ProgramSetup { interpolation, ..at_zero() },
            contact: ContactSource::FeedPlane,
            ..WearParameters::new(nominal, ball(0.95 * radius_mm), at_zero())
        };
        let (output, report) = run(&tables(letters, reversed), &parameters, &program)
            .unwrap_or_else(|fault| panic!("{name}: {fault:?}"));
        println!(
            "{name}: {} contacts, {} moved, {} blocks changed, F lowered {} restored {}; before {:.2} µm, after {:.3} µm, shift {:.2} µm at {:?}",
            report.contacts_assumed,
            report.motions_shifted,
            report.blocks_changed,
            report.feeds_lowered,
            report.feeds_restored,
            report.before.max_mm * 1e3,
            report.after.max_mm * 1e3,
            report.max_shift.um(),
            report.max_shift_line,
        );
        for warning in &report.warnings {
            println!("  {:?} × {} at {:?} {:?}", warning.kind, warning.count, warning.line, warning.reason);
        }
        assert_eq!(report.contact, ContactSource::FeedPlane);
        assert!(report.contacts_assumed > 4000 && report.motions_shifted > 1000);
        // Nothing is proven where contacts are assumed.
        assert!(report.contacts_kept == 0 && report.after.max_mm >= report.before.max_mm - ROUNDED_MM);
        assert!(report.after_if_assumed.expect("assumed").max_mm <= ROUNDED_MM);
        let lines = |text: &[u8]| text.split(|byte| *byte == b'\n').count();
        assert_eq!(lines(&output), lines(&program));
    }
}

#[test]
fn every_iso_program_is_moved_or_refused_by_line_and_never_miswritten() {
    let Some(folder) = shared_file("programs") else { return };
    let machines = [
        tables([RotaryLetter::A, RotaryLetter::C], false),
        tables([RotaryLetter::B, RotaryLetter::C], false),
    ];
    let nominal = tool(5.0, 5.0);
    let by_feed = |actual| WearParameters {
        contact: ContactSource::FeedPlane,
        ..WearParameters::new(nominal, WornCutter::Tool(actual), at_zero())
    };
    let shorter = WearParameters { shorter_by: Length::from_mm(0.2), ..by_feed(nominal) };
    let asked = [
        by_feed(tool(4.75, 4.75)),
        by_feed(tool(5.2, 1.0)),
        shorter,
        WearParameters::new(nominal, WornCutter::Tool(nominal), at_zero()),
    ];
    let (mut moved, mut refused) = ([0; 4], [0; 4]);
    for path in every_file(&folder) {
        let program = fs::read(&path).expect("a file");
        for machine in &machines {
            for (k, parameters) in asked.iter().enumerate() {
                match run(machine, parameters, &program) {
                    Ok((output, report)) => {
                        let after = report.after_if_assumed.unwrap_or(report.after);
                        assert!(after.max_mm <= ROUNDED_MM, "{}", path.display());
                        assert!(k < 3 || output == program, "{}", path.display());
                        assert!(
                            report.blocks_changed + report.feeds_restored > 0 || output == program,
                            "{}",
                            path.display()
                        );
                        moved[k] += 1;
                    }
                    Err(
                        fault @ (Fault::VerificationFailed { .. } | Fault::Unwritable { .. } | Fault::Io(_)),
                    ) => panic!("{}: {fault}", path.display()),
                    Err(_) => refused[k] += 1,
                }
            }
        }
    }
    println!("moved {moved:?}, refused {refused:?}");
    // Most move three axes only, without a word of where the rotary axes stand: nothing of them can be moved.
    assert!(moved[0] > 0 && moved[3] > 60 && refused[0] > 0, "{moved:?} {refused:?}");
}
