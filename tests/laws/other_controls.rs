//! Words that mean another thing on some control than on most: what they change is left alone, and said.

use std::ops::ControlFlow;

use crate::models::set_ups::at_zero;
use trunnion::machine::{Machine, Preset, Tool};
use trunnion::process::{CcParameters, CcReport, Fault, compensate};
use trunnion::units::Length;

const BEGIN: &str = "G21 G90 G94 G17\nG0 X50.000 Y0.000 Z0.000 A0.000 C0.000\n";
/// Turns both axes enough to be divided.
const CUT: &str = "G1 X50.000 Y20.000 A20.000 C20.000 F1000\n";
const CUT_ON: &str = "G1 X50.000 Y30.000 A30.000 C30.000 F1000\n";

fn compensated(text: &str) -> Result<(String, CcReport), Fault> {
    let machine = Machine::new(Preset::by_id("ac-table").expect("a preset").parts()).expect("a machine");
    let tool = Tool::new(Length::from_mm(5.0), Length::from_mm(5.0)).expect("a ball");
    let parameters = CcParameters { tolerance: Length::from_mm(0.01), ..CcParameters::new(tool, at_zero()) };
    let mut output = Vec::new();
    let go_on = || ControlFlow::Continue(());
    let report = compensate(&machine, &parameters, &text.as_bytes().to_vec(), &mut output, &go_on)?;
    Ok((String::from_utf8(output).expect("text"), report))
}

fn warned(report: &CcReport, name: &str) -> bool {
    report.warnings.iter().any(|warning| warning.kind.name() == name)
}

/// The cut before `code` is divided, the one behind it is as it was, and the report says `warning`.
fn left_alone_behind(code: &str, warning: &str) {
    let (plain, _) = compensated(&format!("{BEGIN}{CUT}{CUT_ON}")).expect("compensated");
    assert!(!plain.ends_with(CUT_ON), "the cut is one to be divided");
    let (output, report) = compensated(&format!("{BEGIN}{CUT}{code}{CUT_ON}")).expect("compensated");
    assert!(!output.starts_with(&format!("{BEGIN}{CUT}")), "{output}");
    assert!(output.ends_with(CUT_ON), "{output}");
    assert!(warned(&report, warning), "{code} {:?}", report.warnings);
}

#[test]
fn modes_that_are_given_back_are_not_known() {
    left_alone_behind("G91\nM72\n", "effect_unknown");
}

#[test]
fn units_beside_words_of_a_cycle_are_none() {
    for code in ["G70 I10. J15. L6\n", "G71 I1. J15. K30. L6\n", "G71 P1 Q2\n"] {
        left_alone_behind(code, "effect_unknown");
    }
}

#[test]
fn points_that_a_curve_is_drawn_by_are_no_ends() {
    let nurbs = "G5.2 P1 L3\nX50.000 Y22.000 A22.000 C22.000 P1\nX50.000 Y26.000 A26.000 C26.000 P1\nG5.3\n";
    let (output, report) = compensated(&format!("{BEGIN}{CUT}{nurbs}")).expect("compensated");
    assert!(
        output.contains("X50.000 Y22.000 A22.000 C22.000 P1\nX50.000 Y26.000 A26.000 C26.000 P1\n"),
        "{output}"
    );
    assert!(warned(&report, "not_followed"), "{:?}", report.warnings);
}

#[test]
fn a_hypothetical_axis_stays_where_it_is_until_it_is_real_again() {
    left_alone_behind("G07 C0.\n", "not_followed");
    let back = "G07 C0.\nG07 C1.\n";
    let again = "G1 X50.000 Y20.000 Z0.000 A20.000 C20.000 F1000\n";
    let (output, _) = compensated(&format!("{BEGIN}{CUT}{back}{again}{CUT_ON}")).expect("compensated");
    assert!(output.contains(again) && !output.ends_with(CUT_ON), "{output}");
}

#[test]
fn frames_by_the_codes_of_other_modes_are_not_known() {
    for code in ["G62 X1 Y0 Z0\n", "G11 X50 Y50 P45\n"] {
        left_alone_behind(code, "effect_unknown");
    }
    // The modes themselves change nothing.
    for code in ["G62\n", "G11\n"] {
        let (output, _) = compensated(&format!("{BEGIN}{CUT}{code}{CUT_ON}")).expect("compensated");
        assert!(!output.ends_with(CUT_ON), "{output}");
    }
}

#[test]
fn a_second_linear_axis_keeps_its_pace() {
    for word in ["W10.000", "U1.", "U1. V2."] {
        let cut = format!("G1 X50.000 Y20.000 A20.000 C20.000 {word} F1000\n");
        let (output, report) = compensated(&format!("{BEGIN}{cut}{CUT_ON}")).expect("compensated");
        assert!(output.contains(&cut) && !output.ends_with(CUT_ON), "{output}");
        assert!(warned(&report, "not_followed"), "{:?}", report.warnings);
    }
    // Where G53 sends it counts from elsewhere.
    for retract in ["G0 G53 W0.\n", "G0 G53 Z0. W5.\nG0 Z0.\n"] {
        let cut = "G1 X50.000 Y20.000 A20.000 C20.000 W5. F1000\n";
        let (output, _) =
            compensated(&format!("{BEGIN}G0 W5.\n{retract}{cut}{CUT_ON}")).expect("compensated");
        assert!(output.contains(cut), "{output}");
    }
    // At rest it is in nobody's way.
    let program = format!("{BEGIN}G0 W5.\n{}", CUT.replace("F1000", "W5. F1000"));
    let (output, _) = compensated(&program).expect("compensated");
    assert!(output.lines().count() > program.lines().count(), "{output}");
}

#[test]
fn which_way_an_axis_without_end_rolls_over_is_not_guessed() {
    // Near the axis, where the way round it is not much longer than the line.
    let begin = BEGIN.replace("C0.000", "C350.000").replace("X50.000", "X0.500");
    let cut = "G1 X0.500 Y1.000 A10.000 C10.000 F1000\n";
    let (output, report) = compensated(&format!("{begin}{cut}")).expect("compensated");
    assert_eq!(output, format!("{begin}{cut}"));
    assert!(warned(&report, "may_roll_over"), "{:?}", report.warnings);
    // Counted from where it stands there is no question.
    let (output, _) =
        compensated(&format!("{begin}G91\nG1 Y1.000 A10.000 C-340.000 F1000\n")).expect("compensated");
    assert!(output.lines().count() > 5, "{output}");
}

#[test]
fn conversational_polar_kinematics_are_not_known() {
    let program = |code: &str| {
        format!(
            "0 BEGIN PGM T MM\n1 L X+50.000 Y+0.000 Z+0.000 A+0.000 C+0.000 R0 FMAX\n{code}\
             3 L X+50.000 Y+20.000 A+20.000 C+20.000 F1000\n4 END PGM T MM\n"
        )
    };
    let plain = program("2 ; as it is\n");
    assert_ne!(compensated(&plain).expect("compensated").0, plain);
    for code in [
        "2 M138 A\n",
        "2 L M138 A M128\n",
        "2 POLARKIN AXES X Z C MODE: KEEP POLE:ALLOWED\n",
        "2 FUNCTION CORRDATA TCS #1\n",
    ] {
        let text = program(code);
        match compensated(&text) {
            Ok((output, report)) => assert!(output == text && warned(&report, "not_followed"), "{output}"),
            Err(fault) => assert!(matches!(fault, Fault::NothingFollowed { .. }), "{fault}"),
        }
    }
}

#[test]
fn normals_of_few_decimals_become_directions() {
    let program = "MULTAX/ON\nFEDRAT/1000,MMPM\n\
        GOTO/50.000,10.000,0.000,0.2000000,0.0000000,0.9797959,0,0,1\n\
        GOTO/50.000,20.000,0.000,0.4000000,0.0000000,0.9165151,0.6,0,0.8\n";
    let machine = Machine::new(Preset::by_id("ac-table").expect("a preset").parts()).expect("a machine");
    let tool = Tool::new(Length::from_mm(5.0), Length::from_mm(5.0)).expect("a ball");
    let parameters = CcParameters { tolerance: Length::from_mm(0.001), ..CcParameters::new(tool, at_zero()) };
    let mut output = Vec::new();
    let go_on = || ControlFlow::Continue(());
    compensate(&machine, &parameters, &program.as_bytes().to_vec(), &mut output, &go_on)
        .expect("compensated");
    let output = String::from_utf8(output).expect("text");
    assert!(
        output.lines().count() > 4 && output.contains("0.4000000,0.0000000,0.9165151,0.6,0.0,0.8\n"),
        "{output}"
    );
    for row in output.lines().filter_map(|line| line.strip_prefix("GOTO/")) {
        let values: Vec<f64> = row.split(',').map(|value| value.parse().expect("a number")).collect();
        let length = values[6..].iter().map(|value| value * value).sum::<f64>().sqrt();
        assert!((length - 1.0).abs() < 2e-4, "{row}");
    }
}
