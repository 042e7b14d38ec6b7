//! Travels of the linear axes under tool-centre-point control. Their positions depend on the work offset: without it no
//! operation may take them for checked, and none may take the offset for zero.
#![expect(clippy::panic, reason = "a test may stop at what it did not expect")]

use std::ops::ControlFlow;

use trunnion::machine::{Machine, MachineParts, Travel};
use trunnion::process::{
    CcParameters, ContactSource, Fault, ProgramSetup, SingularityAction, SingularityParameters, Warning,
    WarningKind, WearParameters, WornCutter, compensate, compensate_wear, treat_singular_regions,
};
use trunnion::units::Length;

use crate::models::finishing::{ac_machine, tool};
use crate::models::pole_passes::{PassShape, pole_pass};
use crate::models::set_ups::at_zero;

const TCP: &str = "G21 G90 G94 G17\nG43.4 H1\nG0 X0.0000 Y0.0000 Z50.0000 A10.0000 C0.0000\n\
    G1 X10.0000 Y5.0000 Z50.0000 A20.0000 C10.0000 F1000\nX20.0000 Y5.0000 Z50.0000 A30.0000 C25.0000\nM30\n";

/// The machine with X far from where any of these programs moves.
fn with_travel_elsewhere(machine: &Machine) -> Machine {
    Machine::new(MachineParts {
        name: String::new(),
        rotary_axes: machine.rotary_axes().to_vec(),
        linear_travel_mm: [Some(Travel { min: 5000.0, max: 6000.0 }), None, None],
        interpolation_period_s: machine.interpolation_period_s(),
        squareness: *machine.squareness(),
    })
    .unwrap_or_else(|faults| panic!("{faults:?}"))
}

fn without_offset() -> ProgramSetup {
    ProgramSetup { work_offsets: ProgramSetup::default().work_offsets, ..at_zero() }
}

fn not_checked(warnings: &[Warning]) -> u64 {
    warnings
        .iter()
        .filter(|warning| warning.kind == WarningKind::TravelNotChecked)
        .map(|warning| warning.count)
        .sum()
}

#[test]
fn a_travel_that_depends_on_an_unknown_offset_gives_a_warning() {
    let (source, go_on) = (TCP.as_bytes().to_vec(), || ControlFlow::Continue(()));
    let machine = with_travel_elsewhere(&ac_machine());
    let parameters = CcParameters::new(tool(5.0, 5.0), without_offset());
    let cc = compensate(&machine, &parameters, &source, &mut Vec::new(), &go_on);
    let cc = cc.unwrap_or_else(|fault| panic!("{fault:?}"));
    assert!(not_checked(&cc.warnings) > 0, "{:?}", cc.warnings);
    let parameters = WearParameters {
        contact: ContactSource::FeedPlane,
        ..WearParameters::new(tool(5.0, 5.0), WornCutter::Tool(tool(4.9, 4.9)), without_offset())
    };
    let wear = compensate_wear(&machine, &parameters, &source, &mut Vec::new(), &go_on);
    let wear = wear.unwrap_or_else(|fault| panic!("{fault:?}"));
    assert!(wear.motions_shifted > 0 && not_checked(&wear.warnings) > 0, "{:?}", wear.warnings);
    // With the offset, the same travel refuses the program.
    let stated = WearParameters { program: at_zero(), ..parameters };
    compensate_wear(&machine, &stated, &source, &mut Vec::new(), &go_on).expect_err("X is far outside");
}

#[test]
fn a_region_is_treated_alike_whatever_travel_cannot_be_checked() {
    let pass = pole_pass("ac-table", true, PassShape::PLAIN);
    let (source, go_on) = (pass.text.clone().into_bytes(), || ControlFlow::Continue(()));
    let parameters = CcParameters::new(pass.tool, without_offset());
    let treat = |machine: &Machine, parameters: &CcParameters| {
        let asked = SingularityParameters::new(SingularityAction::Smooth);
        let mut output = Vec::new();
        let report = treat_singular_regions(machine, parameters, &asked, &source, &mut output, &go_on);
        (output, report.unwrap_or_else(|fault| panic!("{fault:?}")).regions_treated)
    };
    let free = treat(&pass.machine, &parameters);
    let elsewhere = with_travel_elsewhere(&pass.machine);
    assert!(free.1 > 0, "nothing was treated");
    assert_eq!(treat(&elsewhere, &parameters), free);
    // With the offset the travel counts, and nothing may be moved.
    assert_eq!(treat(&elsewhere, &CcParameters::new(pass.tool, at_zero())).1, 0);
}

#[test]
fn the_parts_of_a_divided_block_are_refused_only_for_travels_that_are_known() {
    let (source, go_on) = (TCP.as_bytes().to_vec(), || ControlFlow::Continue(()));
    let with = |program: ProgramSetup| CcParameters {
        contact: ContactSource::FeedPlane,
        tolerance: Length::from_um(1.0),
        ..CcParameters::new(tool(5.0, 1.0), program)
    };
    let run = |machine: &Machine, program: ProgramSetup| {
        let mut output = Vec::new();
        let report = compensate(machine, &with(program), &source, &mut output, &go_on)?;
        Ok::<_, Fault>((output, report.motions_over_tolerance, not_checked(&report.warnings)))
    };
    let (free, divided, _) = run(&ac_machine(), without_offset()).unwrap_or_else(|fault| panic!("{fault:?}"));
    assert!(divided > 0, "nothing was divided");
    let elsewhere = with_travel_elsewhere(&ac_machine());
    let (unchecked, _, told) = run(&elsewhere, without_offset()).unwrap_or_else(|fault| panic!("{fault:?}"));
    assert_eq!(unchecked, free);
    // One warning for each motion, however many parts it has.
    assert_eq!(told, 3);
    run(&elsewhere, at_zero()).expect_err("X is far outside");
}
