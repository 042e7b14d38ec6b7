//! Singular regions of programs that others wrote.
#![expect(clippy::panic, clippy::print_stdout, reason = "a test may stop, and tells what it measured")]

use std::fs;
use std::ops::ControlFlow;

use trunnion::kinematics::SingularityKind;
use trunnion::machine::{Machine, RotaryLetter, Tool};
use trunnion::motion::Interpolation;
use trunnion::process::{
    CcParameters, ContactSource, LeftReason, MemoryStepStore, ProgramSetup, SingularityAction,
    SingularityParameters, SingularityReport, treat_and_compensate, treat_singular_regions,
};
use trunnion::side_by_side::OneAfterAnother;
use trunnion::units::Length;

use crate::set_ups::at_zero;
use crate::shared_file;
use crate::tables::tables;

fn read(name: &str) -> Option<Vec<u8>> {
    shared_file(name)
        .map(|path| fs::read(&path).unwrap_or_else(|fault| panic!("{}: {fault}", path.display())))
}

fn run(
    name: &str,
    machine: &Machine,
    mode: Interpolation,
    action: SingularityAction,
    program: &[u8],
) -> (Vec<u8>, SingularityReport) {
    let radius = Length::from_mm(3.0);
    let tool = Tool::new(radius, radius).expect("a ball");
    let parameters = CcParameters {
        program: ProgramSetup { interpolation: Some(mode), ..at_zero() },
        ..CcParameters::new(tool, at_zero())
    };
    let mut output = Vec::new();
    let go_on = || ControlFlow::Continue(());
    let singularity = SingularityParameters::new(action);
    let source = program.to_vec();
    let report = treat_singular_regions(machine, &parameters, &singularity, &source, &mut output, &go_on)
        .unwrap_or_else(|fault| panic!("{name}: {fault:?}"));
    println!(
        "{name} {}: {} motions, {} singular in {} regions, {} treated, left {:?}; nearest {:?}, fastest {:?}; {:?} -> {:?}; blocks {} -> {}, changed {}, axis spent {:.4}°",
        action.name(),
        report.motions_checked,
        report.motions_singular,
        report.regions_found,
        report.regions_treated,
        report.left,
        report.nearest.map(|(line, angle)| (line, angle.deg())),
        report.fastest,
        report.before,
        report.after,
        report.blocks_in,
        report.blocks_out,
        report.blocks_changed,
        report.axis_spent.deg(),
    );
    (output, report)
}

/// The regions as the compensation of the contact's path finds them in its own reading.
fn found_beside(
    name: &str,
    machine: &Machine,
    mode: Interpolation,
    contact: ContactSource,
    program: &[u8],
) -> [Option<SingularityReport>; 2] {
    let radius = Length::from_mm(3.0);
    let tool = Tool::new(radius, radius).expect("a ball");
    let parameters = CcParameters {
        program: ProgramSetup { interpolation: Some(mode), ..at_zero() },
        contact,
        ..CcParameters::new(tool, at_zero())
    };
    let singularity = SingularityParameters::new(SingularityAction::Report);
    let (source, go_on) = (program.to_vec(), || ControlFlow::Continue(()));
    let (beside, _) = treat_and_compensate(
        machine,
        &parameters,
        &singularity,
        &source,
        &MemoryStepStore::default(),
        &mut Vec::new(),
        &OneAfterAnother,
        &go_on,
    )
    .unwrap_or_else(|fault| panic!("{name}: {fault:?}"));
    let alone =
        treat_singular_regions(machine, &parameters, &singularity, &source, &mut Vec::new(), &go_on).ok();
    [beside, alone]
}

const ACTIONS: [SingularityAction; 3] =
    [SingularityAction::Report, SingularityAction::Densify, SingularityAction::Smooth];

#[test]
fn the_operation_that_starts_in_the_pole_is_seen_and_treated() {
    let Some(program) = read("programs/5axis/nx_mori_nmv5000_bc_g43.4.txt") else { return };
    let text = String::from_utf8_lossy(&program);
    let operation = text.find("(Operation Name: VARIABLE_CONTOUR_MCS9)").expect("the operation");
    let text = format!("G20 G90 G94\n{}", &text[operation..]);
    let machine = tables([RotaryLetter::B, RotaryLetter::C], false);
    for action in ACTIONS {
        let run = |text: &str| run("mori", &machine, Interpolation::Machine, action, text.as_bytes());
        let (output, report) = run(&text);
        assert!(report.motions_checked >= 290);
        let region = report.regions[0];
        assert_eq!(region.kind, SingularityKind::Pole);
        // B0 C315, and the next block is B-.274 C369.167.
        assert!(region.least_angle.deg() < 1e-9);
        assert!((region.before.step_deg - 54.167).abs() < 1e-9);
        match action {
            SingularityAction::Report => assert_eq!(output, text.as_bytes()),
            SingularityAction::Densify => {
                // 54° on 0.01 mm: parts that keep their line in that time would need F in the millions.
                let left = report.left.iter().find(|left| left.reason == LeftReason::FeedTooHigh);
                assert_eq!(left.map(|left| (left.count, left.first_line)), Some((1, region.first_line)));
                assert!(region.after.is_some_and(|after| (after.step_deg - 54.167).abs() < 1e-9));
                // Without that block everything is divided.
                let begun =
                    text.replacen("X0.0 Y0.0 Z-.3881 B0.0 C315.", "X-.0004 Y0.0 Z-.3881 B-.274 C369.167", 1);
                let (_, report) = run(&begun.replacen("\nX-.0004 B-.274 C369.167", "", 1));
                assert!(report.blocks_inserted > 10);
                let after = report.regions[0].after.expect("read back");
                assert!(after.step_deg <= 5.0 + 1e-6 && after.axis_deviation.deg() <= 0.05);
                assert!(after.deviation.mm() <= 0.01);
            }
            SingularityAction::Smooth => {
                assert_eq!(report.blocks_in, report.blocks_out);
                assert!(report.axis_spent.deg() <= 0.05);
                assert!(report.after.rotary_deg_per_s <= report.before.rotary_deg_per_s);
            }
        }
    }
}

#[test]
fn real_passes_are_reported_and_treated_without_a_fault() {
    for (name, letters, reversed, mode) in [
        (
            "programs/5axis/linuxcnc_impeller_xyzac_tcp_g93.ngc",
            [RotaryLetter::A, RotaryLetter::C],
            false,
            Interpolation::Tcp,
        ),
        (
            "programs/5axis/zhangty_simple_curve_bc_machine.gcode",
            [RotaryLetter::B, RotaryLetter::C],
            true,
            Interpolation::Machine,
        ),
    ] {
        let Some(program) = read(name) else { return };
        let machine = tables(letters, reversed);
        for contact in [ContactSource::Tip, ContactSource::FeedPlane] {
            let [beside, alone] = found_beside(name, &machine, mode, contact, &program);
            assert!(alone.is_some(), "{name}");
            assert_eq!(beside, alone, "{name}");
        }
        for action in ACTIONS {
            let (output, report) = run(name, &machine, mode, action, &program);
            assert!(report.motions_checked > 4000);
            assert!(report.regions.len() as u64 <= report.regions_found);
            if report.regions_treated == 0 {
                assert_eq!(output, program);
            }
            assert!(
                report.after.rotary_deg_per_s <= report.before.rotary_deg_per_s.map(|speed| speed * 1.01)
            );
            assert!(report.axis_spent.deg() <= 0.05 + 1e-9);
        }
    }
}
